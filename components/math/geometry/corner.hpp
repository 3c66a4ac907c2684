// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/axis_chain.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb {

// The result of a square for two axes that are not parallel: the angle between their + ends, less 90 deg.
// Leaning towards the other's + end closes it.
struct Corner {
    Axis a = Axis::X, b = Axis::Y;
    double opening = 0;      // rad
    double uncertainty = 0;  // rad, standard
    double scatter = 0;      // of the readings, as a multiple of the stated one; 0: unknown
    double own = 0;          // rad, part of the uncertainty that the square or artifact itself has

    bool is_of(Axis one, Axis other) const noexcept {
        return (a == one && b == other) || (a == other && b == one);
    }
};

inline std::string name(const Corner& corner) {
    return std::string(1, letter(corner.a)) + letter(corner.b);
}

// The measured shape: a part or a path that the axes have drawn, measured with a true instrument; or a true
// artifact, measured by the axes, in their coordinates. An artifact reads as the mirror image of a part.
enum class MeasuredObject { part, artifact };

// Diagonals of a rectangle along the axes: `rising` leads from the corner at the - ends to that at the +
// ends, `falling` between the other two. Lengths in any unit.
struct Diagonals {
    double rising = 0, falling = 0;
    double a = 0, b = 0;         // sides; 0: it is a square
    double uncertainty = 0;      // standard, of either diagonal
    double own_opening = 0;      // rad, of an artifact's own corner, and
    double own_uncertainty = 0;  // its standard uncertainty
};

// By the law of cosines: rising^2, falling^2 = a^2 + b^2 -/+ 2 a b sin(opening). Throws
// std::invalid_argument with the invalid value.
inline Corner corner_from_diagonals(Axis a, Axis b, const Diagonals& d, MeasuredObject object) {
    const auto refuse = [](const std::string& why) { throw std::invalid_argument(why); };
    if (!(d.rising > 0 && d.falling > 0)) refuse("a diagonal is not longer than 0");
    if (!(d.uncertainty > 0)) refuse("the uncertainty of the diagonals is not more than 0");
    const double rising = d.rising * d.rising, falling = d.falling * d.falling;
    const bool square = d.a == 0 && d.b == 0;
    if (!square && !(d.a > 0 && d.b > 0)) refuse("a side is not longer than 0");
    if (!square) {
        const double expected = std::hypot(d.a, d.b), measured = std::sqrt((rising + falling) / 2);
        if (std::abs(measured / expected - 1) > 0.01)
            refuse("diagonals of " + std::to_string(d.rising) + " and " + std::to_string(d.falling) +
                   " mm are not those of sides of " + std::to_string(d.a) + " and " + std::to_string(d.b) +
                   " mm, which are about " + std::to_string(expected) + " mm");
    }
    const double four_sides = square ? rising + falling : 4 * d.a * d.b;
    const double sine = (falling - rising) / four_sides;
    if (!(std::abs(sine) < 0.1))
        refuse("diagonals of " + std::to_string(d.rising) + " and " + std::to_string(d.falling) +
               " mm are not those of a rectangle: it would be out of square by " + std::to_string(sine) +
               " rad");
    const double opening = std::asin(sine);
    const double slope = 2 * std::sqrt(rising + falling) / four_sides / std::cos(opening);
    Corner corner{a, b, opening, d.uncertainty * slope, 0};
    if (object == MeasuredObject::artifact) {
        if (!(std::abs(d.own_opening) < 0.1))
            refuse("an artifact is not out of square by " + std::to_string(d.own_opening) + " rad");
        corner.opening = d.own_opening - opening;
        corner.uncertainty = std::hypot(corner.uncertainty, d.own_uncertainty);
        corner.own = d.own_uncertainty;
    }
    if (!(std::abs(corner.opening) < 0.1))
        refuse("the axes would be out of square by " + std::to_string(corner.opening) + " rad");
    return corner;
}

// The mean of the same corner, measured several times; weighted, and less certain if the measurements
// disagree. They share one square or artifact, so its own uncertainty does not average out.
inline Corner mean_of(const std::vector<Corner>& corners) {
    Corner result = corners.front();
    double weights = 0, opening = 0, own = 0;
    for (const Corner& corner : corners) {
        const double weight = 1 / (corner.uncertainty * corner.uncertainty);
        weights += weight;
        opening += weight * corner.opening;
        own += weight * corner.own;
    }
    result.opening = opening / weights;
    result.own = own / weights;
    double readings = 0, squares = 0;
    for (const Corner& corner : corners) {
        const double all = corner.uncertainty * corner.uncertainty;
        const double of_readings = std::max(all - corner.own * corner.own, 1e-6 * all);  // variance
        readings += of_readings / (all * all * weights * weights);
        squares += std::pow(corner.opening - result.opening, 2) /
                   (of_readings + std::pow(corner.own - result.own, 2));
    }
    const double ratio =
        std::sqrt(squares / static_cast<double>(std::max<std::size_t>(corners.size() - 1, 1)));
    result.uncertainty = std::hypot(std::max(1.0, ratio) * std::sqrt(readings), result.own);
    result.scatter = corners.size() > 1 ? ratio : result.scatter;
    return result;
}

// Each corner once, in the order in which they come first.
inline std::vector<Corner> each_once(const std::vector<Corner>& measured) {
    std::vector<std::vector<Corner>> groups;
    for (const Corner& one : measured) {
        const auto same = std::find_if(groups.begin(), groups.end(),
                                       [&](const auto& group) { return group.front().is_of(one.a, one.b); });
        if (same == groups.end())
            groups.push_back({one});
        else
            same->push_back(one);
    }
    std::vector<Corner> corners;
    for (const auto& group : groups) corners.push_back(group.size() == 1 ? group.front() : mean_of(group));
    return corners;
}

}  // namespace plumb
