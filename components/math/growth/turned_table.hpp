// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <optional>

namespace plumb {

// One bore at B0 and at B180. The table turns about Y: an error of the bore against the table's centre
// changes its sign in X and Z, an error of the centre against the spindle does not.
struct TurnedTable {
    Eigen::Vector3d half_sum;         // mu: in X and Z the table's centre against the spindle
    Eigen::Vector3d half_difference;  // mu: in X and Z the bore against the table's centre

    TurnedTable(const Eigen::Vector3d& at_0, const Eigen::Vector3d& at_180)
        : half_sum((at_0 + at_180) / 2), half_difference((at_0 - at_180) / 2) {}

    // Tilt about X in rad, of a bore at x = 0 with the distance z from the axis of B at B0. Nothing at the
    // axis.
    std::optional<double> tilt_about_x(double z) const {
        if (!(std::abs(z) > 0)) return std::nullopt;
        return -half_difference.y() / z;
    }
};

}  // namespace plumb
