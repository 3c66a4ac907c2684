// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/csv.hpp"
#include "components/io/files/error_table_file.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// One error of an axis in both directions of motion, in mm or rad: actual less nominal. The form between
// the files of others and error tables.
struct DirectionRow {
    double position = 0;  // mm
    double up = 0, down = 0;
};
using DirectionRows = std::vector<DirectionRow>;

namespace direction_rows {

// Lines of a text without their ends, from 1 on; a reader refuses one with its number.
class Lines {
public:
    Lines(const std::string& name, std::string_view text) : name_(name) {
        for (text = csv::without_byte_order_mark(text); !text.empty();) {
            const std::size_t end = text.find('\n');
            lines_.push_back(csv::trimmed(text.substr(0, end)));
            text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        }
    }

    std::size_t size() const { return lines_.size(); }
    std::string_view operator[](std::size_t i) const { return lines_[i]; }
    [[noreturn]] void refuse(std::size_t i, const std::string& why) const {
        throw std::runtime_error(name_ + ": line " + std::to_string(i + 1) + ": " + why);
    }
    [[noreturn]] void refuse(const std::string& why) const { throw std::runtime_error(name_ + ": " + why); }

    // Numbers between blanks.
    std::vector<double> numbers(std::size_t i) const {
        std::vector<double> result;
        for (std::string_view rest = lines_[i]; !rest.empty();) {
            const std::size_t end = rest.find_first_of(" \t");
            const std::string_view word = rest.substr(0, end);
            const auto value = csv::number(word);
            if (!value)
                refuse(i,
                       csv::quoted(word) + " is no number" +
                           (word.find(',') == std::string_view::npos ? "" : "; the decimal mark is a point"));
            result.push_back(*value);
            rest = end == std::string_view::npos ? "" : csv::trimmed(rest.substr(end));
        }
        return result;
    }

private:
    std::string name_;
    std::vector<std::string_view> lines_;
};

// The rows with an error of 0 at `place`, the mean of both directions there, between two rows linear.
inline DirectionRows zeroed(DirectionRows rows, double place) {
    if (rows.size() < 2 || place < rows.front().position || place > rows.back().position)
        throw std::runtime_error("the zero at " + csv::decimal(place) +
                                 " is beyond the positions of the table");
    double zero = 0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
        const DirectionRow &a = rows[i - 1], &b = rows[i];
        if (place > b.position) continue;
        const double part = (place - a.position) / (b.position - a.position);
        zero = ((a.up + a.down) * (1 - part) + (b.up + b.down) * part) / 2;
        break;
    }
    for (DirectionRow& row : rows) {
        row.up -= zero;
        row.down -= zero;
    }
    return rows;
}

// A table file, judged as any other. `error` is one as EXX; `head` has lines that begin with #.
inline std::string table_text(char axis, const std::string& error, const DirectionRows& rows,
                              const std::string& head) {
    std::string text = head;
    bool directed = false;
    for (const DirectionRow& row : rows) directed |= row.up != row.down;
    text += std::string(1, axis) + ',' + (directed ? error + "+," + error + "-" : error) + '\n';
    for (const DirectionRow& row : rows)
        text += csv::decimal(row.position) + ',' + csv::decimal(row.up) +
                (directed ? ',' + csv::decimal(row.down) : "") + '\n';
    text += error_table_file::end_line(rows.size()) + '\n';
    return error_table_file::Reader::sealed("the table", text);
}

}  // namespace direction_rows
}  // namespace plumb
