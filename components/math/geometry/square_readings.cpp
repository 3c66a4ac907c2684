// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/square_readings.hpp"

#include "components/math/blocks/least_squares.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace plumb {

Corner corner_from_square(const SquareReadings& square) {
    const auto refuse = [](const std::string& why) { throw std::invalid_argument(why); };
    const std::size_t count = square.positions.size();
    const auto demand = [&](const std::vector<double>& readings, const std::string& what) {
        if (readings.size() != count)
            refuse(std::to_string(readings.size()) + ' ' + what + " at " + std::to_string(count) +
                   " positions");
    };
    if (parallel(square.moved, square.plunger.towards))
        refuse("the plunger points along " + std::string(1, letter(square.moved)) + ", the axis that moves");
    if (count < 2) refuse("one position is not enough: at least two show how an axis leans");
    demand(square.readings, "readings");
    if (!square.turned.empty()) demand(square.turned, "readings of the turned square");
    if (!(square.uncertainty > 0)) refuse("the uncertainty of a reading is not more than 0");

    constexpr double any_square = 0.01, true_square = 1e-12;  // rad
    double middle = 0;
    for (const double position : square.positions) middle += position / static_cast<double>(count);
    const bool blade_open = !square.turned.empty() || square.square_uncertainty.has_value();
    const Eigen::Index lean = 0, blade = 1, size = 2 + (square.turned.empty() ? 1 : 2);
    const auto fitted = [&](double ratio) {
        LeastSquares fit(size);
        for (std::size_t i = 0; i < count; ++i) {
            Eigen::VectorXd a = Eigen::VectorXd::Zero(size);
            a[lean] = square.positions[i] - middle;
            a[blade] = -a[lean];
            a[2] = 1;
            fit.observe(a, square.readings[i], square.uncertainty * ratio);
            if (square.turned.empty()) continue;
            a[lean] = -a[lean];
            a[2] = 0;
            a[3] = 1;
            fit.observe(a, square.turned[i], square.uncertainty * ratio);
        }
        fit.know(blade, 0, blade_open ? square.square_uncertainty.value_or(any_square) : true_square);
        return fit.solve();
    };
    const auto first = fitted(1);
    if (!first) refuse("the positions are all the same");
    const double ratio = first->ratio;
    const auto solution = fitted(std::max(1.0, ratio));
    const double angle = angle_from_slope(solution->parameters[lean]);
    return {square.moved,
            square.plunger.towards,
            -square.plunger.sign * angle,
            std::sqrt(solution->covariance(lean, lean)),
            ratio,
            square.turned.empty() ? square.square_uncertainty.value_or(0) : 0};
}

}  // namespace plumb
