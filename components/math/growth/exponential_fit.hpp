// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace plumb {

// y = a + b (1 - exp(-t / τ)). a is free: the first value is as noisy as the others.
struct ExponentialFit {
    double a = 0, b = 0;    // unit of y
    double tau = 0;         // s
    double steady = 0;      // a + b
    double steady_low = 0;  // the interval of steady that covers 95 of 100: not symmetric
    double steady_high = 0;
    double scatter = 0;       // standard deviation of a value about the curve
    double rate = 0;          // per s, at the last time
    double time_to_95 = 0;    // s from t = 0 until 95 % of b
    bool determined = false;  // false: the curve does not bend enough, and the interval has no end

    double at(double t) const noexcept { return a - b * std::expm1(-t / tau); }
    // Half of the longer side of the interval: the standard uncertainty of steady, infinite if undetermined.
    double steady_uncertainty() const noexcept {
        if (!determined) return std::numeric_limits<double>::infinity();
        return std::max(steady_high - steady, steady - steady_low) / 2;
    }
};

namespace exponential_fit {

// Student's t that leaves 4.55 % outside on both sides together, as 2 standard deviations of a normal value
// do; within 1 % for 2 and more degrees of freedom (Cornish-Fisher).
inline double coverage_factor(Eigen::Index freedom) noexcept {
    if (freedom <= 1) return 13.97;
    if (freedom == 2) return 4.527;
    if (freedom == 3) return 3.307;
    const double n = static_cast<double>(freedom), z = 2, z2 = z * z;
    return z + z * (z2 + 1) / (4 * n) + z * (5 * z2 * z2 + 16 * z2 + 3) / (96 * n * n) +
           z * (3 * z2 * z2 * z2 + 19 * z2 * z2 + 17 * z2 - 15) / (384 * n * n * n);
}

struct Line {
    double a = 0, b = 0, square = 0, steady_variance = 0;  // the variance by that of a value
    bool good = false;
};

inline Line line_at(const Eigen::VectorXd& t, const Eigen::VectorXd& y, double tau) {
    Eigen::MatrixXd design(t.size(), 2);
    design.col(0).setOnes();
    design.col(1) = -((-t.array() / tau).exp() - 1);
    const Eigen::Matrix2d normal = design.transpose() * design;
    Line line;
    const double determinant = normal(0, 0) * normal(1, 1) - normal(0, 1) * normal(1, 0);
    if (!(determinant > 1e-14 * normal(0, 0) * normal(0, 0))) return line;
    const Eigen::Vector2d both = normal.ldlt().solve(design.transpose() * y);
    line.a = both[0];
    line.b = both[1];
    line.square = (y - design * both).squaredNorm();
    line.steady_variance = normal.ldlt().solve(Eigen::Vector2d::Ones()).sum();
    line.good = std::isfinite(line.square) && line.steady_variance > 0;
    return line;
}

}  // namespace exponential_fit

// Fits by variable projection over τ, from a 50th of the time of observation to 10 times it. The interval of
// the steady state is that of the profile likelihood: every value that some τ makes as probable.
// `uncertainty` is that of a value; 0 if unknown, else the scatter about the curve counts where it is larger.
// Times in s, of any origin t >= 0. Nothing with fewer than 5 values, or values at one time, or values that
// are not finite.
inline std::optional<ExponentialFit> fit_exponential(const Eigen::VectorXd& t, const Eigen::VectorXd& y,
                                                     double uncertainty = 0) {
    using exponential_fit::Line;
    constexpr int steps = 400;
    constexpr double shortest = 1.0 / 50, longest = 10;
    if (t.size() < 5 || t.size() != y.size() || !t.allFinite() || !y.allFinite()) return std::nullopt;
    const double span = t.maxCoeff() - t.minCoeff();
    if (!(span > 0)) return std::nullopt;
    const auto tau_of = [&](int i) {
        return span * shortest * std::pow(longest / shortest, double(i) / steps);
    };
    Eigen::Matrix<double, steps + 1, 1> squares;
    int best = -1;
    for (int i = 0; i <= steps; ++i) {
        const Line line = exponential_fit::line_at(t, y, tau_of(i));
        squares[i] = line.good ? line.square : std::numeric_limits<double>::infinity();
        if (line.good && (best < 0 || squares[i] < squares[best])) best = i;
    }
    if (best < 0) return std::nullopt;
    const Line line = exponential_fit::line_at(t, y, tau_of(best));
    const Eigen::Index freedom = t.size() - 3;
    const double found = std::sqrt(line.square / static_cast<double>(freedom));
    ExponentialFit fit;
    fit.a = line.a;
    fit.b = line.b;
    fit.tau = tau_of(best);
    fit.steady = line.a + line.b;
    fit.scatter = std::max({found, uncertainty, 1e-12 * y.cwiseAbs().maxCoeff()});
    fit.rate = line.b / fit.tau * std::exp(-t.maxCoeff() / fit.tau);
    fit.time_to_95 = fit.tau * std::log(20.0);
    // With a stated uncertainty that the scatter confirms, the factor of a normal value is enough.
    const double factor = uncertainty > found ? 2 : exponential_fit::coverage_factor(freedom);
    const double room = factor * factor * fit.scatter * fit.scatter;
    fit.steady_low = fit.steady_high = fit.steady;
    fit.determined = best < steps && squares[steps] > squares[best] + room;
    for (int i = 0; i <= steps; ++i) {
        const double left = room - (squares[i] - squares[best]);
        if (!(left >= 0)) continue;
        const Line here = exponential_fit::line_at(t, y, tau_of(i));
        const double half = std::sqrt(left * here.steady_variance), centre = here.a + here.b;
        fit.steady_low = std::min(fit.steady_low, centre - half);
        fit.steady_high = std::max(fit.steady_high, centre + half);
    }
    return fit;
}

}  // namespace plumb
