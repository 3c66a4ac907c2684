// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// Follows a target with a limited acceleration:  |ÿ| <= acceleration.
//
// It follows a target that obeys rate and acceleration itself without lag. It approaches any other one at
// most at `approach` relative to it, with a speed from which braking ends at the target. It awaits a target
// that comes back, and does not lead away from it: no sequence of targets adds up. The speed stays within
// ±rate, except while braking to a reduced rate: the acceleration wins.
class AccelerationLimit {
public:
    struct Limits {
        double approach, rate;  // mu/s, above 0
        double acceleration;    // mu/s2, above 0, and so is its product with dt
        double down = rate,
               up = rate;  // mu/s, at least 0: largest speeds down and up
    };

    // target finite, dt above 0.
    double step(double target, const Limits& limits, double dt) noexcept {
        const double change = target - target_;
        target_ = target;
        const double along = y_ + (std::abs(change) <= limits.rate * dt ? change : 0);  // faster is a step
        const double nearest = std::clamp(target, std::min(y_, along), std::max(y_, along));
        const double lag = target - nearest;

        const double loss = limits.acceleration * dt;  // of speed, in a period
        const double most = std::min(braking_speed(std::abs(lag) / dt, loss), limits.approach);
        const bool arrives = std::abs(lag) <= most * dt;
        const double wanted = (nearest - y_) / dt + (arrives ? lag / dt : std::copysign(most, lag));
        const double possible =
            std::clamp(wanted, -std::min(limits.rate, limits.down), std::min(limits.rate, limits.up));
        const double speed = std::clamp(possible, speed_ - loss, speed_ + loss);
        y_ = arrives && std::abs(speed - wanted) <= 1e-9 * loss ? target : y_ + speed * dt;
        speed_ = speed;
        return y_;
    }

    void hold() noexcept {
        speed_ = 0;
        target_ = y_;
    }

    // Goes to a value at once, for a limit beyond this one. The speed of that change stays, unless it leads
    // past 0: a jump must not become a journey.
    void move_to(double value, double acceleration, double dt) noexcept {
        speed_ += (value - y_) / dt;
        y_ = value;
        const double home = stopping_speed(std::abs(y_), acceleration, dt);
        if (y_ * speed_ <= 0) speed_ = std::clamp(speed_, -home, home);
    }

    double value() const noexcept { return y_; }

    // The speed from which a value stops within the distance `way`, at least 0, losing acceleration dt in
    // each period.
    static double stopping_speed(double way, double acceleration, double dt) noexcept {
        return braking_speed(way / dt, acceleration * dt);
    }

private:
    // The speed from which the distance s, in units of dt, is just enough to stop, losing `loss` in each
    // period: s = v + (v - loss) + (v - 2 loss) + ..., n + 1 terms above 0.
    static double braking_speed(double s, double loss) noexcept {
        const double n = std::floor((std::sqrt(1 + 8 * s / loss) - 1) / 2);
        return s / (n + 1) + loss * n / 2;
    }

    double y_ = 0, speed_ = 0, target_ = 0;
};

}  // namespace plumb
