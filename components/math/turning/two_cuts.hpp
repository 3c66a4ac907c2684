// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/turning/height_sigma.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

namespace plumb {

// Square of the distance of a corner of a triangle from the side `base`, where `a` and `b` are the other two
// sides; negative if they do not meet. Accurate for the flattest triangle (Kahan, "Miscalculating area and
// angles of a needle-like triangle"). Sides above 0.
inline double squared_height(double a, double b, double base) noexcept {
    double sides[] = {a, b, base};
    std::sort(std::begin(sides), std::end(sides));
    const double c = sides[0], m = sides[1], l = sides[2];
    return (l + (m + c)) * (c - (l - m)) * (c + (l - m)) * (l + (m - c)) / (4 * base * base);
}

// Distance |y| of the tip from the height of the work's axis, from the radii of two cuts and the travel in
// X between them (CN101351287A). The sign of y does not show: +y and -y leave equal radii. Lengths in mu.
struct TwoCuts {
    enum class Refusal : std::int32_t {
        none,
        order,         // the second cut did not go deeper: r2 >= r1, inside r2 <= r1
        travel,        // travel <= 0
        short_travel,  // travel < |r1 - r2|, beyond the uncertainty
        long_travel,   // travel > r1 + r2
        past_centre,   // the tip is beyond the axis at the second cut, inside at the first
    };

    double y_squared = 0;  // may be below 0 within its uncertainty
    double sigma_y_squared = 0;
    double x1 = 0, sigma_x1 = 0;                 // of the tip at the first cut
    double theta = 0;                            // rad, between X and the radius of the first cut
    double by_r1 = 0, by_r2 = 0, by_travel = 0;  // derivatives of y squared
    Refusal refusal = Refusal::none;

    double y() const noexcept { return std::sqrt(std::max(y_squared, 0.0)); }
    // "On centre within": the sigma of y where y is 0.
    double floor() const noexcept { return std::sqrt(sigma_y_squared); }
    double sigma() const noexcept {
        return y() > floor() ? sigma_y_squared / (2 * y()) : sigma_y_squared > 0 ? floor() : 0;
    }
    // Derivative of y by a quantity, from that of y squared; below the floor that at the floor.
    double sensitivity(double of_square) const noexcept {
        const double least = std::max(y(), floor());
        return least > 0 ? of_square / (2 * least) : 0;
    }

    // Both radii above 0. The last pass of the second cut is `deeper` than that of the first. `inside` is
    // internal turning, where X goes outward to cut deeper.
    static TwoCuts of(double r1, double r2, double travel, bool inside, const CutSigmas& sigmas,
                      double deeper = 0) noexcept {
        TwoCuts cuts;
        if (!(travel > 0)) return refused(Refusal::travel);
        if (inside ? !(r2 > r1) : !(r2 < r1)) return refused(Refusal::order);
        if (travel > r1 + r2) return refused(Refusal::long_travel);
        const double outward = inside ? travel : -travel;
        cuts.x1 = ((r2 - r1) * (r2 + r1) - travel * travel) / (2 * outward);
        const double x2 = cuts.x1 + outward;
        if (!(cuts.x1 >= 0 && x2 >= 0)) return refused(Refusal::past_centre);
        cuts.y_squared = squared_height(r1, r2, travel);
        cuts.by_r1 = 2 * x2 * r1 / outward;
        cuts.by_r2 = -2 * cuts.x1 * r2 / outward;
        cuts.by_travel = 2 * cuts.x1 * x2 / travel;
        const double radius = sigmas.radius();
        const double a = cuts.by_r1 * radius, b = cuts.by_r2 * radius, c = cuts.by_travel * sigmas.travel;
        // Half a drift before the middle of both cuts and half a drift behind it: of the radii, and of y.
        const double y = cuts.y(), half = sigmas.drift / 2;
        const double d = (cuts.by_r2 - cuts.by_r1) * half;
        const double e = (cuts.by_r2 * y / r2 - cuts.by_r1 * y / r1) * half;
        const double f = cuts.by_r2 * (r1 - r2) * sigmas.scale;
        const double g = cuts.by_r2 * deeper * sigmas.bend;
        cuts.sigma_y_squared = std::sqrt(a * a + b * b + c * c + d * d + e * e + f * f + g * g);
        if (cuts.y_squared < -3 * cuts.sigma_y_squared - rounding * r1 * r1)
            return refused(Refusal::short_travel);
        cuts.theta = std::atan2(cuts.y(), cuts.x1);
        const double x_by_r1 = -r1 / outward * radius, x_by_r2 = r2 / outward * radius;
        const double x_by_travel = (1 + cuts.x1 / outward) * sigmas.travel;
        const double x_by_drift = (r1 + r2) / outward * half,
                     x_by_scale = r2 * (r1 - r2) / outward * sigmas.scale;
        const double x_by_bend = r2 / outward * deeper * sigmas.bend;
        cuts.sigma_x1 = std::hypot(std::hypot(x_by_r1, x_by_r2, x_by_travel),
                                   std::hypot(x_by_drift, x_by_scale), x_by_bend);
        return cuts;
    }

private:
    static constexpr double rounding = 1e-12;

    static TwoCuts refused(Refusal reason) noexcept {
        TwoCuts cuts;
        cuts.refusal = reason;
        return cuts;
    }
};

}  // namespace plumb
