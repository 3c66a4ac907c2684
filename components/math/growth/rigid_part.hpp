// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
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

// The rigid part of the deviations of several bores, with a scale along each axis:
//
//     dx = tx + sx x + ry z - rz y      dy = ty + sy y - rx z + rz x      dz = tz + sz z + rx y - ry x
struct RigidPart {
    static constexpr std::array<const char*, 9> names{"tx", "ty", "tz", "sx", "sy", "sz", "rx", "ry", "rz"};
    using Parameters = Eigen::Matrix<double, 9, 1>;  // t in mu, s and r in 1 (rad)

    Parameters value = Parameters::Zero();
    Parameters per_unit = Parameters::Zero();  // standard uncertainty, divided by that of a deviation
    std::array<bool, 9> determined{};          // by the places of the bores
    int rank = 0;
    Eigen::MatrixX3d rest;  // of each bore, in mu
    double rms = 0;         // mu, of the rest, per degree of freedom; 0 if there is none
};

// Displacement at a place (mu) = these rows times the parameters.
Eigen::Matrix<double, 3, 9> rigid_rows(const Eigen::Vector3d& place);

// By least squares: one row of `places` and one of `deviations` for each bore, in mu. What the places do not
// determine takes the smallest values, and `determined` says so. Needs at least one bore.
RigidPart rigid_part(const Eigen::MatrixX3d& places, const Eigen::MatrixX3d& deviations);

}  // namespace plumb
