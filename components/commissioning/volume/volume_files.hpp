// SPDX-License-Identifier: GPL-2.0-or-later
// The files that plumb volume reads beside error tables.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "components/io/files/direction_rows.hpp"
#include "components/math/geometry/circle_test.hpp"
#include "components/math/geometry/error_table.hpp"
#include "components/math/geometry/lost_motion.hpp"

namespace plumb::commissioning {

// Columns position, up1, up2, ..., down1, down2, ... in mm; an empty field is a reading that was not taken.
// Throws std::runtime_error with file, line and reason, as all below.
std::vector<BothWays> read_readings(const std::string& file);

// Columns motor and load in mm, of one axis over any motion: read into `places` parts of the travel, the
// direction turning after `distance`.
std::vector<BothWays> read_recording(const std::string& file, int places, double distance);

// Lines angle,radius in deg and mm; a head of lines # NAME: VALUE.
struct BallbarFile {
    std::string plane;            // XY
    double radius = 0, feed = 0;  // mm, mm/min
    CircularPath path;
};
BallbarFile read_ballbar(const std::string& file);

// Columns position, before and turned in mm, of a straightedge.
struct StraightedgeRow {
    double position, before, turned;
};
std::vector<StraightedgeRow> read_straightedge(const std::string& file);

// EXX is 0, and ECX is 5.
inline std::size_t error_index(const std::string& error) {
    return error[1] >= 'X' ? static_cast<std::size_t>(error[1] - 'X')
                           : static_cast<std::size_t>(error[1] - 'A') + 3;
}

// A table with the uncertainties that its head states.
struct UncertainTable {
    char axis = 0;
    std::vector<ErrorTable::Row> mean, half;  // half is empty if no error differs by direction
    std::vector<std::string> columns;         // of the errors, as EXX+
    std::map<std::string, double> u;          // by error; EXX+ for the half difference; mm or rad
    struct Common {
        double value = 0;
        bool per_position = false;  // per mm of the position
    };
    std::map<std::string, Common> common;
    std::map<std::string, Common> drift;          // of all rows together, in a year
    std::map<std::string, double> repeatability;  // mm, standard deviation of a position
    std::string file, date, by;
    double valid_for = 365;             // days
    std::optional<double> temperature;  // degC
};
// Refuses a table of a rotary axis, unless `rotary` takes its letter.
std::vector<UncertainTable> read_uncertain_tables(const std::vector<std::string>& files,
                                                  std::string* rotary = nullptr);

// Columns distance and deviation in mm, along a diagonal from its begin.
struct DiagonalStep {
    double distance, deviation;
};
std::vector<DiagonalStep> read_steps(const std::string& file);

// One error of the only table of a file.
struct TableError {
    char axis = 0;
    DirectionRows rows;
};
TableError read_table_error(const std::string& file, const std::string& error);

}  // namespace plumb::commissioning
