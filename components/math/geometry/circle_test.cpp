// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/circle_test.hpp"

#include "components/math/blocks/least_squares.hpp"
#include "components/math/blocks/pi.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace plumb {
namespace {

constexpr double left_out = 2 * pi / 180;  // rad, either side of a turn

std::string degrees(double angle) {
    return std::to_string(static_cast<int>(std::lround(angle * 180 / pi))) + " deg";
}

void check(const CircleSetup& setup, const CircularPath& path) {
    const std::string which = path.clockwise ? "the clockwise path" : "the counter-clockwise path";
    if (path.angles.size() < 36) throw std::invalid_argument(which + " has fewer than 36 points");
    std::vector<double> around;
    for (const double angle : path.angles) around.push_back(angle - 2 * pi * std::floor(angle / (2 * pi)));
    std::sort(around.begin(), around.end());
    std::vector<double> gaps{around.front() + 2 * pi - around.back()};
    for (std::size_t i = 1; i < around.size(); ++i) gaps.push_back(around[i] - around[i - 1]);
    std::sort(gaps.begin(), gaps.end());
    const double covered = 2 * pi - gaps.back(), second = gaps[gaps.size() - 2];  // the largest: an open arc
    if (covered < 330 * pi / 180)
        throw std::invalid_argument(which + " covers " + degrees(covered) + ", and needs 330 deg");
    if (second > 5 * pi / 180)
        throw std::invalid_argument(which + " has gaps of " + degrees(second) + ", and needs 5 deg or less");
    for (std::size_t i = 0; i < path.radii.size(); ++i)
        if (!(std::abs(path.radii[i] - setup.radius) <= 1))
            throw std::invalid_argument(which + " has a radius of " + std::to_string(path.radii[i]) +
                                        " mm at " + degrees(path.angles[i]) +
                                        ", 1 mm or more from the nominal " + std::to_string(setup.radius) +
                                        " mm");
}

// The mean along the circle, of values at angles in any order.
double mean_around(std::vector<std::pair<double, double>> points) {
    for (auto& [angle, value] : points) angle -= 2 * pi * std::floor(angle / (2 * pi));
    std::sort(points.begin(), points.end());
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& [angle, value] = points[i];
        const double next = i + 1 < points.size() ? points[i + 1].first : points[0].first + 2 * pi;
        sum += (next - angle) * (value + points[(i + 1) % points.size()].second) / 2;
    }
    return sum / (2 * pi);
}

bool near_turn(double angle) {
    const double quarter = pi / 2;
    return std::abs(angle - quarter * std::round(angle / quarter)) < left_out;
}

double sign(double x) {
    return x < 0 ? -1 : 1;
}

}  // namespace

CircleResult circle_result(const CircleSetup& setup, const std::vector<CircularPath>& paths) {
    if (!(setup.radius > 1 && setup.radius <= 1e4))
        throw std::invalid_argument("the radius is not from 1 mm to 1e4 mm");
    if (!(setup.speed > 0 && setup.speed <= 1e4)) throw std::invalid_argument("the feed is not above 0");
    if (paths.empty() || paths.size() > 2) throw std::invalid_argument("one or two paths are needed");
    for (const CircularPath& path : paths) check(setup, path);
    const bool both = paths.size() == 2;
    if (both && paths[0].clockwise == paths[1].clockwise)
        throw std::invalid_argument("both paths go in the same direction");

    // r0, centre, centre, (ka - kb)/2, opening, Ba, Bb, across a, lag
    const Eigen::Index count = both ? 9 : 7;
    const double R = setup.radius;
    LeastSquares fit(count);
    const auto row = [&](double t, bool clockwise) {
        const double c = std::cos(t), s = std::sin(t), turn = clockwise ? -1 : 1;
        const double da = -turn * sign(s), db = turn * sign(c);
        Eigen::VectorXd a(count);
        a.head<7>() << 1, c, s, R * std::cos(2 * t), -R * s * c, -da * c / 2, -db * s / 2;
        if (both) a.tail<2>() << da * s, turn * setup.speed * s * c;
        return a;
    };
    std::size_t used = 0;
    for (const CircularPath& path : paths)
        for (std::size_t i = 0; i < path.angles.size(); ++i) {
            if (near_turn(path.angles[i])) continue;
            fit.observe(row(path.angles[i], path.clockwise), path.radii[i] - R, 1);
            ++used;
        }
    const std::optional<LeastSquares::Solution> solution = fit.solve();
    if (!solution) throw std::invalid_argument("the points do not determine the errors");
    double squares = 0;
    CircleResult result;
    double most = -1e9, least = 1e9;
    for (const CircularPath& path : paths) {
        std::vector<std::pair<double, double>> around;
        double high = -1e9, low = 1e9;
        for (std::size_t i = 0; i < path.angles.size(); ++i) {
            const double t = path.angles[i], dr = path.radii[i] - R;
            if (!near_turn(t)) squares += std::pow(dr - row(t, path.clockwise).dot(solution->parameters), 2);
            const double centred =
                dr - solution->parameters[1] * std::cos(t) - solution->parameters[2] * std::sin(t);
            around.emplace_back(t, centred);
            high = std::max(high, centred);
            low = std::min(low, centred);
        }
        (path.clockwise ? result.g_clockwise : result.g_counter) = high - low;
        result.d += mean_around(around) / static_cast<double>(paths.size());
        most = std::max(most, high);
        least = std::min(least, low);
    }
    result.noise = std::sqrt(squares / static_cast<double>(used - static_cast<std::size_t>(count)));
    const auto estimate = [&](Eigen::Index i, double factor) {
        return Estimate{factor * solution->parameters[i],
                        std::abs(factor) * result.noise * std::sqrt(solution->covariance(i, i))};
    };
    result.both_directions = both;
    result.radius_deviation = solution->parameters[0];
    result.centre_a = solution->parameters[1];
    result.centre_b = solution->parameters[2];
    result.scale_difference = estimate(3, 2);
    result.opening = estimate(4, 1);
    result.lost_motion_a = estimate(5, 1);
    result.lost_motion_b = estimate(6, 1);
    if (both) {
        result.across_a = estimate(7, 1);
        result.lag = estimate(8, 1);
    }
    result.g_both = both ? most - least : 0;
    result.f_most = most;
    result.f_least = least;
    return result;
}

}  // namespace plumb
