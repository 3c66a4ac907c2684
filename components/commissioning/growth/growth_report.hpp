// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/commissioning/growth/growth_analysis.hpp"

#include <string>
#include <vector>

namespace plumb::commissioning {

// Words that the results and the terminal share.
constexpr const char* letters = "XYZ";
constexpr double seconds_per_hour = 3600;
std::string number(double value, int digits = 1);  // a dash if it is not a number
std::string um(double mm);
std::string clause(const GrowthLog& log);  // of ISO 230-3

// All results of all tests in full precision.
std::string growth_json(const std::vector<GrowthAnalysis>& tests);

// A few lines for the terminal.
std::string growth_summary(const GrowthAnalysis& test);

// The sentence about the compensation, with axes and sensors.
std::string compensation_sentence(const GrowthAnalysis& test);

}  // namespace plumb::commissioning
