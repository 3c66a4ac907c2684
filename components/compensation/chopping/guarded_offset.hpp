// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/acceleration_limit.hpp"
#include "components/math/blocks/bounded.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// An offset that follows its target exactly, unless that breaks its bound or its rate.
class GuardedOffset {
public:
    // Impossible limits leave the last good ones in force.
    void allow(double most, double rate, double farthest) noexcept {
        if (most >= 0 && most <= farthest) most_ = most;
        if (rate >= 1e-3 && rate <= 1e6) rate_ = rate;
    }

    // `hardest` is the largest acceleration, mu/s2; an offset that is held does not follow.
    void step(double target, double hardest, bool holds, double dt) noexcept {
        const double before = value();
        if (holds) {
            guard_.hold();
        } else {
            guard_.step(bounded(target, most_), {rate_, rate_, hardest}, dt);
            const double bound = std::max(most_, std::abs(before));
            if (std::abs(value()) > bound) guard_.move_to(std::copysign(bound, value()), hardest, dt);
        }
        kept_back_ = std::abs(value() - target) > 1e-6;
    }

    double value() const noexcept { return guard_.value(); }
    bool kept_back() const noexcept { return kept_back_; }  // from its target

private:
    AccelerationLimit guard_;
    double most_ = 0, rate_ = 0;  // mu, mu/s
    bool kept_back_ = false;
};

}  // namespace plumb
