// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/table_file.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/geometry/probed_shape.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// Probed points, as a table: heads, and a row for each point.
//
//     # square of 300 mm, probe 6 mm
//     X,Y,normal,turned
//     103.0012,-120.5,0,0
//     -203.0107,80.25,180,0
//
// Two columns are named for axes that are not parallel: they span the plane. `normal` is the direction of
// the face, in deg from the + end of the axis that comes first in XYZUVW towards the + end of the other;
// without it the points lie around a ring. `turned` is the angle by which the artifact was turned, in the
// same sense. Columns come in any order, and may state their unit.
struct ProbedPointsFile {
    ProbedShape shape;               // as far as the file has a column for it
    std::vector<std::size_t> lines;  // of the points
};

namespace probed_points_file {

using csv::decimal;

constexpr std::string_view axes = "XYZUVW";
constexpr double longest = 1e5;  // mm
constexpr std::size_t most_points = 4096;

class Reader {
public:
    // A length of the file is `unit` mm. Throws std::runtime_error, with name, line, reason and value.
    static ProbedPointsFile read(const std::string& name, std::string_view text, double unit) {
        const TableFile table(name, text);
        ProbedPointsFile file;
        const auto columns = columns_of(table, file.shape);
        if (table.rows() > most_points)
            table.refuse(table.line(most_points), "more than " + std::to_string(most_points) + " points");
        for (std::size_t row = 0; row < table.rows(); ++row) {
            ProbedShape::Point point;
            for (std::size_t i = 0; i < columns.size(); ++i) {
                const bool is_length = columns[i] < 2;
                const double size = table.value(row, i, is_length ? unit : 1),
                             limit = is_length ? longest : 360;
                if (!(std::abs(size) <= limit))
                    table.refuse_value(row, i, "is beyond " + decimal(limit) + (is_length ? " mm" : " deg"));
                if (is_length)
                    point.place[columns[i]] = size;
                else
                    (columns[i] == normal ? point.normal : point.turned) = size * pi / 180;
            }
            file.shape.points.push_back(point);
            file.lines.push_back(table.line(row));
        }
        return file;
    }

private:
    static constexpr int normal = 2, turned = 3;  // columns beside 0 and 1, the axes of the plane

    static std::vector<int> columns_of(const TableFile& table, ProbedShape& shape) {
        std::string plane;
        for (const TableFile::Column& its : table.columns()) {
            const char axis = static_cast<char>(std::toupper(static_cast<unsigned char>(its.name[0])));
            const bool is_axis = its.name.size() == 1 && axes.find(axis) != std::string_view::npos;
            if (!is_axis && its.name != "normal" && its.name != "turned")
                table.refuse(table.head_line(),
                             csv::quoted(its.head) +
                                 " is no column: there are the two axes of the plane, normal and turned");
            const auto wanted = is_axis ? TableFile::length : TableFile::angle;
            if (!its.unit.empty() && its.known.quantity != wanted)
                table.refuse(table.head_line(), csv::quoted(its.head) + " has no unit of " +
                                                    (is_axis ? "a length" : "an angle"));
            if (is_axis) plane += axis;
        }
        if (plane.size() != 2)
            table.refuse(table.head_line(), std::to_string(plane.size()) +
                                                " axes are named: there must be two, those of the plane");
        std::sort(plane.begin(), plane.end(), [](char a, char b) { return axes.find(a) < axes.find(b); });
        shape.a = static_cast<Axis>(axes.find(plane[0]));
        shape.b = static_cast<Axis>(axes.find(plane[1]));
        if (parallel(shape.a, shape.b))
            table.refuse(table.head_line(),
                         plane.substr(0, 1) + " and " + plane.substr(1) + " are parallel and span no plane");
        std::vector<int> columns;
        shape.ring = true;
        for (const TableFile::Column& its : table.columns()) {
            shape.ring &= its.name != "normal";
            columns.push_back(its.name == "normal"                                                ? normal
                              : its.name == "turned"                                              ? turned
                              : std::toupper(static_cast<unsigned char>(its.name[0])) == plane[0] ? 0
                                                                                                  : 1);
        }
        return columns;
    }
};

}  // namespace probed_points_file

inline ProbedPointsFile read_probed_points(const std::filesystem::path& file, double unit) {
    return probed_points_file::Reader::read(file.string(), csv::text_of(file, TableFile::most_bytes), unit);
}

}  // namespace plumb
