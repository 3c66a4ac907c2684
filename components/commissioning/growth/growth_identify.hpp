// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <string>
#include <vector>

namespace plumb::commissioning {

struct GrowthIdentifyOptions {
    std::string instance = "axis-growth";
    std::string artifact = "artifact";  // name of the sensor of the artifact, whose own expansion is left out
    std::vector<std::string> sensors;   // names; all but that of the artifact if empty
    bool speed = true;                  // the spindle speed may be a term
    double speed_exponent = 1.7;
};

// The law of a machine, as settings of axis_growth. Lengths are millimetres.
struct GrowthIdentified {
    struct Axis {
        bool probed = false;
        bool used = false;  // its law leaves less than 0.8 of the drift in passes that it did not see
        double drift = 0, rest = 0, predicted_rest = 0;  // rms; predicted_rest of passes that were left out
        bool slope = false, speed = false;               // terms of the law
    };
    std::array<Axis, 3> axes;
    std::string lines;  // setp, and comments

    // One for each axis, with its letter.
    std::string sentence(int axis) const;
};

// Throws std::runtime_error with the log and the reason.
GrowthIdentified growth_identified(const GrowthLog& log, const GrowthIdentifyOptions& options = {});

// The text of a settings file: the setp lines, and the remaining drift of each axis as a comment.
std::string growth_settings(const GrowthLog& log, const GrowthIdentified& found);

// The same as JSON.
nlohmann::json growth_identified_json(const GrowthIdentified& found);

}  // namespace plumb::commissioning
