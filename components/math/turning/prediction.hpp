// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/turning/cut_fit.hpp"
#include "components/math/turning/height_sigma.hpp"
#include "components/math/turning/two_cuts.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// The radius that a further cut is expected to leave, and the standard uncertainty of the difference to the
// measured one. Lengths in mu.
struct Prediction {
    double radius = 0, sigma = 0;

    // Distance of a measured radius from the expected one, in sigmas.
    double disagreement(double measured) const noexcept { return std::abs(measured - radius) / sigma; }
};

// A further cut: place of the tip against the first cut, with skewed axes resolved, and its number.
struct FurtherCut {
    double dx = 0, dy = 0;
    double deeper = 0;  // its last pass than that of the first cut
    double drifts = 0;  // cuts between the middle of the known ones, or the first of two, and this one
};

inline double square(double z) noexcept {
    return z * z;
}

// By two cuts, x1 and y squared of which are known. `y` is the signed height of the tip at the first cut.
// `outward` is 1 for internal turning, where X goes outward to cut deeper, else -1. The radius is 0 if the
// tip does not meet the work.
inline Prediction predict(const TwoCuts& two, const Cut& first, const Cut& second, double travel,
                          double outward, double y, double sigma_y, const FurtherCut& further,
                          const CutSigmas& sigmas) noexcept {
    const double dx = further.dx, dy = further.dy, x = two.x1 + dx;
    const double radius = std::sqrt(std::max(x * x + two.y_squared + 2 * y * dy + dy * dy, 0.0));
    if (!(radius > 0)) return {};
    // Of the squared radius by r1, r2 and the travel, then by its own radius and travel.
    const double per_r1 = 2 * first.radius * (1 - dx * outward / travel);
    const double per_r2 = 2 * second.radius * dx * outward / travel;
    const double per_travel = -2 * dx * (two.x1 + outward * travel) / travel;
    const double s = sigmas.radius(), t = sigmas.travel;
    const double of_step = 2 * (y + dy) * (dy != 0 ? sigmas.step : 0);
    const double of_y = dy != 0 ? 2 * dy * sigma_y : 0;
    const double of_drift = (per_r2 - 2 * radius * further.drifts) * sigmas.drift;
    const double of_scale =
        (per_r2 * (second.radius - first.radius) - 2 * radius * (radius - first.radius)) * sigmas.scale;
    const double noise =
        std::sqrt(per_r1 * per_r1 * s * s + per_r2 * per_r2 * s * s + per_travel * per_travel * t * t +
                  square(2 * radius * further.deeper * sigmas.bend) + 4 * radius * radius * s * s +
                  4 * x * x * t * t + of_step * of_step + of_y * of_y + of_drift * of_drift +
                  of_scale * of_scale) /
        (2 * radius);
    return {radius, std::max(noise, 1e-9 * radius)};
}

// By a fit of the other cuts. `first` and `measured` are the radii of the first cut and of the further one.
inline Prediction predict(const CutFit& others, double first, double measured, const FurtherCut& further,
                          const CutSigmas& sigmas) noexcept {
    const double own = std::hypot(std::hypot(sigmas.radius(), sigmas.drift * further.drifts),
                                  sigmas.scale * (measured - first), sigmas.bend * further.deeper);
    return {others.predicted(further.dx, further.dy),
            std::hypot(others.sigma_predicted(further.dx, further.dy), own, 1e-9 * measured)};
}

}  // namespace plumb
