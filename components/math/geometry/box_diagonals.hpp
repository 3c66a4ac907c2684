// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

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

}  // namespace plumb
