// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// Which part of the offset in force is the stage's own, and which its guest's.  LinuxCNC shows the sum alone.
//
// While the guest is at rest its part is what it asks for, and the own part is the rest: also what a soft
// limit takes away.  While the guest is under way the own part, which is slow, follows its request first, and
// the guest has the rest.
class OffsetShares {
public:
    struct Requests {
        double own, guest;
        bool held;  // the guest stops where it is, and asks for no more
    };

    // LinuxCNC has forgotten all offsets.
    void forget() noexcept {
        own_ = guest_ = 0;
        under_way_ = false;
    }

    // The guest's part turns out to be this.
    void correct(double guest) noexcept {
        own_ += guest_ - guest;
        guest_ = guest;
        under_way_ = false;
    }

    // `own_step` is the largest change of the own part in a period, `grain` the step of a count.
    void divide(double in_force, const Requests& requests, double own_step, double grain) noexcept {
        const double step = in_force - own_ - guest_;
        const double way = bounded(requests.own - own_, std::max(std::abs(step), own_step));
        const double by_guest = step == 0 ? 0 : step - way;
        if (requests.held)  // it brakes, until it stands or turns
            under_way_ = under_way_ && by_guest * last_ > 0;
        else
            under_way_ = std::abs(requests.guest - guest_) > grain;
        last_ = by_guest;
        if (under_way_)
            guest_ += by_guest;
        else if (!requests.held)
            guest_ = requests.guest;
        own_ = in_force - guest_;
    }

    double own() const noexcept { return own_; }
    double guest() const noexcept { return guest_; }

private:
    double own_ = 0, guest_ = 0;
    double last_ = 0;  // the guest's last step
    bool under_way_ = false;
};

}  // namespace plumb
