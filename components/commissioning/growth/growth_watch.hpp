// SPDX-License-Identifier: GPL-2.0-or-later
// Learns from the courses of a growth test how far each temperature departs from the others by the spindle.
#pragma once

#include "components/commissioning/growth/growth_observations.hpp"
#include "components/math/growth/growth_law.hpp"
#include "components/math/growth/temperature_watch.hpp"

#include <optional>
#include <vector>

namespace plumb::commissioning {

struct GrowthWatch {
    TemperatureWatch::Settings settings;  // by the place of a sensor in `sensors`
    SpindleDrive::Settings drive;
};

// `growths`: by how much an axis grows at most by each sensor, mm/K. `drive`: of the law, if it has a term by
// speed; otherwise the one that predicts the temperatures best. Nothing with fewer than two sensors, or
// without a spindle speed.
std::optional<GrowthWatch> learned_watch(const std::vector<const GrowthObservations::Sensor*>& sensors,
                                         const std::vector<double>& growths,
                                         const std::vector<GrowthSamples>& speeds,
                                         const std::optional<SpindleDrive::Settings>& drive);

}  // namespace plumb::commissioning
