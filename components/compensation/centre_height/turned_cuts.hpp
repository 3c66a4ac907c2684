// SPDX-License-Identifier: GPL-2.0-or-later
// The height of a lathe tool from the diameters that it turns: mathematics without pins. Lengths in mu.
//
//     LandPair::of      where to cut two lands
//     slip_of           whether an entry is a diameter at all
//     TwoCuts::of       one land turned twice: the size of the height
//     CutFit::of        any cuts at two or more positions of Y: height with sign, X, and a cut with a burr
//     predict           the diameter of a further cut, by the others
//     KnownError        the part of an error that its sigma proves
//     ToolBend          height under the cut against height at rest
//     diameter_in_...   the diameter from the area of a beam
//
// A tip at height y and distance x from the axis leaves r^2 = x^2 + y^2. A step dy of the tip changes that by
// 2 y dy + dy^2: linear in y. CutFit solves these equations by generalised least squares, with wear, lift,
// bend and the scale of the gauge as further unknowns that are 0 within their sigmas.
#pragma once

#include "components/math/blocks/pi.hpp"

#include <Eigen/Core>
#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>

namespace plumb {

inline double square(double z) noexcept {
    return z * z;
}

// Standard uncertainties of a cut and of its measurement, in mu; scale is a ratio.
struct CutSigmas {
    double gauge = 0;          // of a measured diameter
    double repeatability = 0;  // of the radius that a cut leaves, built-up edge included
    double travel = 0;         // of the distance between two positions of X
    double step = 0;           // of the distance between two positions of Y
    double drift = 0;          // of the radius and of the tip from cut to cut: wear, growth, lift
    double bend = 0;           // of the bend of work and tool, per depth of a pass
    double scale = 0;          // of the gauge's error from diameter to diameter, per difference of them

    double radius() const noexcept { return std::hypot(gauge / 2, repeatability); }
};

// The plane of X and of a Y that is not square to it. `angle` is the one between +X and +Y in rad, within
// 0 and pi; a quarter turn if they are square.
class SkewedAxes {
public:
    SkewedAxes() = default;
    explicit SkewedAxes(double angle) noexcept : cosine_(std::cos(angle)), sine_(std::sin(angle)) {}

    // Movement of the tip along X, and square to it, for a travel of Y.
    double x_of(double y_travel) const noexcept { return y_travel * cosine_; }
    double height_of(double y_travel) const noexcept { return y_travel * sine_; }
    // The travel of Y that lifts the tip by `height`.
    double travel_for(double height) const noexcept { return height / sine_; }

private:
    double cosine_ = 0, sine_ = 1;
};

// The heights, against the present one, at which a tool cuts two lands. A tool above the axis loses
// clearance by asin(height / radius). `rubbing` is +1 if it rubs above, -1 if below, as for a tool that is
// mounted upside down or work that turns the other way. Lengths in mu.
struct LandPair {
    double first = 0, second = 0;            // the first is on the side of +Y
    bool about = true;                       // the present height is in the middle
    static constexpr double steepest = 0.6;  // largest height of a check, per radius

    double half() const noexcept { return (first - second) / 2; }

    // Whether a tool at `height` has clearance. 0 is a clearance that nobody checks.
    static bool clears(double height, double radius, double clearance, double rubbing) noexcept {
        return !(clearance > 0) || height * rubbing <= radius * std::sin(clearance) * (1 + 1e-9);
    }

    // Lands at +-step; if the clearance, in rad, is too small for that, at the present height and two smaller
    // steps away from the rubbing side.
    static LandPair of(double step, double radius, double clearance, double rubbing) noexcept {
        if (clears(step, radius, clearance, 1)) return {step, -step, true};
        const double smaller = std::min(step, kept * radius * std::sin(clearance));
        return rubbing > 0 ? LandPair{0, -2 * smaller, false} : LandPair{2 * smaller, 0, false};
    }

    // Height of a check that leaves this radius: two steps above the middle, or half a step where the
    // clearance forbids it or the radius is too small.
    double check(double radius, double clearance, double rubbing) const noexcept {
        const double middle = (first + second) / 2, far = middle + 2 * half();
        const bool fits = clears(far, radius, clearance, rubbing) && std::abs(far) <= steepest * radius;
        return fits ? far : middle + half() / 2;
    }

private:
    static constexpr double kept = 0.9;  // of the clearance
};

// A cut: where its tool stood, X and Y against any origin, X outward, and the radius that it left. Lengths in
// mu.
struct Cut {
    double x = 0, y = 0, radius = 0;
    double depth = 0;       // of its last pass; only differences count
    double apart = 0;       // of two readings at two angles, as radii; 0 for one reading
    bool again = false;     // deeper into the land of the cut before
    bool rejected = false;  // does not count
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
    static constexpr std::size_t most = 20;
    static constexpr std::size_t most_asked = 16;  // the others are for checks

    enum class Refusal : std::int32_t { none, too_few, no_step, no_solution };

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
    double x_now = 0, sigma_x_now = 0;  // as after the last cut: what has drifted in half of the cuts counts
    double spread = 1;                  // by which the residuals have raised the sigmas
    double excess = 0;                  // of the residuals, in sigmas; 0 if no cut is redundant
    int redundant = 0;                  // rows more than unknowns
    int spare = 0;                      // cuts more than needed
    Suspect suspect;
    double bias_y = 0, bias_x = 0;  // by an outlier in one radius that the residuals do not show

    // Radius that a cut at dx, dy from the first one leaves, without drift.
    double predicted(double dx, double dy) const noexcept { return std::hypot(x + dx, y + dy); }

    // Sigma of a predicted radius, without the scatter of the cut itself. A further cut must agree within
    // what the settings allow: cuts that scatter by more allow no more.
    double sigma_predicted(double dx, double dy) const noexcept {
        const double radius = predicted(dx, dy);
        return radius > 0 ? std::hypot((x + dx) / radius * sigma_x, (y + dy) / radius * sigma_y) / spread : 0;
    }

    // Radii above 0. count to `most`. `lands` are cuts that are meant to have one X. `outlier` is the largest
    // error of a radius beyond its noise, as by a burr.
    static CutFit of(const Cut* cuts, std::size_t count, const SkewedAxes& axes, const CutSigmas& sigmas,
                     bool lands = false, double outlier = 0) noexcept {
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
            const double x = std::sqrt(std::max(r1 * r1 - y * y, 0.0));
            fit = CutFit{};
            fit.solve(points.data(), count, scale, find_x, sigmas, x, y, unequal);
            if (fit.refusal != Refusal::none) return fit;
            const double change = std::abs(fit.y - y);
            y = fit.y;
            if (change <= 1e-14 * r1 || (find_x && round == 2)) {
                fit.solve(points.data(), count, scale, find_x, sigmas, x, y, unequal, &outlier);
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

    static constexpr int rows_most = most + 6, unknowns_most = 9;
    static constexpr double undetected = 4;     // sigmas of a residual at which it shows in five of six cases
    static constexpr double negligible = 1e-6;  // weight of a rejected cut, so that no row is missing
    static constexpr double settled = 2;        // redundant cuts for which the settings count
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
               const CutSigmas& sigmas, double given_x, double y_now, bool unequal,
               const double* outlier = nullptr) noexcept {
        const bool drifts = sigmas.drift > 0, scales = sigmas.scale > 0;
        const int needed = find_x ? 3 : 2, y_column = needed - 1, scale_column = needed + (drifts ? 3 : 0);
        const bool bends = unequal && sigmas.bend > 0;
        const int bend_column = scale_column + (scales ? 1 : 0), unknowns = bend_column + (bends ? 2 : 0);
        const int cuts = static_cast<int>(count);
        const int rejected = static_cast<int>(
            std::count_if(points, points + count, [](const Point& p) { return p.rejected; }));
        if (cuts - rejected < needed) return void(*this = refused(Refusal::too_few));
        const double r1 = points[0].radius, width = r1 * scale.y;
        const double per_drift = width / r1;  // of one unit of the unknowns drift and rise

        Rows a = Rows::Zero(cuts + (unknowns - needed), unknowns);
        Column b = Column::Zero(a.rows());
        const double per_radius = std::max(sigmas.radius(), 1e-12 * r1);
        const double per_x = sigmas.travel / std::sqrt(2.0), per_y = sigmas.step / std::sqrt(2.0);
        for (int row = 0; row < cuts; ++row) {
            const Point& p = points[row];
            const double h = y_now + p.dy;
            const double x_here = find_x ? std::sqrt(std::max(p.radius * p.radius - h * h, 0.0))
                                         : 0;  // lands are cut at one position of X
            const double noise =
                2 * std::sqrt(square(p.radius * per_radius) + square(x_here * per_x) + square(h * per_y));
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
        if (drifts) {
            a(cuts, needed) = a(cuts + 1, needed + 1) = per_drift / sigmas.drift;
            a(cuts + 2, needed + 2) = steadiness * per_drift / sigmas.drift;
        }
        if (scales) a(cuts + scale_column - needed, scale_column) = 1 / sigmas.scale;
        if (bends) {
            const int bend_row = cuts + bend_column - needed;
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
            const Sizes candidate = row_of(1) / sizes(1) * width / scale.x;
            if (!(x > 0) || candidate.norm() < row_x.norm()) {
                x = solution(1) / sizes(1) * width / scale.x;
                row_x = candidate;
            }
        }
        sigma_x = row_x.norm();
        x_now = x;
        sigma_x_now = sigma_x;
        if (drifts) {
            drift = solution(needed) / sizes(needed) * per_drift;
            rise = solution(needed + 1) / sizes(needed + 1) * per_drift;
            const double half = 0.5 * (cuts - 1);
            x_now += drift * half;
            sigma_x_now =
                std::hypot((row_x + row_of(needed) / sizes(needed) * per_drift * half).norm(), drift * half);
        }
        const int others = static_cast<int>(a.rows()) - unknowns;  // dimensions of the residuals
        redundant = others - rejected;
        spare = cuts - rejected - needed;
        if (redundant > 0) {
            const double chi = b.tail(others).squaredNorm();
            excess = std::max(0.0, std::sqrt(2 * chi) - std::sqrt(2.0 * redundant - 1));
            // Cuts that scatter by more than their sigmas show that these are too small.
            spread = std::sqrt(std::max((settled + chi) / (settled + redundant), 1.0));
            sigma_y *= spread;
            sigma_x *= spread;
            sigma_x_now *= spread;
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
            const double deviation = q.tail(others).dot(b.tail(others)) / free;
            if (std::abs(deviation) > largest) {
                next = largest;
                largest = std::abs(deviation);
                suspect.cut = static_cast<std::size_t>(row);
                suspect.sigmas = deviation;
            } else {
                next = std::max(next, std::abs(deviation));
            }
        }
        suspect.lead = square(largest) - square(next);
    }
};

// The cuts of a procedure. X is outward, Y against the position for which the height is wanted; lengths in
// mu.
struct TurnedCuts {
    std::array<Cut, CutFit::most> cuts;
    std::size_t count = 0;
    double x_zero = 0;  // X at which the control has the axis, outward
    double travel = 0;  // of X between the first two cuts, as entered; 0 if not

    const Cut& operator[](std::size_t i) const noexcept { return cuts[i]; }
    double programmed(std::size_t i) const noexcept { return cuts[i].x - x_zero; }
};

// Square of the distance of a corner of a triangle from the side `base`, where `a` and `b` are the other two
// sides; negative if they do not meet. Accurate for the flattest triangle (Kahan, "Miscalculating area and
// angles of a needle-like triangle"). Sides above 0.
inline double squared_height(double a, double b, double base) noexcept {
    double sides[] = {a, b, base};
    std::sort(std::begin(sides), std::end(sides));
    const double c = sides[0], m = sides[1], l = sides[2];
    return (l + (m + c)) * (c - (l - m)) * (c + (l - m)) * (l + (m - c)) / (4 * base * base);
}

// Distance |y| of the tip from the height of the work's axis, from the radii of two cuts and the travel in
// X between them (CN101351287A). The sign of y does not show: +y and -y leave equal radii. Lengths in mu.
struct TwoCuts {
    enum class Refusal : std::int32_t {
        none,
        order,         // the second cut did not go deeper: r2 >= r1, inside r2 <= r1
        travel,        // travel <= 0
        short_travel,  // travel < |r1 - r2|, beyond the uncertainty
        long_travel,   // travel > r1 + r2
        past_centre,   // the tip is beyond the axis at the second cut, inside at the first
    };

    double y_squared = 0;  // may be below 0 within its uncertainty
    double sigma_y_squared = 0;
    double x1 = 0, sigma_x1 = 0;                 // of the tip at the first cut
    double theta = 0;                            // rad, between X and the radius of the first cut
    double by_r1 = 0, by_r2 = 0, by_travel = 0;  // derivatives of y squared
    Refusal refusal = Refusal::none;

    double y() const noexcept { return std::sqrt(std::max(y_squared, 0.0)); }
    // "On centre within": the sigma of y where y is 0.
    double floor() const noexcept { return std::sqrt(sigma_y_squared); }
    double sigma() const noexcept {
        return y() > floor() ? sigma_y_squared / (2 * y()) : sigma_y_squared > 0 ? floor() : 0;
    }
    // Converts the derivative of y squared into the derivative of y. Below the floor, y counts as the floor.
    double sensitivity(double of_square) const noexcept {
        const double least = std::max(y(), floor());
        return least > 0 ? of_square / (2 * least) : 0;
    }

    // Both radii above 0. The last pass of the second cut is `deeper` than that of the first. `inside` is
    // internal turning, where X goes outward to cut deeper.
    static TwoCuts of(double r1, double r2, double travel, bool inside, const CutSigmas& sigmas,
                      double deeper = 0) noexcept {
        TwoCuts cuts;
        if (!(travel > 0)) return refused(Refusal::travel);
        if (inside ? !(r2 > r1) : !(r2 < r1)) return refused(Refusal::order);
        if (travel > r1 + r2) return refused(Refusal::long_travel);
        const double outward = inside ? travel : -travel;
        cuts.x1 = ((r2 - r1) * (r2 + r1) - travel * travel) / (2 * outward);
        const double x2 = cuts.x1 + outward;
        if (!(cuts.x1 >= 0 && x2 >= 0)) return refused(Refusal::past_centre);
        cuts.y_squared = squared_height(r1, r2, travel);
        cuts.by_r1 = 2 * x2 * r1 / outward;
        cuts.by_r2 = -2 * cuts.x1 * r2 / outward;
        cuts.by_travel = 2 * cuts.x1 * x2 / travel;
        const double radius = sigmas.radius();
        const double a = cuts.by_r1 * radius, b = cuts.by_r2 * radius, c = cuts.by_travel * sigmas.travel;
        // Half a drift before the middle of both cuts and half a drift behind it: of the radii, and of y.
        const double y = cuts.y(), half = sigmas.drift / 2;
        const double d = (cuts.by_r2 - cuts.by_r1) * half;
        const double e = (cuts.by_r2 * y / r2 - cuts.by_r1 * y / r1) * half;
        const double f = cuts.by_r2 * (r1 - r2) * sigmas.scale;
        const double g = cuts.by_r2 * deeper * sigmas.bend;
        cuts.sigma_y_squared = std::sqrt(a * a + b * b + c * c + d * d + e * e + f * f + g * g);
        if (cuts.y_squared < -3 * cuts.sigma_y_squared - rounding * r1 * r1)
            return refused(Refusal::short_travel);
        cuts.theta = std::atan2(cuts.y(), cuts.x1);
        const double x_by_r1 = -r1 / outward * radius, x_by_r2 = r2 / outward * radius;
        const double x_by_travel = (1 + cuts.x1 / outward) * sigmas.travel;
        const double x_by_drift = (r1 + r2) / outward * half,
                     x_by_scale = r2 * (r1 - r2) / outward * sigmas.scale;
        const double x_by_bend = r2 / outward * deeper * sigmas.bend;
        cuts.sigma_x1 = std::hypot(std::hypot(x_by_r1, x_by_r2, x_by_travel),
                                   std::hypot(x_by_drift, x_by_scale), x_by_bend);
        return cuts;
    }

private:
    static constexpr double rounding = 1e-12;

    static TwoCuts refused(Refusal reason) noexcept {
        TwoCuts cuts;
        cuts.refusal = reason;
        return cuts;
    }
};

// The radius that a further cut is expected to leave, and the standard uncertainty of the difference to the
// measured one. Lengths in mu.
struct Prediction {
    double radius = 0, sigma = 0;

    // Distance of a measured radius from the expected one, in sigmas.
    double disagreement(double measured) const noexcept { return std::abs(measured - radius) / sigma; }
};

// A further cut: place of the tip against the first cut, with skewed axes resolved, and its number.
struct FurtherCut {
    double dx = 0, dy = 0;
    double deeper = 0;      // its last pass than that of the first cut
    double drifts = 0;      // cuts between the middle of the known ones, or the first of two, and this one
    bool travelled = true;  // X stands elsewhere
};

// By two cuts, x1 and y squared of which are known. `y` is the signed height of the tip at the first cut.
// `outward` is 1 for internal turning, where X goes outward to cut deeper, else -1. The radius is 0 if the
// tip does not meet the work.
inline Prediction predict(const TwoCuts& two, const Cut& first, const Cut& second, double travel,
                          double outward, double y, double sigma_y, const FurtherCut& further,
                          const CutSigmas& sigmas) noexcept {
    const double dx = further.dx, dy = further.dy, x = two.x1 + dx;
    const double radius = std::sqrt(std::max(x * x + two.y_squared + 2 * y * dy + dy * dy, 0.0));
    if (!(radius > 0)) return {};
    // Of the squared radius by r1, r2 and the travel, then by its own radius and travel.
    const double per_r1 = 2 * first.radius * (1 - dx * outward / travel);
    const double per_r2 = 2 * second.radius * dx * outward / travel;
    const double per_travel = -2 * dx * (two.x1 + outward * travel) / travel;
    const double s = sigmas.radius(), t = sigmas.travel;
    const double of_step = 2 * (y + dy) * (dy != 0 ? sigmas.step : 0);
    const double of_y = dy != 0 ? 2 * dy * sigma_y : 0;
    const double of_drift = (per_r2 - 2 * radius * further.drifts) * sigmas.drift;
    const double of_scale =
        (per_r2 * (second.radius - first.radius) - 2 * radius * (radius - first.radius)) * sigmas.scale;
    const double noise =
        std::sqrt(per_r1 * per_r1 * s * s + per_r2 * per_r2 * s * s + per_travel * per_travel * t * t +
                  square(2 * radius * further.deeper * sigmas.bend) + 4 * radius * radius * s * s +
                  4 * x * x * t * t + of_step * of_step + of_y * of_y + of_drift * of_drift +
                  of_scale * of_scale) /
        (2 * radius);
    return {radius, std::max(noise, 1e-9 * radius)};
}

// By a fit of the other cuts. `first` and `measured` are the radii of the first cut and of the further one.
inline Prediction predict(const CutFit& others, double first, double measured, const FurtherCut& further,
                          const CutSigmas& sigmas) noexcept {
    const double radius = others.predicted(further.dx, further.dy);
    if (!(radius > 0)) return {};
    const double x = (others.x + further.dx) / radius, h = (others.y + further.dy) / radius;
    const double place = std::hypot(further.travelled ? x * sigmas.travel : 0, h * sigmas.step);
    const double own = std::hypot(std::hypot(sigmas.radius(), sigmas.drift * further.drifts, place),
                                  sigmas.scale * (measured - first), sigmas.bend * further.deeper);
    return {radius, std::hypot(others.sigma_predicted(further.dx, further.dy), own, 1e-9 * measured)};
}

// What an operator may have done who entered a diameter.
enum class EntrySlip : std::int32_t {
    none,
    not_positive,  // or not a number
    radius,        // the radius instead of the diameter
    doubled,       // the diameter where a radius was due
    inch,          // in inches on a machine in mm
    metric,        // in mm on a machine in inches
};

// Compares a radius with the one that the program asked for; 0 is a programmed radius that nobody knows. The
// entry is closest to one of the slips, in ratio, or to none of them. A tool that stands wrong by less than
// 29 % of the radius is no slip.
inline EntrySlip slip_of(double radius, double programmed) noexcept {
    if (!(radius > 0 && radius < HUGE_VAL)) return EntrySlip::not_positive;
    if (!(programmed > 0 && programmed < HUGE_VAL)) return EntrySlip::none;
    const double ratio = radius / programmed;
    constexpr double half_octave = 1.4142135623730951, between = 7.1274118724821847;  // sqrt(2 * 25.4)
    if (ratio < 1 / between) return EntrySlip::inch;
    if (ratio < 1 / half_octave) return EntrySlip::radius;
    if (ratio > between) return EntrySlip::metric;
    return ratio > half_octave ? EntrySlip::doubled : EntrySlip::none;
}

// The size of a measured error and its standard uncertainty: small for sure, large for sure, or unknown.
// Lengths in mu.
struct KnownError {
    double size = 0, sigma = 0;
    double bias = 0;  // that may hide in it

    // One-sided, at 99 %.
    bool within(double tolerance) const noexcept { return size + one_sided * sigma <= tolerance; }
    // An error of half of it, which would make a correction worse than none, is beyond three sigmas: less
    // than one move of 700.
    static constexpr double sure = 6;
    bool significant() const noexcept { return size >= std::max(sure * sigma, 2 * bias) && size > 0; }

    // The cuts that would make the error known, as a multiple of the cuts that there are: within the
    // tolerance, or significant. The sigma is inverse to the root of the number of cuts.
    double more_cuts(double tolerance) const noexcept {
        const double room = tolerance - size;
        const double until_within = room > 0 ? square(one_sided * sigma / room) : HUGE_VAL;
        const double until_significant = size > 0 ? square(sure * sigma / size) : HUGE_VAL;
        return std::min(until_within, until_significant);
    }

private:
    static constexpr double one_sided = 2.33;
};

// How far work and tool bend: the height of a tool at rest less the one under the cut. Lengths in mu.
class ToolBend {
public:
    // The height of a tool against an origin that both share. Another tool forgets the one before.
    void take(double tool, bool at_rest, double height, double sigma) noexcept {
        if (tool != tool_) *this = ToolBend{};
        tool_ = tool;
        (at_rest ? rest_ : cut_) = {height, sigma, true};
    }

    bool known() const noexcept { return cut_.valid && rest_.valid; }
    double bend() const noexcept { return known() ? rest_.height - cut_.height : 0; }
    double sigma() const noexcept { return known() ? std::hypot(rest_.sigma, cut_.sigma) : 0; }

private:
    struct Height {
        double height = 0, sigma = 0;
        bool valid = false;
    };

    double tool_ = 0;
    Height cut_, rest_;
};

// Diameters from the area of a laser beam before and behind the work, the work in the middle of the beam.
// NaN if the work is not inside the beam or covers less than nothing. Areas in mu2.

constexpr double no_diameter = std::numeric_limits<double>::quiet_NaN();

// A rectangular beam, `height` of which lies along the work; its width is emitted / height.
inline double diameter_in_rectangle(double emitted, double received, double height) noexcept {
    const bool inside = height > 0 && received > 0 && received < emitted;
    return inside ? (emitted - received) / height : no_diameter;
}

// Area that a strip of half width a, through the middle, covers of a circle.
inline double covered_of_circle(double a, double radius) noexcept {
    return 2 * (a * std::sqrt(radius * radius - a * a) + radius * radius * std::asin(a / radius));
}

// A round beam. Inverts covered_of_circle(), which rises and bends down, so that Newton's steps from 0 never
// go beyond the root.
inline double diameter_in_circle(double emitted, double received, double radius) noexcept {
    const double covered = emitted - received;
    if (!(radius > 0 && received > 0 && covered > 0 && covered < pi * radius * radius)) return no_diameter;
    double a = 0;
    for (int i = 0; i < 200; ++i) {
        const double slope = 4 * std::sqrt(radius * radius - a * a);
        const double step = slope > 0 ? (covered - covered_of_circle(a, radius)) / slope : 0;
        if (!(step > 1e-16 * radius)) break;
        a = a + step < radius ? a + step : radius;
    }
    return 2 * a;
}

}  // namespace plumb
