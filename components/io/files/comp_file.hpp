// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/direction_rows.hpp"

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// The screw compensation of LinuxCNC, [JOINT_N]COMP_FILE: lines of
//
//     nominal forward reverse
//
// in machine units, with rising nominal positions. COMP_FILE_TYPE 0: forward and reverse are the places
// that the axis reached, so E = place - nominal. Type 1: they are trims that LinuxCNC adds to the motor's
// command, so E = -trim. LinuxCNC interpolates between them and ends its reading without a word at the
// first line that is not of this form; here such a file is refused.
namespace comp_file {

constexpr std::size_t most_rows = 256;

// `millimetres` in a machine unit.
inline DirectionRows read(const std::string& name, std::string_view text, int type, double millimetres) {
    const direction_rows::Lines lines(name, text);
    DirectionRows rows;
    if (type != 0 && type != 1)
        lines.refuse("COMP_FILE_TYPE " + std::to_string(type) + " does not exist: it is 0 or 1");
    std::size_t ended = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (lines[i].empty()) {
            if (ended == 0) ended = i + 1;
            continue;
        }
        if (ended != 0) lines.refuse(ended - 1, "the line is empty, and LinuxCNC reads nothing behind it");
        const std::vector<double> row = lines.numbers(i);
        if (row.size() != 3)
            lines.refuse(
                i, error_table_file::counted(row.size(), "value") + ", not nominal, forward and reverse");
        if (rows.size() == most_rows) lines.refuse(i, "LinuxCNC takes no more than 256 lines");
        const auto error = [&](double given) {
            return (type == 0 ? given - row[0] : 0 - given) * millimetres;
        };
        rows.push_back({row[0] * millimetres, error(row[1]), error(row[2])});
        if (rows.size() > 1 && !(rows.back().position > rows[rows.size() - 2].position))
            lines.refuse(i, csv::decimal(row[0]) + " is not beyond " +
                                csv::decimal(rows[rows.size() - 2].position / millimetres));
        for (const double its : {rows.back().up, rows.back().down})
            if (!(std::abs(its) <= error_table_file::largest[0]))
                lines.refuse(i, "an error of " + csv::decimal(its) + " mm is beyond 10 mm; is it type " +
                                    std::to_string(1 - type) + '?');
    }
    if (rows.size() < 2) lines.refuse("there are fewer than 2 lines in it");
    return rows;
}

inline std::string text(const DirectionRows& rows, int type, double millimetres) {
    if (rows.size() > most_rows)
        throw std::runtime_error(std::to_string(rows.size()) + " rows: LinuxCNC takes no more than 256");
    std::string result;
    for (const DirectionRow& row : rows) {
        const double up = type == 0 ? row.position + row.up : 0 - row.up,
                     down = type == 0 ? row.position + row.down : 0 - row.down;
        char line[120];
        std::snprintf(line, sizeof line, "%.9f %.9f %.9f\n", row.position / millimetres, up / millimetres,
                      down / millimetres);
        result += line;
    }
    return result;
}

}  // namespace comp_file
}  // namespace plumb
