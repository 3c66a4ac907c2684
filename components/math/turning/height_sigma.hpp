// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// Standard uncertainties of a cut and of its measurement, in mu; scale is a ratio.
struct CutSigmas {
    double gauge = 0;          // of a measured diameter
    double repeatability = 0;  // of the radius that a cut leaves, built-up edge included
    double travel = 0;         // of the distance between two positions of X
    double step = 0;           // of the distance between two positions of Y
    double drift = 0;          // of the radius and of the tip from cut to cut: wear, growth, lift
    double bend = 0;           // of the bend of work and tool, per depth of a pass
    double scale = 0;          // of the gauge's error from diameter to diameter, per difference of them

    double radius() const noexcept { return std::hypot(gauge / 2, repeatability); }
};

}  // namespace plumb
