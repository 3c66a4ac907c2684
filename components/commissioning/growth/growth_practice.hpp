// SPDX-License-Identifier: GPL-2.0-or-later
// What ISO 230-3 asks for beside the growth of the machine that works: its cool-down, the ends of the travel
// of each axis, and the environment alone. Lengths are millimetres.
#pragma once

#include "components/commissioning/growth/growth_visits.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace plumb::commissioning {

struct GrowthAnalysis;

struct GrowthPractice {
    // One axis, in the mean over the bores, in the state that decides when the machine is warm.
    struct CoolDown {
        double warm = 0, left = 0;  // deviation in the last warm pass, and in the last pass of all
        double rate = 0;            // largest, mm/h
    };
    struct Ends {
        int low = 0, high = 0;                // bores with the least and the largest place along the axis
        double distance = 0;                  // between them
        double at_low = 0, at_high = 0;       // deviation in the last warm pass
        double strain = 0, strain_sigma = 0;  // of the axis, mm in a mm; standard
    };
    double cooled_for = 0;  // s, between the last warm pass and the last one; 0: no cool-down was recorded
    std::array<std::optional<CoolDown>, 3> cool_down;
    std::array<std::optional<Ends>, 3> ends;
    // By sensor: the range of its temperature over the test, K.
    std::vector<std::pair<std::string, double>> ranges;
};

GrowthPractice growth_practice(const GrowthAnalysis& analysis);

}  // namespace plumb::commissioning
