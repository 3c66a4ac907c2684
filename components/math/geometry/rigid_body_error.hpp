// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <cmath>

namespace plumb {

// Rz(EC) Ry(EB) Rx(EA) of the angles (EA, EB, EC), in rad.
inline Eigen::Matrix3d rotation(const Eigen::Vector3d& angles) noexcept {
    const double ca = std::cos(angles.x()), sa = std::sin(angles.x());
    const double cb = std::cos(angles.y()), sb = std::sin(angles.y());
    const double cc = std::cos(angles.z()), sc = std::sin(angles.z());
    Eigen::Matrix3d r;
    r << cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa,  //
        sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa,   //
        -sb, cb * sa, cb * ca;
    return r;
}

// The vector ω of a rotation whose angles change at these rates: d/dt rotation(angles) = [ω]×
// rotation(angles).
inline Eigen::Vector3d angular_rate(const Eigen::Vector3d& angles, const Eigen::Vector3d& rates) noexcept {
    const double cb = std::cos(angles.y()), sb = std::sin(angles.y());
    const double cc = std::cos(angles.z()), sc = std::sin(angles.z());
    return {cc * cb * rates.x() - sc * rates.y(), sc * cb * rates.x() + cc * rates.y(),
            rates.z() - sb * rates.x()};
}

// Of ISO 230-1, for an axis A: (EXA, EYA, EZA) in mu and (EAA, EBA, ECA) in rad.
struct RigidBodyError {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    Eigen::Vector3d angles = Eigen::Vector3d::Zero();
};

// Rigid-body error of an axis near a position of it: best the one where the correction takes it.
struct AxisError {
    double position = 0;    // mu
    RigidBodyError value;   // there
    RigidBodyError slope;   // its change per mu
    RigidBodyError half{};  // its change with the direction of motion, from 0 to 1

    RigidBodyError at(double coordinate) const noexcept {
        const double distance = coordinate - position;
        return {value.translation + slope.translation * distance, value.angles + slope.angles * distance};
    }
};

}  // namespace plumb
