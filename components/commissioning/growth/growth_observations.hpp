// SPDX-License-Identifier: GPL-2.0-or-later
// What plumb growth identify learns from: the values of the courses of one or several days, with the sensors
// that were chosen, the blocks that are predicted in turn, and their weights.
#pragma once

#include "components/commissioning/growth/growth_identify.hpp"

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb::commissioning {

struct GrowthObservations {
    struct Sensor {
        std::string name;
        int number = -1;                  // of axis_growth, from 0; -1 if the law may number it
        bool air = false;                 // it measures the air, not a part of the machine
        std::vector<GrowthSamples> days;  // of each day

        double reference(std::size_t day) const { return days[day].front().second; }
        double rise(std::size_t day, double time) const { return value_at(days[day], time) - reference(day); }
    };
    struct Value {
        Eigen::Vector3d place{0, 0, 0};
        std::size_t day = 0;
        double time = 0, weight = 0;
        int group = 0, block = 0;
    };

    std::vector<Value> values;
    std::vector<Sensor> sensors;
    std::optional<Sensor> artifact;     // whose own expansion is a term
    std::vector<GrowthSamples> speeds;  // of each day
    bool places = false;                // the values are positions of the axes
    bool turned = false;                // the spindle has had enough speeds for a term
    std::array<bool, 3> measured{};
};

// Throws std::runtime_error with the file and the reason.
GrowthObservations growth_observations(const std::vector<GrowthCourse>& days,
                                       const GrowthIdentifyOptions& options);

// The travel of an axis in the values.
std::pair<double, double> travel_of(const GrowthObservations& data, int axis);

}  // namespace plumb::commissioning
