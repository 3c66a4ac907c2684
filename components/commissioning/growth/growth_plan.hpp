// SPDX-License-Identifier: GPL-2.0-or-later
// The course of a growth test that separates the terms of a law: speeds, rests and an open shop door, in the
// order that leaves the least uncertainty of the growth on another day.
#pragma once

#include "components/commissioning/growth/growth_plan_machine.hpp"

#include <string>
#include <vector>

namespace plumb::commissioning {

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
