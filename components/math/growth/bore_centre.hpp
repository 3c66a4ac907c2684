// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace plumb {

// The centre of a bore, or of a boss or a sphere, from touches around it. Fixed size, no allocation.
class BoreTouches {
public:
    static constexpr int most = 16;

    struct Centre {
        double x = 0, y = 0;    // mu
        double radius = 0;      // mu, of the circle of the ball's centre
        double scatter = 0;     // mu, rms of the residuals per degree of freedom; 0 for three touches
        double x_per_unit = 0;  // standard uncertainty of x, divided by that of one touch
        double y_per_unit = 0;

        double bore_diameter(double ball) const noexcept { return 2 * radius + ball; }
    };

    // Centre of the ball at a touch, in mu. False if it is not finite or there are `most` already.
    bool add(double x, double y) noexcept {
        if (count_ == most || !std::isfinite(x) || !std::isfinite(y)) return false;
        points_[static_cast<std::size_t>(count_++)] = {x, y};
        return true;
    }
    void clear() noexcept { count_ = 0; }
    int count() const noexcept { return count_; }

    // The circle of least squares: (p - c)·e = r along e, the direction from the centre to each touch
    // (Gauss-Newton). Nothing with fewer than three touches, or if they lie in one line or on one side.
    std::optional<Centre> centre() const noexcept {
        if (count_ < 3) return std::nullopt;
        Eigen::Vector2d mean = Eigen::Vector2d::Zero();
        for (int i = 0; i < count_; ++i) mean += at(i) / count_;
        Eigen::Vector3d circle(mean.x(), mean.y(), 0);
        for (int i = 0; i < count_; ++i) circle[2] += (at(i) - mean).norm() / count_;
        const double size = circle[2];
        if (!(size > 0)) return std::nullopt;
        Eigen::Matrix3d normal;
        double square = 0;
        for (int round = 0; round < 20; ++round) {
            normal.setZero();
            Eigen::Vector3d right = Eigen::Vector3d::Zero();
            square = 0;
            for (int i = 0; i < count_; ++i) {
                const Eigen::Vector2d arm = at(i) - circle.head<2>();
                const double length = arm.norm();
                if (!(length > 1e-9 * size)) return std::nullopt;
                const Eigen::Vector3d row(arm.x() / length, arm.y() / length, 1);
                const double rest = length - circle[2];
                normal += row * row.transpose();
                right += row * rest;
                square += rest * rest;
            }
            const Eigen::LDLT<Eigen::Matrix3d> factors(normal);
            if (!(factors.vectorD().minCoeff() > 1e-6)) return std::nullopt;
            const Eigen::Vector3d step = factors.solve(right);
            circle += step;
            if (!(circle.allFinite() && (circle.head<2>() - mean).norm() < 10 * size)) return std::nullopt;
            if (step.norm() < 1e-12 * size) break;
        }
        const Eigen::Matrix3d cofactor = normal.ldlt().solve(Eigen::Matrix3d::Identity());
        Centre centre;
        centre.x = circle[0];
        centre.y = circle[1];
        centre.radius = circle[2];
        centre.scatter = count_ > 3 ? std::sqrt(square / (count_ - 3)) : 0;
        centre.x_per_unit = std::sqrt(cofactor(0, 0));
        centre.y_per_unit = std::sqrt(cofactor(1, 1));
        return centre;
    }

private:
    Eigen::Vector2d at(int i) const noexcept {
        const std::array<double, 2>& point = points_[static_cast<std::size_t>(i)];
        return {point[0], point[1]};
    }

    std::array<std::array<double, 2>, most> points_{};
    int count_ = 0;
};

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
