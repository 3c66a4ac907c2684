// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>

namespace plumb {

// What becomes of an offset at rest while its joint is not homed. It stays for a moment; a stage that ramps
// it down meanwhile has taken it away then, and nothing is to be there when the joint is homed again.
class HomedWatch {
public:
    enum class Offset { stays, as_applied, none };

    // One period of dt s.
    Offset step(bool homed, bool ramps, double dt) noexcept {
        if (homed) {
            const bool returned = unhomed_ > 0;
            unhomed_ = 0;
            return returned ? Offset::as_applied : Offset::stays;
        }
        unhomed_ = std::min(unhomed_ + dt, 2 * patience);
        return ramps && unhomed_ > patience ? Offset::none : Offset::stays;
    }

private:
    static constexpr double patience = 1;  // s, with a joint that is not homed

    double unhomed_ = 0;  // s, since homed was lost
};

}  // namespace plumb
