// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/stroke_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumb {

// A stop from a moment of a stroke, with a constant deceleration.
class Braking {
public:
    Braking() = default;
    // The deceleration is above 0, mu/s2.
    Braking(const StrokePlan::Moment& begin, double deceleration) noexcept
        : begin_(begin), deceleration_(deceleration) {}

    double duration() const noexcept { return std::abs(begin_.velocity) / deceleration_; }  // s
    double end() const noexcept {
        return begin_.position + begin_.velocity * std::abs(begin_.velocity) / (2 * deceleration_);
    }

    // At `time` s from its begin; behind its end it rests.
    StrokePlan::Moment at(double time) const noexcept {
        const double sign = begin_.velocity > 0 ? 1 : -1, speed = std::abs(begin_.velocity);
        const double t = std::min(time, duration());
        const double position = begin_.position + sign * (speed - deceleration_ * t / 2) * t;
        if (time >= duration()) return {position, 0, 0};
        return {position, sign * (speed - deceleration_ * t), -sign * deceleration_};
    }

    // The deceleration that ends in a way, mu, from a speed, mu/s; infinite without a way.
    static double needed(double way, double speed) noexcept {
        return way > 0 ? speed * speed / (2 * way) : std::numeric_limits<double>::infinity();
    }

private:
    StrokePlan::Moment begin_{};
    double deceleration_ = 1;
};

}  // namespace plumb
