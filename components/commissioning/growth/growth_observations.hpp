// SPDX-License-Identifier: GPL-2.0-or-later
// What plumb growth identify learns from: the values of a course, with the sensors that were chosen, the
// stretches that are left out in turn, and their weights.
#pragma once

#include "components/commissioning/growth/growth_identify.hpp"

#include <array>
#include <optional>
#include <utility>
#include <vector>

namespace plumb::commissioning {

struct GrowthObservations {
    const GrowthCourse* course = nullptr;
    std::vector<GrowthCourse::Value> values;
    std::vector<double> weight;
    std::vector<int> duty;
    std::vector<GrowthCourse::Sensor> sensors;  // without the sensor of the structure
    std::optional<GrowthCourse::Sensor> structure, artifact;
    bool turned = false;
    double cold = 0;  // s, when the machine was cold
    std::array<bool, 3> measured{};

    double reference(const GrowthCourse::Sensor& sensor) const { return value_at(sensor.samples, cold); }
    // As GrowthLaw counts it.
    double rise(const GrowthCourse::Sensor& sensor, double time) const {
        return value_at(sensor.samples, time) - reference(sensor) - (structure ? common(time) : 0);
    }
    double common(double time) const { return value_at(structure->samples, time) - reference(*structure); }
};

// Throws std::runtime_error with the file and the reason.
GrowthObservations growth_observations(const GrowthCourse& course, const GrowthIdentifyOptions& options);

// The travel of an axis in the values.
std::pair<double, double> travel_of(const GrowthObservations& data, int axis);

}  // namespace plumb::commissioning
