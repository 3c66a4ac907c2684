// SPDX-License-Identifier: GPL-2.0-or-later
// Errors of the guide of a simulated axis, which is never quite straight.
//
// Polynomials of Legendre over the travel, with drawn coefficients. Those of straightness begin with the
// second, so that it has neither offset nor slope, and the axis is exactly as square as its tilt.
#pragma once

#include "components/math/blocks/random.hpp"
#include "components/plants/drawn.hpp"
#include "components/plants/sim_portal/rigid_machine.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace plumb {

// A curve over u from -1 to 1 whose highest point is 1 above its lowest.
class DrawnCurve {
public:
    // `first`: the lowest of its three polynomials.
    void draw(Random& random, std::size_t first) noexcept {
        coefficients_ = {};
        for (std::size_t i = first; i < first + 3; ++i) coefficients_[i - 1] = random.uniform(-1, 1);
        double lowest = at(-1), highest = lowest;
        for (int i = 1; i <= points; ++i) {
            const double value = at(2.0 * i / points - 1);
            lowest = std::min(lowest, value);
            highest = std::max(highest, value);
        }
        for (double& c : coefficients_) c /= std::max(highest - lowest, 1e-6);
    }

    double at(double u) const noexcept {
        double sum = 0, before = 1, p = u;
        for (std::size_t i = 0; i < coefficients_.size(); ++i) {
            sum += coefficients_[i] * p;
            const double n = static_cast<double>(i) + 1;
            const double next = ((2 * n + 1) * u * p - n * before) / (n + 1);
            before = p;
            p = next;
        }
        return sum;
    }

private:
    static constexpr int points = 64;

    std::array<double, 4> coefficients_{};  // of the polynomials 1 to 4
};

class GuideErrors final : public hal::Group {
public:
    GuideErrors(hal::Owner owner, int direction) : Group(owner), direction_(direction) {}

    void draw(std::int32_t seed) noexcept {
        seed_ = seed;
        Random random(static_cast<std::uint32_t>(seed), static_cast<std::uint64_t>('g' + direction_ * 256));
        for (DrawnCurve& curve : straight_) curve.draw(random, 2);
        for (DrawnCurve& curve : turning_) curve.draw(random, 1);
    }

    // Between two places of the travel, given as -1 to 1 of it.
    GuideMotion between(double from, double to) noexcept {
        GuideMotion motion;
        for (int i = 0; i < 2; ++i) {
            const int across = (direction_ + 1 + i) % 3;
            const auto k = static_cast<std::size_t>(i);
            motion.translation[across] = straightness_(seed_) * (straight_[k].at(to) - straight_[k].at(from));
            motion.turn[across] = pitch_yaw_(seed_) * (turning_[k].at(to) - turning_[k].at(from));
        }
        return motion;
    }

private:
    Drawn straightness_{this,
                        "%-straightness",
                        0,
                        0.002,
                        0.005,
                        "mu",
                        "Range of straightness over the travel, both ways across"};
    Drawn pitch_yaw_{this, "%-pitch-yaw", 0, 5e-6, 20e-6, "rad", "Range of pitch and yaw over the travel"};
    const int direction_;
    std::int32_t seed_ = 0;
    std::array<DrawnCurve, 2> straight_, turning_;
};

}  // namespace plumb
