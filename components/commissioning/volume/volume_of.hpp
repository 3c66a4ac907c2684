// SPDX-License-Identifier: GPL-2.0-or-later
// The options of plumb volume uncertainty, and the question that they ask.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "components/commissioning/error_list.hpp"
#include "components/commissioning/volume/volume_files.hpp"
#include "components/io/files/direction_rows.hpp"
#include "components/math/geometry/volume_uncertainty.hpp"

namespace plumb::commissioning {

struct VolumeOptions {
    std::string chain, box, reference, tool_u;
    std::string today, temperature;  // as 2026-11-26 and 24degC; none: of the clock, not known
    std::vector<std::string> tools, tilts, commons, tables, repeatability, pivots, steps;
    std::vector<std::string> assumed;  // iso-10791, or a file
    double max_correction = 1;         // mm
    int draws = 2000, seed = 1;
    bool json = false;
};

// As 2026-11-26, of the clock; none if it is not set.
std::string date_of_today();
// Of the last change of a file.
std::string date_of_file(const std::string& file);
// The line of a table's head; none for no date. Throws std::invalid_argument if it is none.
std::string date_line(const std::string& date);

struct VolumeQuestion {
    MeasuredVolume measured;
    VolumePlace reference;
    std::vector<VolumePlace> places;  // 27 of the box, with each tool
    std::array<double, 3> low{}, high{};
    ErrorList list{AxisChain{}};
    struct Note {
        std::string kind, of;          // kind: a word for a screen
        double first = 0, second = 0;  // days or degC, as in the text
        std::string text;
    };
    std::vector<Note> notes;
    std::vector<UncertainTable> tables;
};

// A length along a body diagonal minus its nominal length, in mm, predicted from the measured errors.
struct DiagonalPoint {
    double without = 0, rest = 0;  // before and after correction
    double U = 0;                  // of both
};
struct DiagonalState {
    std::string name;  // PPP: all axes go to their + end; NPP: X goes to its - end
    double length = 0;
    DiagonalPoint end;
    struct Step {
        double distance, measured;
        DiagonalPoint predicted;
    };
    std::vector<Step> steps;
};

// The body diagonals of the box, with the first tool.
std::vector<DiagonalState> diagonals_of(const VolumeQuestion& question, const VolumeOptions& options);

// Throws std::invalid_argument or std::runtime_error with the option or file and the reason.
VolumeQuestion question_of(const VolumeOptions& options);

// The table of the axis in a file, with the lost motion of rows in the place of the error's former columns.
// Its date
// is the older one, of the file or of the rows; none if the file has none.
std::string table_with_reversal(const std::string& file, char axis, const std::string& error,
                                const DirectionRows& rows, const std::string& head, const std::string& date);

}  // namespace plumb::commissioning
