// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// The error that lost motion leaves on a circle where an axis turns, corrected by squareness. The load stands
// until the motor has gone back by B, by its command and by the correction, which begins after h:
//
//     an t²/2 + a (t - th)²/2 = B      th = sqrt(2 h / an)      e = an t²/2      while the correction speeds
//     up e = 1/2 ((sqrt(2 h a) + 2 sqrt(B an)) / (sqrt a + sqrt an))²               while it slows down
//
// B lost motion, h reversal-distance, a reversal-acceleration, an = v²/R; the rate is not reached, and the
// drive follows at once. Without correction the circle has steps of B at the same places: half of B on either
// side of its mean.
struct CircleTurn {
    double lost, distance, acceleration;  // mm, mm, mm/s2

    // In mm, at a speed in mm/s on a radius in mm.
    double kept(double speed, double radius) const noexcept {
        const double an = speed * speed / radius, begin = std::sqrt(2 * distance / an);
        const double root = (an + acceleration) * 2 * lost - an * acceleration * begin * begin;
        if (!(root > 0)) return lost;  // it begins behind the turn
        const double t = (acceleration * begin + std::sqrt(root)) / (an + acceleration);
        if (t < begin) return lost;
        if (acceleration * (t - begin) * (t - begin) <= lost) return an * t * t / 2;
        return std::min(lost, below(an));
    }

    // The largest speed in mm/s at which a circle keeps at most `allowed`; 0 if it keeps more at any.
    double speed_for(double allowed, double radius) const noexcept {
        double low = 0, high = 1e4;
        if (kept(1e-6, radius) > allowed) return 0;
        for (int step = 0; step < 60; ++step) {
            const double middle = (low + high) / 2;
            (kept(middle, radius) <= allowed ? low : high) = middle;
        }
        return low;
    }

private:
    double below(double an) const noexcept {
        const double root = (std::sqrt(2 * distance * acceleration) + 2 * std::sqrt(lost * an)) /
                            (std::sqrt(acceleration) + std::sqrt(an));
        return root * root / 2;
    }
};

}  // namespace plumb
