// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>

namespace plumb {

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
