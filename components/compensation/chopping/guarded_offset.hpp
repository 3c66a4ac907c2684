// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/acceleration_limit.hpp"
#include "components/math/blocks/bounded.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// An offset that follows its target exactly, unless that breaks its bound, its rate or its acceleration.
class GuardedOffset {
public:
    struct Limits {
        double most, rate, acceleration;  // mu, mu/s, mu/s2
    };

    // Impossible limits leave the last good ones in force, and so does a limit by which the offset cannot
    // stop within its bound. The acceleration is possible. A smaller bound or rate waits until the motion
    // that was planned by the last one has ended, and a smaller acceleration until the offset then stands.
    void allow(const Limits& wanted, bool moves, double farthest, double dt) noexcept {
        const double most = limits_.most, hardest = limits_.acceleration;
        Limits given = wanted;
        const bool planned = moves && moved_;  // and not a motion that begins
        moved_ = moves;
        if (planned) {
            given.most = std::max(given.most, most);
            given.rate = std::max(given.rate, limits_.rate);
        }
        if (given.rate >= 1e-3 && given.rate <= 1e6) limits_.rate = given.rate;
        const bool ends = !moves && !stands_;
        if (given.acceleration >= hardest || (!ends && guard_.stops_within(most, given.acceleration, dt)))
            limits_.acceleration = given.acceleration;
        const bool possible = given.most >= 0 && given.most <= farthest;
        refused_ =
            possible && given.most < most && !guard_.stops_within(given.most, limits_.acceleration, dt);
        if (possible && !refused_) limits_.most = given.most;
    }

    // An offset that is held does not follow.
    void step(double target, bool holds, double dt) noexcept {
        const auto& [most, largest, acceleration] = limits_;
        const double rate = largest * (1 + rounding);  // a motion at the largest rate is no step
        if (holds)
            guard_.hold();
        else
            guard_.step(bounded(target, std::max(most, std::abs(value()))),
                        {rate, rate, acceleration, rate, rate, most}, dt);
        stands_ = value() == last_;
        last_ = value();
        kept_back_ = std::abs(value() - target) > 1e-6;
    }

    // The axis has been moved, perhaps beyond the bound.
    void put(double place) noexcept {
        guard_.move_to(place, 1, 1);
        guard_.hold();
    }

    // The offset has become a part of the position: it is 0, and nothing moves.
    void release() noexcept { guard_ = {}; }

    double value() const noexcept { return guard_.value(); }
    bool kept_back() const noexcept { return kept_back_; }  // from its target
    bool stands() const noexcept { return stands_; }        // in the last period
    bool refused() const noexcept { return refused_; }      // a bound below the present offset

private:
    static constexpr double rounding = 1e-9;

    AccelerationLimit guard_;
    Limits limits_{};
    double last_ = 0;
    bool moved_ = false, stands_ = true, kept_back_ = false, refused_ = false;
};

}  // namespace plumb
