// SPDX-License-Identifier: GPL-2.0-or-later
// Fits columns of numbers from anywhere.
#pragma once

#include <string>
#include <vector>

namespace plumb::commissioning {

struct GrowthFitOptions {
    std::string file;
    std::string time = "time_s";       // name of the column of times
    double time_unit = 1;              // s
    std::vector<std::string> columns;  // all others if empty
    double uncertainty = 0;            // of a value, in its unit; 0 if unknown
};

// A line of results for each column, or JSON. Throws std::runtime_error with file, line and reason.
std::string growth_fit(const GrowthFitOptions& options, bool json);

}  // namespace plumb::commissioning
