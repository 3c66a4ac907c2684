// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/pi.hpp"
#include "components/math/geometry/axis_chain.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb {

// In rad.
inline double angle_from_arcsec(double arcsec) noexcept {
    return arcsec * pi / 648000;
}
inline double arcsec_from_angle(double angle) noexcept {
    return angle * 648000 / pi;
}

// Length per length of the same unit: 50 um/m is 50e-6, 0.02 mm per 300 mm is 0.02 / 300.
inline double angle_from_slope(double slope) noexcept {
    return std::atan(slope);
}
inline double slope_from_angle(double angle) noexcept {
    return std::tan(angle);
}

// The + end of an axis lies towards +X, -X, +Y ... by an angle, in rad, of 0 or more.
struct Lean {
    Axis towards = Axis::X;  // X, Y or Z
    int sign = 1;            // +1 or -1
    double angle = 0;
};

inline std::string name(const Lean& lean) {
    return std::string(lean.sign < 0 ? "-" : "+") + letter(lean.towards);
}

// ISO 230-1's name of a rotation 0, 1 or 2, about X, Y or Z, as in EC0Y.
inline std::string squareness_name(Axis axis, int rotation) {
    return std::string("E") + "ABC"[rotation] + "0" + letter(axis);
}

// The vector about which an axis turns that leans there: its only component is the quantity's sign.
inline Eigen::Vector3d turning(Axis axis, const Lean& lean) noexcept {
    return Eigen::Vector3d::Unit(direction(axis))
        .cross(Eigen::Vector3d(lean.sign * Eigen::Vector3d::Unit(direction(lean.towards))));
}

// The angles (EA0, EB0, EC0), in rad, of an axis that leans there. Throws std::invalid_argument with axis,
// direction and value if it leans along itself, by no proper angle, or twice along a line.
inline Eigen::Vector3d squareness(Axis axis, const std::vector<Lean>& leans) {
    const std::string subject = std::string("axis ") + letter(axis);
    Eigen::Vector3d angles = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < leans.size(); ++i) {
        const Lean& lean = leans[i];
        if (parallel(axis, lean.towards))
            throw std::invalid_argument(subject + " cannot lean towards " + name(lean) +
                                        ": it moves along it");
        if (!(lean.angle >= 0 && lean.angle < 0.1))
            throw std::invalid_argument(subject + " cannot lean towards " + name(lean) + " by " +
                                        std::to_string(lean.angle) + " rad: 0 to 0.1 is possible");
        for (std::size_t k = 0; k < i; ++k) {
            if (leans[k].towards != lean.towards) continue;
            throw std::invalid_argument(
                subject +
                (leans[k].sign == lean.sign
                     ? " leans towards " + name(lean) + " twice"
                     : " cannot lean towards " + name(leans[k]) + " and " + name(lean) + " at once") +
                ": choose one");
        }
        angles += turning(axis, lean) * lean.angle;
    }
    return angles;
}

// Where an axis with these angles leans to, and by how much; a turn about the axis itself is no lean.
inline std::vector<Lean> leans(Axis axis, const Eigen::Vector3d& angles) {
    std::vector<Lean> result;
    for (const Axis towards : {Axis::X, Axis::Y, Axis::Z}) {
        if (parallel(axis, towards)) continue;
        const double angle = turning(axis, {towards, 1, 0}).dot(angles);
        if (angle != 0) result.push_back({towards, angle < 0 ? -1 : 1, std::abs(angle)});
    }
    return result;
}

}  // namespace plumb
