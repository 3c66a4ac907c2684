// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/oscillation_settings.hpp"

namespace plumb {

// How a motion ends, and which hold stops it. A fault stops it at once. A lost permission, or an order to go
// to the end, withdraws it, and neither is taken back before it rests.
class Ending {
public:
    using Stop = OscillationSettings::Stop;

    // Of one period.
    struct Orders {
        bool runs, permitted;
        bool withdraws;  // an edge
        Stop usual;      // if it does not run
    };

    void begin() noexcept { *this = {}; }
    void fail() noexcept { failed_ = true; }

    // The stop from now on; none leaves it as it is.
    Stop step(const Orders& now) noexcept {
        lost_ |= !now.permitted;
        ordered_ |= now.withdraws;
        passed_ |= now.withdraws;
        if (failed_) return Stop::at_once;
        if (withdraws()) return Stop::withdraw;
        return now.runs ? Stop::none : now.usual;
    }

    // An order goes before the hold that is there, and a later hold before the order.
    bool holds(bool hold) noexcept {
        passed_ &= hold;
        return hold && !passed_ && !lost_;
    }

    bool withdraws() const noexcept { return lost_ || ordered_; }

private:
    bool failed_ = false, lost_ = false, ordered_ = false, passed_ = false;
};

}  // namespace plumb
