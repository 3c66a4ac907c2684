// SPDX-License-Identifier: GPL-2.0-or-later
// The search fits each law to the first blocks of a day, and predicts the next block. It chooses a law of
// several terms for an axis only if this law predicts each block better than no law, and better than a line
// over one temperature.
#pragma once

#include "components/commissioning/growth/growth_observations.hpp"
#include "components/math/growth/growth_identification.hpp"

#include <Eigen/Core>

#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace plumb::commissioning {

constexpr double value_sigma = 0.001;  // mm, of a value
constexpr double determined = 2;       // a coefficient by its sigma

// The terms of the law of one axis.
struct LawForm {
    std::vector<std::size_t> sensors;
    bool slope = false, speed = false;
    double turning = 600, stopped = 2400;

    int terms() const { return static_cast<int>(sensors.size()) * (slope ? 2 : 1) + (speed ? 1 : 0); }
};

struct AxisLaw {
    IdentifiedGrowth found;
    LawForm form;
    double score = std::numeric_limits<double>::infinity();
    double pivot = 0, travel = 0;
    Eigen::VectorXd growth, growth_sigma, slope;  // by sensor of the form
    double by_speed = 0, speed_sigma = 0;
    double none = 0, line = 0;  // mm, what no law and the best line leave of the blocks
};

using AxisLaws = std::array<std::optional<AxisLaw>, 3>;

// Chooses the laws of the axes, beginning with the axis of the largest drift. All axes together use at most
// as many sensors as axis_growth has. The time constants of the spindle are common to them.
AxisLaws best_laws(const GrowthObservations& data);

}  // namespace plumb::commissioning
