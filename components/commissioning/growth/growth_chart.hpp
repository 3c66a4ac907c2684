// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace plumb::commissioning {

// A line chart over hours, as SVG.
struct GrowthChart {
    struct Line {
        std::string name;
        int colour = 0;  // 0 to 7
        bool dashed = false;
        std::vector<std::pair<double, double>> points;  // h, and the unit of y; not a number is a gap
    };
    std::string file;  // name of the PNG, without its ending
    std::string title;
    std::string unit;  // of y
    std::vector<Line> lines;
    double band = 0;  // a tolerance on both sides of 0; 0 for none

    // For a page, whose style gives the colours in light and dark; or alone, with colours of its own.
    std::string svg(bool alone) const;
};

std::string escaped_xml(const std::string& text);

}  // namespace plumb::commissioning
