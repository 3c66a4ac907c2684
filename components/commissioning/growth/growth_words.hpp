// SPDX-License-Identifier: GPL-2.0-or-later
// What the report, its charts and the terminal say in the same words.
#pragma once

#include "components/commissioning/growth/growth_analysis.hpp"
#include "components/commissioning/growth/growth_chart.hpp"

#include <string>

namespace plumb::commissioning {

constexpr const char* letters = "XYZ";
constexpr double seconds_per_hour = 3600;

std::string number(double value, int digits = 1);  // a dash if it is not a number
std::string um(double mm);
std::string clause(const GrowthLog& log);  // of ISO 230-3

// A page with its style, and the end of it.
std::string page_begin(const std::string& title);
std::string page_end();

// One axis of a series, for a chart; h and um.
GrowthChart::Line line_of(const GrowthSeries& series, int axis, const std::string& name, int colour,
                          bool dashed);

}  // namespace plumb::commissioning
