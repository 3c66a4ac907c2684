// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb {

// The four body diagonals of a box, as ISO 230-6 measures them. d is measured minus nominal length; the
// diagonal from the - ends to the + ends is PPP, and N marks an axis that goes the other way:
//
//     L d = S - sx sy gXY A B - sx sz gXZ A C - sy sz gYZ B C      S = kx A^2 + ky B^2 + kz C^2
//
// g are the openings of the corners and k the scales of the axes. Four lengths give the three openings and S,
// not the scales.
struct BoxDiagonals {
    double a = 0, b = 0, c = 0;  // mm, sides along X, Y and Z
    enum Name { PPP, NPP, PNP, NNP };
    std::array<double, 4> deviations{};  // mm, in the order of the names
    double uncertainty = 0;              // mm, standard, of each
};

struct BoxResult {
    double xy = 0, xz = 0, yz = 0;        // rad, openings of the corners
    double u_xy = 0, u_xz = 0, u_yz = 0;  // rad, standard
    double scale = 0, u_scale = 0;        // mean scale along the diagonals, S / L^2
};

// Throws std::invalid_argument with the value.
inline BoxResult box_from_diagonals(const BoxDiagonals& box) {
    for (const double side : {box.a, box.b, box.c})
        if (!(side >= 10 && side <= 1e5))
            throw std::invalid_argument("a side of " + std::to_string(side) + " mm is not from 10 to 1e5 mm");
    if (!(box.uncertainty > 0)) throw std::invalid_argument("the uncertainty is not above 0");
    const double length = std::sqrt(box.a * box.a + box.b * box.b + box.c * box.c);
    for (const double d : box.deviations)
        if (!(std::abs(d) <= 0.01 * length))
            throw std::invalid_argument("a deviation of " + std::to_string(d) +
                                        " mm is above 1 % of the diagonal of " + std::to_string(length) +
                                        " mm: it is the measured minus the nominal length");
    constexpr int sx[] = {1, -1, 1, -1}, sy[] = {1, 1, -1, -1};  // sz is 1
    double all = 0, xy = 0, xz = 0, yz = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        all += box.deviations[i];
        xy -= sx[i] * sy[i] * box.deviations[i];
        xz -= sx[i] * box.deviations[i];
        yz -= sy[i] * box.deviations[i];
    }
    const double u = box.uncertainty * length / 2;
    const auto over = [&](double first, double second) { return length / (4 * first * second); };
    return {xy * over(box.a, box.b), xz * over(box.a, box.c),       yz * over(box.b, box.c),
            u / (box.a * box.b),     u / (box.a * box.c),           u / (box.b * box.c),
            all / (4 * length),      box.uncertainty / (2 * length)};
}

// Straightness of an axis by a straightedge that is turned over about its length, so that its own error
// changes the sign:
//
//     before = E + s      turned = -E + s      E: the axis, s: the edge
//
// Both readings count up as the plunger is pressed in; it points to the + end of the axis across, and to the
// - end after the edge was turned over. The set-up makes an offset and a slope: each reading is freed of both.
struct Straightness {
    std::vector<double> errors, edge;     // mm
    double range = 0, range_of_edge = 0;  // mm
};

inline std::vector<double> without_slope(const std::vector<double>& x, const std::vector<double>& y) {
    const auto n = static_cast<double>(x.size());
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sx += x[i], sy += y[i];
    for (std::size_t i = 0; i < x.size(); ++i) {
        sxx += (x[i] - sx / n) * (x[i] - sx / n);
        sxy += (x[i] - sx / n) * (y[i] - sy / n);
    }
    std::vector<double> rest;
    for (std::size_t i = 0; i < x.size(); ++i) rest.push_back(y[i] - sy / n - sxy / sxx * (x[i] - sx / n));
    return rest;
}

// At least three positions, rising.
inline Straightness straightness_of(const std::vector<double>& positions, const std::vector<double>& before,
                                    const std::vector<double>& turned) {
    std::vector<double> difference, sum;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        difference.push_back((before[i] - turned[i]) / 2);
        sum.push_back((before[i] + turned[i]) / 2);
    }
    Straightness result{without_slope(positions, difference), without_slope(positions, sum)};
    const auto range = [](const std::vector<double>& y) {
        const auto [low, high] = std::minmax_element(y.begin(), y.end());
        return *high - *low;
    };
    result.range = range(result.errors);
    result.range_of_edge = range(result.edge);
    return result;
}

// The error that lost motion leaves on a circle where an axis turns, corrected by squareness. The load stands
// until the motor has gone back by B, by its command and by the correction, which begins after h:
//
//     an t²/2 + a (t - th)²/2 = B      th = sqrt(2 h / an)      e = an t²/2      while the correction speeds
//     up e = 1/2 ((sqrt(2 h a) + 2 sqrt(B an)) / (sqrt a + sqrt an))²               while it slows down
//
// B lost motion, h reversal-distance, a reversal-acceleration, an = v²/R; the rate is not reached, and the
// drive follows at once. Without correction the circle has steps of B at the same places: half of B on either
// side of its mean.
struct CircleTurn {
    double lost, distance, acceleration;  // mm, mm, mm/s2

    // In mm, at a speed in mm/s on a radius in mm.
    double kept(double speed, double radius) const noexcept {
        const double an = speed * speed / radius, begin = std::sqrt(2 * distance / an);
        const double root = (an + acceleration) * 2 * lost - an * acceleration * begin * begin;
        if (!(root > 0)) return lost;  // it begins behind the turn
        const double t = (acceleration * begin + std::sqrt(root)) / (an + acceleration);
        if (t < begin) return lost;
        if (acceleration * (t - begin) * (t - begin) <= lost) return an * t * t / 2;
        return std::min(lost, below(an));
    }

    // The largest speed in mm/s at which a circle keeps at most `allowed`; 0 if it keeps more at any.
    double speed_for(double allowed, double radius) const noexcept {
        double low = 0, high = 1e4;
        if (kept(1e-6, radius) > allowed) return 0;
        for (int step = 0; step < 60; ++step) {
            const double middle = (low + high) / 2;
            (kept(middle, radius) <= allowed ? low : high) = middle;
        }
        return low;
    }

private:
    double below(double an) const noexcept {
        const double root = (std::sqrt(2 * distance * acceleration) + 2 * std::sqrt(lost * an)) /
                            (std::sqrt(acceleration) + std::sqrt(an));
        return root * root / 2;
    }
};

}  // namespace plumb
