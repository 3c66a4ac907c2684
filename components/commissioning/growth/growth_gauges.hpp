// SPDX-License-Identifier: GPL-2.0-or-later
// A test with displacement sensors that are read continuously at a mandrel, as ISO 230-3 has it. Lengths are
// mm.
#pragma once

#include "components/commissioning/growth/growth_course.hpp"
#include "components/math/growth/growth_curve.hpp"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace plumb::commissioning {

struct GrowthGauges {
    // A displacement along an axis, or a tilt about one.
    struct Quantity {
        std::string name, unit;  // "um", "um/m"
        GrowthSamples samples;   // s since the first value; of this unit, from the first value on
        double at_1_hour = 0, at_4_hours = 0;  // not a number if the spindle did not turn so long
        double warm = 0, range = 0;  // in the end, and range, while the spindle turned or, in a test of
                                     // the environment, in all
        double rate = 0;             // largest change in a quarter of an hour, per h
        double expanded = 0;         // U of a change, by the scatter about a smooth curve
        double left = 0, cooling_rate = 0;  // at the end of the cool-down, and its largest rate
        std::optional<GrowthCurve> curve;   // while the spindle turned
    };

    std::string file, taken;
    bool environment = false;       // the spindle did not turn
    bool steady_duty = true;        // it turned at one speed
    double length = 0;              // s
    double warmed = 0, cooled = 0;  // s, until the spindle stood, and from then on
    double interval = 0;            // s, largest between two values
    std::vector<Quantity> quantities;
    std::vector<std::pair<std::string, double>> ranges;  // of the temperatures, K
    std::vector<std::string> missing;                    // for a test after ISO 230-3

    std::string clause() const;
    std::string text() const;
    nlohmann::json json(const GrowthCourse& course) const;  // with the values as they are read
};

// `distance`: between the two sensors of X and of Y, mm; 0: no tilt. Throws std::runtime_error with file and
// reason.
GrowthGauges growth_gauges(const GrowthCourse& course, double distance);

}  // namespace plumb::commissioning
