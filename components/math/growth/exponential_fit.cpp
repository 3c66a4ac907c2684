// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/exponential_fit.hpp"

#include <Eigen/Cholesky>

namespace plumb {

namespace exponential_fit {
namespace {

// Student's t that leaves 4.55 % outside on both sides together, as 2 standard deviations of a normal value
// do; within 1 % for 2 and more degrees of freedom (Cornish-Fisher).
double coverage_factor(Eigen::Index freedom) noexcept {
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

Line line_at(const Eigen::VectorXd& t, const Eigen::VectorXd& y, double tau) {
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

}  // namespace
}  // namespace exponential_fit

std::optional<ExponentialFit> fit_exponential(const Eigen::VectorXd& t, const Eigen::VectorXd& y,
                                              double uncertainty) {
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
