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

    // A program asks whether a stroke may begin. The refusal of the stroke stays until the next start, since
    // the program is aborted before anybody has read the reason. It does not stay where another fault is
    // shown.
    void check(bool asked, Fault reason, bool lasts = true) noexcept {
        checked_ = asked ? reason : Fault::none;
        if (asked && lasts) happened_ = reason;
    }

    // The one to show: the first that has a cause.
    Fault first(const Lasting& now) const noexcept {
        return happened_ != Fault::none      ? happened_
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
