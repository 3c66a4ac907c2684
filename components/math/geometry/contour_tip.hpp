// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <cmath>

namespace plumb {

// The vector T_D from the axis of a tool to its tip on the contour, under cutter radius compensation:
//
//     T_D = radius · (v_b, -v_a) / |v|      v: velocity along the first and second axis, a and b, of the
//     plane
//
// The path of the axis runs beside the contour, so the tip lies square to the path. radius is above 0 with
// G41, where the tool is left of the contour, and below 0 with G42. The axes of the planes are X and Y (G17),
// Z and X (G18), Y and Z (G19).
//
// At rest, and in motion across the plane, the last direction stays. There is none before the first motion,
// and after a radius of 0 or in another plane the next motion gives it.
class ContourTip {
public:
    static bool is_plane(double number) noexcept { return number == 17 || number == 18 || number == 19; }

    // velocity finite, in mu/s; radius finite, in mu; plane 17, 18 or 19.
    void step(const Eigen::Vector3d& velocity, double radius, int plane) noexcept {
        const int a = plane == 17 ? 0 : plane == 18 ? 2 : 1, b = (a + 1) % 3;
        if (radius == 0 || plane != plane_) right_.setZero();
        plane_ = plane;
        const double speed = std::hypot(velocity[a], velocity[b]);
        if (radius != 0 && speed > still) {
            right_.setZero();
            right_[a] = velocity[b] / speed;
            right_[b] = -velocity[a] / speed;
        }
        vector_ = radius * right_;
    }

    const Eigen::Vector3d& vector() const noexcept { return vector_; }  // mu

private:
    static constexpr double still = 1e-6;  // mu/s; below it rounding would give the direction

    int plane_ = 17;
    Eigen::Vector3d right_ = Eigen::Vector3d::Zero(), vector_ = Eigen::Vector3d::Zero();
};

}  // namespace plumb
