// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/csv.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/geometry/probed_shape.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// Probed points, as CSV: a header, and a row for each point.
//
//     # square of 300 mm, probe 6 mm
//     X,Y,normal,turned
//     103.0012,-120.5,0,0
//     -203.0107,80.25,180,0
//
// Two columns are named for axes that are not parallel: they span the plane. `normal` is the direction of
// the face, in deg from the + end of the axis that comes first in XYZUVW towards the + end of the other;
// without it the points lie around a ring. `turned` is the angle by which the artifact was turned, in the
// same sense. Columns come in any order. Lines that are empty or begin with # are ignored. A number has a
// decimal point in every locale.
struct ProbedPointsFile {
    ProbedShape shape;               // as far as the file has a column for it
    std::vector<std::size_t> lines;  // of the points
};

namespace probed_points_file {

using csv::decimal, csv::quoted;

constexpr std::string_view axes = "XYZUVW";
constexpr double longest = 1e5;  // mm
constexpr std::size_t most_points = 4096;

class Reader {
public:
    // A length of the file is `unit` mm. Throws std::runtime_error, with name, line, reason and value.
    static ProbedPointsFile read(const std::string& name, std::string_view text, double unit) {
        return Reader(name, unit).result_of(text);
    }

private:
    Reader(const std::string& name, double unit) : name_(name), unit_(unit) {}

    ProbedPointsFile result_of(std::string_view text) {
        for (text = csv::without_byte_order_mark(text); !text.empty();) {
            const std::size_t end = std::min(text.find('\n'), text.size());
            ++line_;
            take(csv::trimmed(text.substr(0, end)));
            text.remove_prefix(std::min(end + 1, text.size()));
        }
        if (columns_.empty()) throw std::runtime_error(name_ + ": there is no header such as X,Y in it");
        if (file_.lines.empty()) throw std::runtime_error(name_ + ": there is no point in it");
        return file_;
    }

    [[noreturn]] void refuse(const std::string& why) const {
        throw std::runtime_error(name_ + ": line " + std::to_string(line_) + ": " + why);
    }

    void take(std::string_view line) {
        if (line.empty() || line[0] == '#') return;
        const std::vector<std::string_view> fields = csv::split_at_commas(line);
        columns_.empty() ? begin(fields) : add(fields);
    }

    bool has(std::string_view column) const {
        return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
    }

    void begin(const std::vector<std::string_view>& fields) {
        std::string plane;
        for (const std::string_view field : fields) {
            const bool is_axis = field.size() == 1 && axes.find(field[0]) != std::string_view::npos;
            if (!is_axis && field != "normal" && field != "turned")
                refuse(quoted(field) +
                       " is no column: there are the two axes of the plane, normal and turned");
            if (has(field)) refuse(quoted(field) + " is there twice");
            columns_.emplace_back(field);
            if (is_axis) plane += field;
        }
        if (plane.size() != 2)
            refuse(std::to_string(plane.size()) + " axes are named: there must be two, those of the plane");
        std::sort(plane.begin(), plane.end(), [](char a, char b) { return axes.find(a) < axes.find(b); });
        file_.shape.a = static_cast<Axis>(axes.find(plane[0]));
        file_.shape.b = static_cast<Axis>(axes.find(plane[1]));
        if (parallel(file_.shape.a, file_.shape.b))
            refuse(plane.substr(0, 1) + " and " + plane.substr(1) + " are parallel and span no plane");
        file_.shape.ring = !has("normal");
        columns_[column_of(plane[0])] = "a";
        columns_[column_of(plane[1])] = "b";
    }

    std::size_t column_of(char axis) const {
        return static_cast<std::size_t>(std::find(columns_.begin(), columns_.end(), std::string(1, axis)) -
                                        columns_.begin());
    }

    void add(const std::vector<std::string_view>& fields) {
        if (fields.size() != columns_.size())
            refuse(std::to_string(fields.size()) + (fields.size() == 1 ? " value" : " values") +
                   ", but the header has " + std::to_string(columns_.size()));
        if (file_.lines.size() == most_points) refuse("more than " + std::to_string(most_points) + " points");
        ProbedShape::Point point;
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const bool is_length = columns_[i] == "a" || columns_[i] == "b";
            const std::string title = columns_[i] == "a"   ? std::string(1, letter(file_.shape.a))
                                      : columns_[i] == "b" ? std::string(1, letter(file_.shape.b))
                                                           : columns_[i];
            if (fields[i].empty()) refuse("column " + title + ": there is no value");
            const std::optional<double> value = csv::number(fields[i]);
            if (!value) refuse("column " + title + ": " + quoted(fields[i]) + " is no number");
            const double size = is_length ? *value * unit_ : *value;
            const double limit = is_length ? longest : 360;
            if (!(std::abs(size) <= limit))
                refuse("column " + title + ": " + quoted(fields[i]) + " is beyond " + decimal(limit) +
                       (is_length ? " mm" : " deg"));
            if (is_length)
                point.place[columns_[i] == "a" ? 0 : 1] = size;
            else
                (columns_[i] == "normal" ? point.normal : point.turned) = size * pi / 180;
        }
        file_.shape.points.push_back(point);
        file_.lines.push_back(line_);
    }

    std::string name_;
    double unit_;
    std::size_t line_ = 0;
    std::vector<std::string> columns_;  // those of the axes as a and b
    ProbedPointsFile file_;
};

}  // namespace probed_points_file

inline ProbedPointsFile read_probed_points(const std::filesystem::path& file, double unit) {
    return probed_points_file::Reader::read(file.string(), csv::text_of(file), unit);
}

}  // namespace plumb
