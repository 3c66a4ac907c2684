// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/turning/height_sigma.hpp"
#include "components/math/turning/skewed_axes.hpp"

#include <Eigen/Core>
#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// A cut: where its tool stood, X and Y against any origin, X outward, and the radius that it left. Lengths in
// mu.
struct Cut {
    double x = 0, y = 0, radius = 0;
    double depth = 0;       // of its last pass; only differences count
    bool rejected = false;  // an outlier, which does not count
};

// Height y and distance x of a tip from the axis, signed, from any number of cuts at two or more positions of
// Y. Each cut gives
//
//     r^2 = rho^2 + 2 x dx + dx^2 + 2 y dy + dy^2 + 2 r drift k + 2 (y + dy) rise k + 2 r (r - r1) scale
//           + 2 (x + dx) push p + 2 (y + dy) drag p
//
// with dx, dy, r1 of the first cut, k its number from the middle one, and p the depth of its pass less that
// of the first; linear in rho^2, x, y, drift, rise, scale, push and drag. The free rho^2 is the radius of the
// first cut, so that its error, common to all differences, counts once: generalised least squares. If all
// cuts have one X, x follows from y. Wear, growth and the lift of the spindle are a drift of the radius and a
// rise of the tip. They are 0 within sigmas.drift: a row of its own for each. The scale of the gauge is 0
// within sigmas.scale. Many cuts at the same few diameters do not lessen its error. Push and drag are the
// bend of work and tool per depth, in X and in Y, each 0 within sigmas.bend: only unequal depths show them.
class CutFit {
public:
    static constexpr std::size_t most = 16;

    enum class Refusal : std::int32_t { none, too_few, no_step, no_solution };

    struct Known {  // an x of the first cut that is known from elsewhere
        double x = 0, sigma = 0;
        bool valid = false;
    };

    // The cut whose residual is the largest in its own sigmas, above 0 if its radius is too large, and how
    // much more chi squared falls without it than without any other cut.
    struct Suspect {
        std::size_t cut = 0;
        double sigmas = 0, lead = 0;
    };

    Refusal refusal = Refusal::none;
    double x = 0, y = 0;         // at the first cut, as in the middle of all cuts
    double drift = 0, rise = 0;  // of the radius and of the tip, per cut
    double sigma_y = 0, sigma_x = 0;
    double excess = 0;  // of the residuals, in sigmas; 0 if no cut is redundant
    int redundant = 0;  // rows more than unknowns
    int spare = 0;      // cuts more than needed
    Suspect suspect;
    double bias_y = 0, bias_x = 0;  // by an outlier in one radius that the residuals do not show

    // Radius that a cut at dx, dy from the first one leaves, without drift.
    double predicted(double dx, double dy) const noexcept { return std::hypot(x + dx, y + dy); }

    // Sigma of a predicted radius, that of the cut itself not included.
    double sigma_predicted(double dx, double dy) const noexcept {
        const double radius = predicted(dx, dy);
        return radius > 0 ? std::hypot((x + dx) / radius * sigma_x, (y + dy) / radius * sigma_y) : 0;
    }

    // Radii above 0. count to `most`. `lands` are cuts that are meant to have one X. `outlier` is the largest
    // error of a radius beyond its noise, as by a burr.
    static CutFit of(const Cut* cuts, std::size_t count, const SkewedAxes& axes, const CutSigmas& sigmas,
                     const Known& known, bool lands = false, double outlier = 0) noexcept {
        CutFit fit;
        if (count < 2 || count > most) return refused(Refusal::too_few);
        std::array<Point, most> points;
        double farthest_x = 0, farthest_y = 0;
        std::size_t farthest = 0;
        bool one_x = true, unequal = false;
        for (std::size_t i = 0; i < count; ++i) {
            const double step = cuts[i].y - cuts[0].y;
            points[i].dx = cuts[i].x - cuts[0].x + axes.x_of(step);
            points[i].dy = axes.height_of(step);
            points[i].radius = cuts[i].radius;
            points[i].deeper = cuts[i].depth - cuts[0].depth;
            points[i].rejected = cuts[i].rejected;
            if (cuts[i].rejected) continue;
            unequal |= std::abs(points[i].deeper) > same * cuts[0].radius;
            one_x &= std::abs(cuts[i].x - cuts[0].x) <= same * cuts[0].radius;
            farthest_x = std::max(farthest_x, std::abs(points[i].dx));
            if (std::abs(points[i].dy) > farthest_y) {
                farthest_y = std::abs(points[i].dy);
                farthest = i;
            }
        }
        if (!(farthest_y > 1e-6 * cuts[0].radius)) return refused(Refusal::no_step);
        const Scale scale{farthest_x, farthest_y};
        // Step by step: the noise of a cut depends on y, and of lands, all at one X, x follows from it.
        const bool find_x = !one_x && !lands;
        const double r1 = cuts[0].radius;
        double y = -(points[0].dy + points[farthest].dy) / 2;
        for (int round = 0; round < 60; ++round) {
            const double x = known.valid ? known.x : std::sqrt(std::max(r1 * r1 - y * y, 0.0));
            fit = CutFit{};
            fit.solve(points.data(), count, scale, find_x, sigmas, known, x, y, unequal);
            if (fit.refusal != Refusal::none) return fit;
            const double change = std::abs(fit.y - y);
            y = fit.y;
            if (change <= 1e-14 * r1 || (find_x && round == 2)) {
                fit.solve(points.data(), count, scale, find_x, sigmas, known, x, y, unequal, &outlier);
                return fit;
            }
            if (!(change <= r1)) break;
        }
        if (std::abs(y) > 0.99 * cuts[0].radius) return refused(Refusal::no_solution);
        return fit;
    }

private:
    static constexpr double same = 1e-9;  // relative difference of X that is rounding

    struct Point {
        double dx = 0, dy = 0, radius = 0, deeper = 0;
        bool rejected = false;
    };
    struct Scale {
        double x, y;
    };

    static constexpr int rows_most = most + 7, unknowns_most = 9;
    static constexpr double undetected = 4;     // sigmas of a residual at which it shows in five of six cases
    static constexpr double negligible = 1e-6;  // weight of a rejected cut, so that no row is missing
    static constexpr double steadiness = 20;    // cuts in which a drift changes by itself, at the soonest
    using Rows =
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, rows_most, unknowns_most>;
    using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, rows_most, 1>;
    using Sizes = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, unknowns_most, 1>;

    static CutFit refused(Refusal reason) noexcept {
        CutFit fit;
        fit.refusal = reason;
        return fit;
    }

    // With x as an unknown, or with the given one; `y_now` is about y. Each row has a noise of 1. With
    // `outlier` it looks for one, too.
    void solve(const Point* points, std::size_t count, const Scale& scale, bool find_x,
               const CutSigmas& sigmas, const Known& known, double given_x, double y_now, bool unequal,
               const double* outlier = nullptr) noexcept {
        const bool with_known = find_x && known.valid, drifts = sigmas.drift > 0, scales = sigmas.scale > 0;
        const int needed = find_x ? 3 : 2, y_column = needed - 1, scale_column = needed + (drifts ? 3 : 0);
        const bool bends = unequal && sigmas.bend > 0;
        const int bend_column = scale_column + (scales ? 1 : 0), unknowns = bend_column + (bends ? 2 : 0);
        const int cuts = static_cast<int>(count), measured = cuts + (with_known ? 1 : 0);
        const int rejected = static_cast<int>(
            std::count_if(points, points + count, [](const Point& p) { return p.rejected; }));
        if (measured - rejected < needed) return void(*this = refused(Refusal::too_few));
        const double r1 = points[0].radius, width = r1 * scale.y;
        const double per_drift = width / r1;  // of one unit of the unknowns drift and rise

        Rows a = Rows::Zero(measured + (unknowns - needed), unknowns);
        Column b = Column::Zero(a.rows());
        const double per_radius = std::max(sigmas.radius(), 1e-12 * r1);
        const double per_x = sigmas.travel / std::sqrt(2.0), per_y = sigmas.step / std::sqrt(2.0);
        for (int row = 0; row < cuts; ++row) {
            const Point& p = points[row];
            const double h = y_now + p.dy;
            const double x_now = find_x ? std::sqrt(std::max(p.radius * p.radius - h * h, 0.0))
                                        : 0;  // lands are cut at one position of X
            const double noise =
                2 * std::sqrt(square(p.radius * per_radius) + square(x_now * per_x) + square(h * per_y));
            const double weight = width / noise * (p.rejected ? negligible : 1);
            a(row, 0) = weight;
            if (find_x) a(row, 1) = weight * 2 * p.dx / scale.x;
            a(row, y_column) = weight * 2 * p.dy / scale.y;
            const double k = row - 0.5 * (cuts - 1);
            if (drifts) a(row, needed) = weight * 2 * p.radius * k / r1;
            if (drifts) a(row, needed + 1) = weight * 2 * h * k / r1;
            if (drifts) a(row, needed + 2) = weight * 2 * p.radius * k * k / r1;
            if (scales) a(row, scale_column) = weight * 2 * p.radius * (p.radius - r1) / width;
            if (bends) {
                const double beside = std::sqrt(std::max(p.radius * p.radius - h * h, 0.0));
                a(row, bend_column) = weight * 2 * beside * p.deeper / width;
                a(row, bend_column + 1) = weight * 2 * h * p.deeper / width;
            }
            b(row) = weight *
                     ((p.radius - r1) * (p.radius + r1) - p.dx * p.dx - p.dy * p.dy -
                      (find_x ? 0 : 2 * given_x * p.dx)) /
                     width;
        }
        if (with_known) {
            const double weight = width / (scale.x * std::max(known.sigma, 1e-12 * r1));
            a(cuts, 1) = weight;
            b(cuts) = weight * known.x * scale.x / width;
        }
        if (drifts) {
            a(measured, needed) = a(measured + 1, needed + 1) = per_drift / sigmas.drift;
            a(measured + 2, needed + 2) = steadiness * per_drift / sigmas.drift;
        }
        if (scales) a(measured + scale_column - needed, scale_column) = 1 / sigmas.scale;
        if (bends) {
            const int bend_row = measured + bend_column - needed;
            a(bend_row, bend_column) = a(bend_row + 1, bend_column + 1) = 1 / sigmas.bend;
        }

        // Columns of like size, so that the rank shows.
        const Sizes sizes = a.colwise().norm();
        if (!(sizes.minCoeff() > 0)) return void(*this = refused(Refusal::no_solution));
        for (int i = 0; i < unknowns; ++i) a.col(i) /= sizes(i);
        Eigen::ColPivHouseholderQR<Eigen::Ref<Rows>> qr(a);  // in place: realtime has little stack
        qr.setThreshold(1e-9);
        if (qr.rank() < unknowns) return void(*this = refused(Refusal::no_solution));
        b.applyOnTheLeft(qr.householderQ().adjoint());
        const auto factor =
            qr.matrixR().topLeftCorner(unknowns, unknowns).template triangularView<Eigen::Upper>();
        Sizes solution = b.head(unknowns);
        factor.solveInPlace(solution);
        solution = (qr.colsPermutation() * solution).eval();
        // Row of P R^-1, whose products are the covariances.
        const auto row_of = [&](int column) {
            Sizes row = Sizes::Unit(unknowns, column);
            row = (qr.colsPermutation().transpose() * row).eval();
            factor.transpose().solveInPlace(row);
            return row;
        };
        y = solution(y_column) / sizes(y_column) * width / scale.y;
        const Sizes row_y = row_of(y_column) / sizes(y_column) * width / scale.y;
        sigma_y = row_y.norm();
        // From rho^2 = x^2 + y^2; where cuts at several X know it better, from these.
        x = std::sqrt(std::max(r1 * r1 + solution(0) / sizes(0) * width - y * y, 0.0));
        Sizes row_x = Sizes::Zero(unknowns);
        if (x > 0) row_x = row_of(0) / sizes(0) * width / (2 * x) - row_y * y / x;
        if (find_x) {
            const Sizes its = row_of(1) / sizes(1) * width / scale.x;
            if (!(x > 0) || its.norm() < row_x.norm()) {
                x = solution(1) / sizes(1) * width / scale.x;
                row_x = its;
            }
        }
        sigma_x = row_x.norm();
        if (drifts) {
            drift = solution(needed) / sizes(needed) * per_drift;
            rise = solution(needed + 1) / sizes(needed + 1) * per_drift;
        }
        const int others = static_cast<int>(a.rows()) - unknowns;  // dimensions of the residuals
        redundant = others - rejected;
        spare = measured - rejected - needed;
        if (redundant > 0) {
            const double chi = b.tail(others).squaredNorm();
            excess = std::max(0.0, std::sqrt(2 * chi) - std::sqrt(2.0 * redundant - 1));
            if (excess > 3) {  // the cuts scatter by more than their sigmas
                sigma_y *= std::sqrt(chi / redundant);
                sigma_x *= std::sqrt(chi / redundant);
            }
        }
        if (!outlier) return;
        double largest = 0, next = 0;
        for (int row = 0; row < cuts; ++row) {
            if (points[row].rejected) continue;
            Column q = Column::Unit(a.rows(), row);
            q.applyOnTheLeft(qr.householderQ().adjoint());
            const double free =
                std::sqrt(std::max(q.tail(others).squaredNorm(), 0.0));  // 0: no other cut shows it
            const double in_noise = *outlier / per_radius, unseen = free > 0 ? undetected / free : HUGE_VAL;
            const double error = std::min(in_noise, unseen);
            bias_y = std::max(bias_y, std::abs(q.head(unknowns).dot(row_y)) * error);
            bias_x = std::max(bias_x, std::abs(q.head(unknowns).dot(row_x)) * error);
            if (!(free > 0.1)) continue;
            const double its = q.tail(others).dot(b.tail(others)) / free;
            if (std::abs(its) > largest) {
                next = largest;
                largest = std::abs(its);
                suspect.cut = static_cast<std::size_t>(row);
                suspect.sigmas = its;
            } else {
                next = std::max(next, std::abs(its));
            }
        }
        suspect.lead = square(largest) - square(next);
    }

    static double square(double z) noexcept { return z * z; }
};

}  // namespace plumb
