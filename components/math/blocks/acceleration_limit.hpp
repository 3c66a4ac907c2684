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
//
// It brakes before ±bound when, and only when, a later braking would end beyond, v² > 2 a (bound - y). In
// periods the speeds v, v - a dt, v - 2 a dt, ... down to 0 cover the shortest way to rest, and a target with
// |ÿ| <= a cannot stop in less. So one that itself stops at the bound is followed exactly.
class AccelerationLimit {
public:
    static constexpr double unbounded = 1e12;  // mu

    struct Limits {
        double approach, rate;  // mu/s, above 0
        double acceleration;    // mu/s2, above 0, and so is its product with dt
        double down = rate,
               up = rate;          // mu/s, at least 0: largest speeds down and up
        double bound = unbounded;  // mu, at least 0: of |y|, where stops_within() held with it before
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
        const double bound = std::copysign(limits.bound, wanted);
        double most_now = std::min(limits.rate, wanted < 0 ? limits.down : limits.up);
        if (!stops_easily(std::min(std::abs(wanted), most_now), bound, loss, dt))
            most_now = std::min(most_now, stopping_at(bound, loss, dt));
        const double possible = std::clamp(wanted, -most_now, most_now);
        const double speed = std::clamp(possible, speed_ - loss, speed_ + loss);
        const double rounding = 1e-9 * loss + 1e-15 * std::abs(target) / dt;
        const double next = arrives && std::abs(speed - wanted) <= rounding ? target : y_ + speed * dt;
        const double farthest = std::max(limits.bound, std::abs(y_)),
                     kept = std::clamp(next, -farthest, farthest);
        speed_ = kept == next ? speed : (kept - y_) / dt;
        return y_ = kept;
    }

    // Whether it can stop within ±bound.
    bool stops_within(double bound, double acceleration, double dt) const noexcept {
        const double loss = acceleration * dt;
        return std::abs(y_) <= bound && speed_ - loss <= stopping_at(bound, loss, dt) &&
               -speed_ - loss <= stopping_at(-bound, loss, dt);
    }

    // Whether it is at its target, or stops within a period.
    bool settled(double acceleration, double dt) const noexcept {
        return y_ == target_ || std::abs(speed_) <= acceleration * dt;
    }

    void hold() noexcept {
        speed_ = 0;
        target_ = y_;
    }

    // A target that has not moved to this place: the way to it is a step, also a short one.
    void aim(double target) noexcept { target_ = target; }

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
    // The speed towards a bound from which it stops there; 0 beyond it.
    double stopping_at(double bound, double loss, double dt) const noexcept {
        return braking_speed(way_to(bound) / dt, loss);
    }
    // False if it may have to brake; saves the root in nearly all periods. The way to rest from v is at most
    // (v² / loss + v + loss / 4) dt / 2.
    bool stops_easily(double speed, double bound, double loss, double dt) const noexcept {
        return 2 * loss * way_to(bound) >= (speed * (speed + loss) + 2 * loss * loss) * dt;
    }
    double way_to(double bound) const noexcept {
        return std::max(std::copysign(1, bound) * (bound - y_), 0.0);
    }

    // The speed from which the distance s, in units of dt, is just enough to stop, losing `loss` in each
    // period: s = v + (v - loss) + (v - 2 loss) + ..., n + 1 terms above 0.
    static double braking_speed(double s, double loss) noexcept {
        if (s < 0.99 * loss) return s;  // one term
        const double n = std::floor((std::sqrt(1 + 8 * s / loss) - 1) / 2);
        return s / (n + 1) + loss * n / 2;
    }

    double y_ = 0, speed_ = 0, target_ = 0;
};

}  // namespace plumb
