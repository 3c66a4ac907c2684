// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace plumb {

// Straightness of an axis by a straightedge that is turned over about its length, so that its own error
// changes the sign:
//
//     before = E + s      turned = -E + s      E: the axis, s: the edge
//
// Both readings count up as the plunger is pressed in; it points to the + end of the axis across, and to the
// - end after the edge was turned over. Offset and slope are taken out of each: they are those of the set-up.
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

}  // namespace plumb
