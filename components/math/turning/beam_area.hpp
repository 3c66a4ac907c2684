// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/pi.hpp"

#include <cmath>
#include <limits>

namespace plumb {

// Diameters from the area of a laser beam before and behind the work, the work in the middle of the beam.
// NaN if the work is not inside the beam or covers less than nothing. Areas in mu2.

constexpr double no_diameter = std::numeric_limits<double>::quiet_NaN();

// A rectangular beam, `height` of which lies along the work; its width is emitted / height.
inline double diameter_in_rectangle(double emitted, double received, double height) noexcept {
    const bool inside = height > 0 && received > 0 && received < emitted;
    return inside ? (emitted - received) / height : no_diameter;
}

// Area that a strip of half width a, through the middle, covers of a circle.
inline double covered_of_circle(double a, double radius) noexcept {
    return 2 * (a * std::sqrt(radius * radius - a * a) + radius * radius * std::asin(a / radius));
}

// A round beam. Inverts covered_of_circle(), which rises and bends down, so that Newton's steps from 0 never
// go beyond the root.
inline double diameter_in_circle(double emitted, double received, double radius) noexcept {
    const double covered = emitted - received;
    if (!(radius > 0 && received > 0 && covered > 0 && covered < pi * radius * radius)) return no_diameter;
    double a = 0;
    for (int i = 0; i < 200; ++i) {
        const double slope = 4 * std::sqrt(radius * radius - a * a);
        const double step = slope > 0 ? (covered - covered_of_circle(a, radius)) / slope : 0;
        if (!(step > 1e-16 * radius)) break;
        a = a + step < radius ? a + step : radius;
    }
    return 2 * a;
}

}  // namespace plumb
