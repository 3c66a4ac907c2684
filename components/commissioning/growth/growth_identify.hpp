// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"

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

// The setp lines of axis_growth that the log gives, or the same as JSON. Throws std::runtime_error with the
// log and the reason.
std::string growth_identify(const GrowthLog& log, const GrowthIdentifyOptions& options, bool json);

}  // namespace plumb::commissioning
