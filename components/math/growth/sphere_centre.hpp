// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace plumb {

// The centre of a sphere from touches all around it, such as four at its equator and one on top. Fixed size,
// no allocation.
class SphereTouches {
public:
    static constexpr int most = 16;

    struct Centre {
        Eigen::Vector3d place{0, 0, 0};  // mu
        double radius = 0;               // mu, of the sphere on which the ball's centre lies
        double scatter = 0;              // mu, rms of the residuals per degree of freedom; 0 for four touches
        Eigen::Vector3d per_unit{0, 0, 0};  // standard uncertainty of place, divided by that of one touch

        double diameter(double ball) const noexcept { return 2 * radius - ball; }  // mu, of the sphere
    };

    // Centre of the ball at a touch, in mu. False if it is not finite or there are `most` already.
    bool add(const Eigen::Vector3d& place) noexcept {
        if (count_ == most || !place.allFinite()) return false;
        points_[static_cast<std::size_t>(count_++)] = {place.x(), place.y(), place.z()};
        return true;
    }
    int count() const noexcept { return count_; }

    // The sphere of least squares: (p - c)·e = r along e, the direction from the centre to each touch
    // (Gauss-Newton). Nothing with fewer than four touches, or if they lie in one plane or on one side.
    std::optional<Centre> centre() const noexcept {
        if (count_ < 4) return std::nullopt;
        Eigen::Vector4d sphere = start();
        Eigen::Matrix4d normal;
        double square = 0;
        for (int round = 0; round < 30; ++round) {
            normal.setZero();
            Eigen::Vector4d right = Eigen::Vector4d::Zero();
            square = 0;
            for (int i = 0; i < count_; ++i) {
                const Eigen::Vector3d arm = at(i) - sphere.head<3>();
                const double length = arm.norm();
                if (!(length > 1e-9 * std::abs(sphere[3]))) return std::nullopt;
                const Eigen::Vector4d row(arm.x() / length, arm.y() / length, arm.z() / length, 1);
                const double rest = length - sphere[3];
                normal += row * row.transpose();
                right += row * rest;
                square += rest * rest;
            }
            const Eigen::LDLT<Eigen::Matrix4d> factors(normal);
            if (!(factors.vectorD().minCoeff() > 1e-6)) return std::nullopt;
            const Eigen::Vector4d step = factors.solve(right);
            sphere += step;
            if (!sphere.allFinite() || !(sphere[3] > 0)) return std::nullopt;
            if (step.norm() < 1e-12 * sphere[3]) break;
        }
        Centre centre;
        centre.place = sphere.head<3>();
        centre.radius = sphere[3];
        centre.scatter = count_ > 4 ? std::sqrt(square / (count_ - 4)) : 0;
        centre.per_unit = normal.ldlt().solve(Eigen::Matrix4d::Identity()).diagonal().head<3>().cwiseSqrt();
        return centre;
    }

private:
    Eigen::Vector3d at(int i) const noexcept {
        const std::array<double, 3>& point = points_[static_cast<std::size_t>(i)];
        return {point[0], point[1], point[2]};
    }

    // By linear least squares, about the mean: |p|² = 2 p·c + (r² - |c|²).
    Eigen::Vector4d start() const noexcept {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        for (int i = 0; i < count_; ++i) mean += at(i) / count_;
        Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
        Eigen::Vector4d right = Eigen::Vector4d::Zero();
        for (int i = 0; i < count_; ++i) {
            const Eigen::Vector3d p = at(i) - mean;
            const Eigen::Vector4d row(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
            normal += row * row.transpose();
            right += row * p.squaredNorm();
        }
        const Eigen::Vector4d found = normal.ldlt().solve(right);
        const Eigen::Vector3d centre = found.head<3>();
        Eigen::Vector4d sphere;
        sphere << centre + mean, std::sqrt(std::max(found[3] + centre.squaredNorm(), 0.0));
        return sphere;
    }

    std::array<std::array<double, 3>, most> points_{};
    int count_ = 0;
};

}  // namespace plumb
