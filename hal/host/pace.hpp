// SPDX-License-Identifier: GPL-2.0-or-later
// Ties virtual time to the computer's clock: it passes `speed` times as fast. A host that the computer does
// not let keep up goes through the periods that it owes one after the other. It gives up all beyond a
// limit, so that user-space programs never see it race through seconds.
#pragma once

#include <chrono>

#include "hal/host/time.hpp"

namespace plumb::host {

inline constexpr double least_speed = 0.01;
inline constexpr double most_speed = 1000.0;

// For modules that ask for it (hal/clock_speed.hpp); 1 until it is set.
void set_clock_speed(double speed);

class Pace {
public:
    using Clock = std::chrono::steady_clock;

    // `speed` lies between the two; infinity lets time pass as fast as the host can.
    explicit Pace(double speed);

    bool free() const;

    // The virtual instant at the clock's `now`; `never` when free.
    Nanoseconds instant(Clock::time_point now) const;

    // The same for a host that stands at `reached` and owes all periods since: gives up all beyond the
    // limit.
    Nanoseconds due(Clock::time_point now, Nanoseconds reached);

    // How much of the computer's time has been given up so far.
    std::chrono::nanoseconds given_up() const { return given_up_; }

    // How long the clock's `now` is before virtual `instant`; negative when that has passed.
    std::chrono::nanoseconds until(Nanoseconds instant, Clock::time_point now) const;

private:
    double speed_;
    Clock::time_point origin_;
    Nanoseconds origin_instant_ = 0;
    std::chrono::nanoseconds given_up_{0};
};

}  // namespace plumb::host
