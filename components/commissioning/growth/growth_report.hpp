// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/commissioning/growth/growth_analysis.hpp"

#include <string>
#include <vector>

namespace plumb::commissioning {

// Every deviation of one test, a line each.
std::string growth_csv(const GrowthAnalysis& test);

// All results of all tests in full precision.
std::string growth_json(const std::vector<GrowthAnalysis>& tests);

// A few lines for the terminal.
std::string growth_summary(const GrowthAnalysis& test);

// The sentence about the compensation, with axes and sensors.
std::string compensation_sentence(const GrowthAnalysis& test);

}  // namespace plumb::commissioning
