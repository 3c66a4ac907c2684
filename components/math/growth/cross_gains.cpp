// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/compensation_effect.hpp"

#include <algorithm>
#include <cmath>

#include "components/math/growth/pseudo_inverse.hpp"

namespace plumb {
namespace {

constexpr double certain = 0.25;

}  // namespace

bool CrossGains::swapped(int a, int b) const {
    const auto gone = [this](int k) { return std::abs(gain(k, k)) + 2 * uncertainty(k, k) < 0.4; };
    const auto follows = [this](int k, int l) {
        return gain(k, l) - 2 * uncertainty(k, l) > 0.3 && gain(k, l) < 1.7;
    };
    return drifts[static_cast<std::size_t>(a)] && drifts[static_cast<std::size_t>(b)] && gone(a) && gone(b) &&
           follows(a, b) && follows(b, a);
}

CrossGains cross_gains(const CompensationRecord& record, const std::array<bool, 3>& drifts) {
    CrossGains result;
    result.drifts = drifts;
    std::array<int, 3> axis{};
    Eigen::Index count = 0;
    for (int k = 0; k < 3; ++k)
        if (drifts[static_cast<std::size_t>(k)]) axis[static_cast<std::size_t>(count++)] = k;
    const Eigen::Index passes = record.drift.rows() - 1;  // the first one is the reference
    if (passes < 1) return result;
    const Eigen::MatrixX3d c =
        (record.compensation.rowwise() - record.compensation.row(0)).bottomRows(passes);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            result.difference(row, column) = (c.col(row) - record.drift.col(column).tail(passes)).norm() /
                                             std::sqrt(static_cast<double>(passes));
    if (count == 0 || passes <= count) return result;
    Eigen::MatrixXd d(passes, count);
    for (Eigen::Index k = 0; k < count; ++k)
        d.col(k) = record.drift.col(axis[static_cast<std::size_t>(k)]).tail(passes);
    const Eigen::MatrixXd inverse = pseudo_inverse(d);  // count x passes
    const Eigen::MatrixXd found = inverse * c;          // count x 3
    const double u = record.uncertainty;
    for (int row = 0; row < 3; ++row) {
        const Eigen::VectorXd g = found.col(row);
        const double rest = (c.col(row) - d * g).squaredNorm() / static_cast<double>(passes - count);
        const double noise = u * u * g.squaredNorm();  // of the drift
        for (Eigen::Index k = 0; k < count; ++k) {
            const double common = inverse.row(k).sum();  // of an error of the reference
            const int column = axis[static_cast<std::size_t>(k)];
            result.gain(row, column) = g[k];
            result.uncertainty(row, column) =
                std::sqrt(std::max(rest, noise) * inverse.row(k).squaredNorm() + noise * common * common);
        }
    }
    for (Eigen::Index k = 0; k < count; ++k) {
        const int column = axis[static_cast<std::size_t>(k)];
        // That of one unit of gain: a gain of 0 would look certain by itself.
        const double unit = u * std::hypot(inverse.row(k).norm(), inverse.row(k).sum());
        result.determined[static_cast<std::size_t>(column)] =
            unit < certain && result.uncertainty.col(column).maxCoeff() < certain;
    }
    return result;
}

}  // namespace plumb
