// SPDX-License-Identifier: GPL-2.0-or-later
// Words that the results and the terminal share.
#pragma once

#include "components/commissioning/growth/growth_analysis.hpp"

#include <string>

namespace plumb::commissioning {

constexpr const char* letters = "XYZ";
constexpr double seconds_per_hour = 3600;

std::string number(double value, int digits = 1);  // a dash if it is not a number
std::string um(double mm);
std::string clause(const GrowthLog& log);  // of ISO 230-3

}  // namespace plumb::commissioning
