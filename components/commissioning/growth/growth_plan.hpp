// SPDX-License-Identifier: GPL-2.0-or-later
// The course of a growth test that separates the terms of a law: speeds, rests and an open shop door, in the
// order that leaves the least uncertainty of the growth on another day.
#pragma once

#include "components/commissioning/growth/growth_course.hpp"

#include <string>
#include <vector>

namespace plumb::commissioning {

// The machine for which a growth test is planned: how its sensors rise.
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

struct GrowthPlanOptions {
    double hours = 4;
    double work = 0, pass = 10;  // min, of a cycle; work 0: 30, or less for four cycles
    double fastest = 8000;       // rpm
    bool door = false;           // somebody can open the shop door
    GrowthPlanMachine machine;
};

struct GrowthPlan {
    struct Cycle {
        double speed = 0;  // rpm
        bool door = false;
    };
    struct Term {
        std::string name, unit;
        double before = 0, after = 0, hour_more = 0;  // standard uncertainty, um/K or um
    };

    GrowthPlanOptions options;
    std::vector<Cycle> cycles;
    std::vector<Term> terms;  // the last one is the growth on another day, by all of them

    std::string text() const;
    std::string json() const;
    // The subroutine growth_plan, for growth_work.
    std::string program() const;
};

// Throws std::runtime_error if the time is too short for three cycles.
GrowthPlan growth_plan(const GrowthPlanOptions& options);

}  // namespace plumb::commissioning
