// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <limits>

namespace plumb {

// How long Z has fed steadily on its way to the work since a disturbance: a feed hold, a stop, a turn of
// the override. After one, servo and load need a while before a rise of the load shows the surface of the
// work. A tool that was stopped in the work, before the load showed it, seems to meet it where it goes on.
// The start of an approach is no such disturbance: it is the same in each cycle.
class SteadyFeed {
public:
    // An approach begins.
    void begin() noexcept { *this = SteadyFeed(); }

    // One period of dt > 0, in s. velocity in mu/s; tolerance is the part of it that counts as steady.
    void step(double velocity, double tolerance, double dt) noexcept {
        lasted_ += dt;
        if (std::abs(velocity - velocity_) <= tolerance * std::abs(velocity_)) {
            started_ = started_ || lasted_ >= start_time;
            return;
        }
        disturbed_ = disturbed_ || started_;
        velocity_ = velocity;
        lasted_ = 0;
    }

    // In s; infinite without a disturbance.
    double time() const noexcept { return disturbed_ ? lasted_ : std::numeric_limits<double>::infinity(); }

private:
    static constexpr double start_time = 0.05;  // s that a start is steady when it is over

    double velocity_ = 0;
    double lasted_ = 0;
    bool started_ = false;
    bool disturbed_ = false;
};

}  // namespace plumb
