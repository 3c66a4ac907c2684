// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <cmath>
#include <optional>

namespace plumb {

// The centre of a bore or a boss (N = 2) or of a sphere (N = 3), from touches all around it: four of a bore;
// four at the equator of a sphere and one on top. Fixed size, no allocation.
template <int N>
class TouchesAround {
public:
    static constexpr int most = 16;
    using Place = Eigen::Matrix<double, N, 1>;

    struct Centre {
        Place place = Place::Zero();     // mu
        double radius = 0;               // mu, of the circle or sphere on which the ball's centre lies
        double scatter = 0;              // mu, rms of the residuals per degree of freedom; 0 if there is none
        Place per_unit = Place::Zero();  // standard uncertainty of place, to that of a touch
    };

    // Centre of the ball at a touch, in mu. False if it is not finite or there are `most` already.
    bool add(const Place& place) noexcept {
        if (count_ == most || !place.allFinite()) return false;
        touches_.col(count_++) = place;
        return true;
    }
    void clear() noexcept { count_ = 0; }
    int count() const noexcept { return count_; }

    // The circle or sphere of least squares: (p - c)·e = r along e, the direction from the centre to each
    // touch (Gauss-Newton). Nothing with fewer than N + 1 touches, or if they lie in one line or plane, or on
    // one side.
    std::optional<Centre> centre() const noexcept {
        using Fit = Eigen::Matrix<double, N + 1, 1>;
        using Square = Eigen::Matrix<double, N + 1, N + 1>;
        if (count_ <= N) return std::nullopt;
        Place mean = Place::Zero();
        for (int i = 0; i < count_; ++i) mean += touches_.col(i) / count_;
        double size = 0;
        for (int i = 0; i < count_; ++i) size += (touches_.col(i) - mean).norm() / count_;
        if (!(size > 0)) return std::nullopt;
        Fit fit;
        fit << mean, size;
        Square normal;
        double square = 0;
        for (int round = 0; round < 30; ++round) {
            normal.setZero();
            Fit right = Fit::Zero();
            square = 0;
            for (int i = 0; i < count_; ++i) {
                const Place arm = touches_.col(i) - fit.template head<N>();
                const double length = arm.norm(), rest = length - fit[N];
                if (!(length > 1e-9 * size)) return std::nullopt;
                Fit row;
                row << arm / length, 1;
                normal += row * row.transpose();
                right += row * rest;
                square += rest * rest;
            }
            const Eigen::LDLT<Square> factors(normal);
            if (!(factors.vectorD().minCoeff() > 1e-6)) return std::nullopt;
            const Fit step = factors.solve(right);
            fit += step;
            if (!(fit.allFinite() && (fit.template head<N>() - mean).norm() < 10 * size)) return std::nullopt;
            if (step.norm() < 1e-12 * size) break;
        }
        const Square cofactor = normal.ldlt().solve(Square::Identity());
        Centre centre;
        centre.place = fit.template head<N>();
        centre.radius = fit[N];
        centre.scatter = count_ > N + 1 ? std::sqrt(square / (count_ - N - 1)) : 0;
        centre.per_unit = cofactor.diagonal().template head<N>().cwiseSqrt();
        return centre;
    }

private:
    Eigen::Matrix<double, N, most, Eigen::DontAlign> touches_ =
        Eigen::Matrix<double, N, most, Eigen::DontAlign>::Zero();
    int count_ = 0;
};

using BoreTouches = TouchesAround<2>;
using SphereTouches = TouchesAround<3>;

}  // namespace plumb
