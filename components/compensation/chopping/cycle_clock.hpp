// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>

namespace plumb {

// The time of a cycle, and a pulse at each dead point.
class CycleClock {
public:
    void begin() noexcept { since_lower_ = -1; }

    void step(double dt) noexcept {
        for (double& left : pulse_left_) left = std::max(left - dt, 0.0);
        if (since_lower_ >= 0) since_lower_ += dt;
    }

    // A dead point, with a pulse of so many s.
    void arrive(bool upper, double pulse) noexcept {
        pulse_left_[upper] = pulse;
        if (upper) return;
        if (since_lower_ >= 0) time_ = since_lower_;
        since_lower_ = 0;
    }

    double time() const noexcept { return time_; }  // s, of the last cycle
    bool pulse(bool upper) const noexcept { return pulse_left_[upper] > 0; }

private:
    double time_ = 0, since_lower_ = -1;  // s; negative before the first lower dead point
    double pulse_left_[2] = {0, 0};
};

}  // namespace plumb
