// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/commissioning/growth/growth_course.hpp"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <string>
#include <vector>

namespace plumb::commissioning {

struct GrowthIdentifyOptions {
    std::string air = "air";           // name of the sensor of the air, which no law follows closely
    std::vector<std::string> sensors;  // names; all but the artifact's if empty
};

// The law of a machine, as settings of axis_growth. Lengths are millimetres.
struct GrowthIdentified {
    struct Term {
        std::string name;             // "spindle", "speed"
        double value = 0, sigma = 0;  // mm/K; of the speed mm
    };
    struct Axis {
        bool probed = false;
        bool used = false;           // the law predicts blocks better than no law does
        double drift = 0, rest = 0;  // rms, of the fit
        // rms of blocks that the laws predicted: by this law, by none, by a line over one temperature
        double predicted_rest = 0, none_rest = 0, line_rest = 0;
        double scale = 0;                   // standard uncertainty of the size of the law, as a part
        bool slope = false, speed = false;  // terms of the law
        std::vector<Term> terms;
    };
    std::array<Axis, 3> axes;
    std::size_t days = 0;
    std::vector<std::string> sensors;  // by their number in axis_growth; empty where the law reads none
    std::string lines;                 // setp, and comments

    // One for each axis, with its letter.
    std::string sentence(int axis) const;
};

// Throws std::runtime_error with the file and the reason.
// `days`: of one machine, in the order of time.
GrowthIdentified growth_identified(const std::vector<GrowthCourse>& days,
                                   const GrowthIdentifyOptions& options = {});

// The text of a settings file: the setp lines, and as comments the remaining drift and the terms of each
// axis.
std::string growth_settings(const std::string& file, const std::string& begun, const GrowthIdentified& found);

// The same as JSON.
nlohmann::json growth_identified_json(const GrowthIdentified& found);

}  // namespace plumb::commissioning
