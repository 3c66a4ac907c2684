// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/pi.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// Harmonic reciprocation between two dead points, governed by its phase: 0 at the lower, pi at the upper dead
// point, 0 to pi upward, pi to 2 pi downward.
//
//     Z = lower + S sin^2(phase / 2)    v = F sin(phase)    d(phase)/dt = 2 F / S    T = pi S / F
//
// S = upper - lower > 0, mu; F > 0 is the peak speed, mu/s.
struct Reciprocation {
    double lower = 0, upper = 0;  // mu
    double speed = 0;             // mu/s, F

    double stroke() const noexcept { return upper - lower; }
    double position(double phase) const noexcept {
        const double s = std::sin(phase / 2);
        return lower + stroke() * s * s;
    }
    // Rad, 0 to 2 pi. A position beyond a dead point counts as the dead point.
    double phase(double position, bool upward) const noexcept {
        const double up = 2 * std::atan2(std::sqrt(std::max(position - lower, 0.0)),
                                         std::sqrt(std::max(upper - position, 0.0)));
        return upward ? up : 2 * pi - up;
    }
    // mu2/s2, the square of the speed at a position; 0 beyond a dead point.
    double speed_squared(double position) const noexcept {
        const double part = (position - lower) / stroke();
        return 4 * speed * speed * std::max(part * (1 - part), 0.0);
    }
    double peak_acceleration() const noexcept { return 2 * speed * speed / stroke(); }
    double cycle_time() const noexcept { return pi * stroke() / speed; }

    // The speeds F of a mean speed, and of a time for one cycle.
    static double speed_of_mean(double mean) noexcept { return mean * pi / 2; }
    static double speed_of_cycle(double time, double stroke) noexcept { return pi * stroke / time; }
};

}  // namespace plumb
