// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/chopping_codes.hpp"

namespace plumb {

// The faults of a stroke. One that happened stays until the next start, a refused start until run is false.
class StrokeFaults {
public:
    // A start, or its refusal.
    void start(Fault reason) noexcept {
        happened_ = reason;
        refused_ = reason != Fault::none;
    }
    void happen(Fault reason) noexcept { happened_ = reason; }

    // Of a stroke that is asked for and does not begin yet; none when it is not asked for any more.
    void check(Fault reason) noexcept { checked_ = reason; }

    void step(bool run) noexcept {
        if (!run && refused_) start(Fault::none);
    }

    Fault happened() const noexcept { return happened_; }
    Fault checked() const noexcept { return checked_; }
    bool refused() const noexcept { return refused_; }  // the start

private:
    Fault happened_ = Fault::none, checked_ = Fault::none;
    bool refused_ = false;
};

}  // namespace plumb
