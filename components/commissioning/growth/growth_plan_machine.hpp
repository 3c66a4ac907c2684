// SPDX-License-Identifier: GPL-2.0-or-later
// The machine for which a growth test is planned: how its sensors rise.
#pragma once

#include "components/commissioning/growth/growth_course.hpp"

#include <string>

namespace plumb::commissioning {

struct GrowthPlanMachine {
    // At the highest speed for ever. Half of the rise of the structure is by motion.
    double spindle_rise = 15,
           structure_rise = 5;  // K, of the spindle against the structure; of the structure
    double turning_time = 1500, stopped_time = 3600;  // s, of the spindle
    double structure_time = 6000;                     // s
    double rest = 2;                                  // um, that the law leaves of a pass
    bool artifact_known = false;                      // its expansion is taken out
    std::string log;                                  // that shows it; empty for a usual machine
};

// By the temperatures, the speeds and the law of an earlier test. Throws std::runtime_error with file and
// reason.
GrowthPlanMachine plan_machine_of(const GrowthCourse& course, double fastest);

}  // namespace plumb::commissioning
