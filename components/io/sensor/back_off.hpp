// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>

namespace plumb {

// The time to wait after one failure, then twice as long after each further one, up to a longest time. Times
// in s.
class BackOff {
public:
    BackOff(double shortest, double longest) : shortest_(shortest), longest_(longest) {}

    void succeeded() noexcept {
        wait_ = 0;
        until_ = 0;
    }
    void failed(double now) noexcept {
        wait_ = wait_ > 0 ? std::min(2 * wait_, longest_) : shortest_;
        until_ = now + wait_;
    }
    double until() const noexcept { return until_; }

private:
    double shortest_, longest_;
    double wait_ = 0;
    double until_ = 0;
};

}  // namespace plumb
