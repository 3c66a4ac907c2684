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

    static constexpr double pulse_time = 0.02;  // s, which a PLC with a scan of 10 ms sees

    // A dead point, with or without infeed.
    void arrive(bool upper, bool infeed) noexcept {
        pulse_left_[upper] = infeed ? pulse_time : 0;
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
