// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// A move along one axis with limited speed and acceleration. Target and limits may change at any time: a
// speed of 0 holds it, a target behind it makes it stop and turn.
class TrapezoidalMove {
public:
    explicit TrapezoidalMove(double position = 0) noexcept : position_(position) {}

    // Advances by dt > 0 seconds towards target, no faster than speed >= 0, with acceleration > 0.
    void step(double target, double speed, double acceleration, double dt) noexcept {
        const double left = target - position_;
        if (left == 0 && velocity_ == 0) return;  // the root costs most
        const double change = acceleration * dt;
        // The fastest that can still stop at the target: in this period and m more, each slower by `change`.
        const double m = std::floor(std::sqrt(0.25 + 2 * std::abs(left) / (change * dt)) - 0.5);
        const double stopping = std::abs(left) / dt / (m + 1) + 0.5 * change * m;
        const double wanted = std::copysign(std::min(speed, stopping), left);
        velocity_ = std::clamp(wanted, velocity_ - change, velocity_ + change);
        position_ += velocity_ * dt;
        if (std::abs(target - position_) < 1e-3 * change * dt && std::abs(velocity_) <= change)
            position_ = target;
    }

    // There, and at rest from the next period on.
    bool arrived(double target) const noexcept { return position_ == target; }

    double position() const noexcept { return position_; }
    double velocity() const noexcept { return velocity_; }  // of the last period, signed

private:
    double position_;
    double velocity_ = 0;
};

}  // namespace plumb
