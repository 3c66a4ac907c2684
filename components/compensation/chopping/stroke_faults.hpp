// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/chopping_codes.hpp"

namespace plumb {

// The faults of a stroke. One that happened stays until the next start.
class StrokeFaults {
public:
    // Those that are there as long as their cause.
    struct Lasting {
        bool position = false;  // it is invalid
        Fault settings = Fault::none;
        bool bound = false;  // a bound below the present offset
        Fault supervised = Fault::none;
    };

    // Also of a start: none, or why it was refused.
    void happen(Fault reason) noexcept { happened_ = reason; }

    // Of a stroke that is asked for and does not begin yet; none when it is not asked for any more.
    void check(Fault reason) noexcept { checked_ = reason; }

    // The one to show: the first that has a cause.
    Fault first(const Lasting& now) const noexcept {
        return checked_ != Fault::none       ? checked_
               : happened_ != Fault::none    ? happened_
               : now.position                ? Fault::position
               : now.settings != Fault::none ? now.settings
               : now.bound                   ? Fault::bound
                                             : now.supervised;
    }

    Fault checked() const noexcept { return checked_; }

private:
    Fault happened_ = Fault::none, checked_ = Fault::none;
};

}  // namespace plumb
