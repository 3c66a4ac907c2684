// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>

namespace plumb {

// What becomes of an offset at rest while its joint is not homed. A joint that is not homed for a moment
// stays where it is. A stage that does not hold the offset ramps it down meanwhile; an extra joint stands,
// unless it is moved: homed. Then nothing is to be there when it is homed again.
class HomedWatch {
public:
    enum class Offset { stays, as_applied, none };

    // Of a period.
    struct Now {
        bool homed = false;
        bool releasable = false;  // a stage holds the offset until machine off makes it part of the position
        bool stage = false;       // the joint has the offset by a stage
        bool measurable = false;
        double lag = 0;  // mu, of the axis behind its command
    };

    Offset step(const Now& now, double dt) noexcept {
        if (now.homed) {
            const bool returned = unhomed_ > 0;
            unhomed_ = 0;
            return returned ? Offset::as_applied : Offset::stays;
        }
        if (unhomed_ == 0) lag_ = now.lag;
        unhomed_ = std::min(unhomed_ + dt, 2 * patience);
        if (now.releasable) return Offset::stays;
        const bool gone = now.stage ? unhomed_ > patience : now.measurable && now.lag > lag_ + standing;
        return gone ? Offset::none : Offset::stays;
    }

private:
    static constexpr double patience = 1;     // s, with a joint that is not homed
    static constexpr double standing = 0.01;  // mu, of an axis that nothing moves

    double unhomed_ = 0, lag_ = 0;  // s since homed was lost; mu, of the axis then
};

}  // namespace plumb
