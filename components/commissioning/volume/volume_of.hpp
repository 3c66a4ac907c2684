// SPDX-License-Identifier: GPL-2.0-or-later
// The options of plumb volume uncertainty, and the question that they ask.
#pragma once

#include <string>
#include <vector>

#include "components/io/files/direction_rows.hpp"
#include "components/math/geometry/volume_uncertainty.hpp"

namespace plumb::commissioning {

struct VolumeOptions {
    std::string chain, box, reference, tool_u;
    std::vector<std::string> tools, tilts, commons, tables, repeatability;
    double max_correction = 1;  // mm
    int draws = 2000, seed = 1;
    bool json = false;
};

struct VolumeQuestion {
    MeasuredVolume measured;
    VolumePlace reference;
    std::vector<VolumePlace> places;   // 27 of the box, with each tool
    std::vector<std::string> without;  // causes that have no u
    std::vector<std::string> notes;
};

// Throws std::invalid_argument or std::runtime_error with the option or file and the reason.
VolumeQuestion question_of(const VolumeOptions& options);

// The table of the axis in a file, with the lost motion of rows in the place of the error's former columns.
std::string table_with_reversal(const std::string& file, char axis, const std::string& error,
                                const DirectionRows& rows, const std::string& head);

}  // namespace plumb::commissioning
