// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <limits>

namespace plumb {

// The clock of the time method. It starts when Z passes a height on its way to the work, between two
// samples if need be, or by start(). It also integrates the commanded path, which gives the time without
// feed: a feed hold, a tool change or an override shows as lost time, growth does not.
class ApproachClock {
public:
    void start() noexcept { begin(0, 0); }

    void stop() noexcept {
        running_ = false;
        height_ = -std::numeric_limits<double>::infinity();
    }

    // One period of dt > 0, in s. velocity in mu/s, signed, negative towards the work.
    void step(double velocity, double dt) noexcept {
        time_ += dt;
        path_ += velocity * dt;
    }

    // After step(): starts the clock again if `height` has come down to or through `start_height` in this
    // period. Heights in mu, without the applied offset.
    void start_below(double height, double start_height, double velocity, double dt) noexcept {
        if (height_ > start_height && height <= start_height)
            begin(velocity, dt * (start_height - height) / (height_ - height));
        height_ = height;
    }

    bool running() const noexcept { return running_; }
    double time() const noexcept { return running_ ? time_ : 0; }  // s

    // Time in s without feeding at `feed`, which must not be zero.
    double lost_time(double feed) const noexcept { return running_ ? time_ - path_ / feed : 0; }

private:
    void begin(double velocity, double ago) noexcept {
        running_ = true;
        time_ = ago;
        path_ = velocity * ago;
    }

    bool running_ = false;
    double time_ = 0;
    double path_ = 0;                                           // mu, signed
    double height_ = -std::numeric_limits<double>::infinity();  // in the last period; unknown: below all
};

}  // namespace plumb
