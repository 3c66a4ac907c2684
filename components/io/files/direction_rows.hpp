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

// Why squareness would take a row in no table, behind the rows before it; "" if it takes it. `error` is the
// place of the error in ErrorMotions.
inline std::string misfit(const DirectionRows& rows, std::size_t i, std::size_t error) {
    using csv::decimal;
    const char* const unit = error < 3 ? " mm" : " rad";
    for (double DirectionRow::*const way : {&DirectionRow::up, &DirectionRow::down}) {
        const double value = rows[i].*way;
        if (!(std::abs(value) <= error_table_file::largest[error]))
            return "an error of " + decimal(value) + unit + " is beyond " +
                   decimal(error_table_file::largest[error]) + unit;
        if (i == 0) continue;
        const double from = rows[i - 1].*way, step = rows[i].position - rows[i - 1].position;
        const double difference = rows[i].up - rows[i].down, before = rows[i - 1].up - rows[i - 1].down;
        if (error_table_file::too_steep(error, value - from, step, difference - before))
            return "from " + decimal(from) + " to " + decimal(value) + unit + " within " + decimal(step) +
                   " mm is too steep";
    }
    const double most = 2 * error_table_file::most_half[error];
    if (!(std::abs(rows[i].up - rows[i].down) <= most))
        return "the directions differ by " + decimal(std::abs(rows[i].up - rows[i].down)) + unit +
               ", more than " + decimal(most) + unit;
    return "";
}

// The rows with an error of 0 at `place`, the mean of both directions there, between two rows linear.
inline DirectionRows zeroed(DirectionRows rows, double place) {
    if (!(place >= rows.front().position && place <= rows.back().position))
        throw std::runtime_error(
            "the zero at " + csv::decimal(place) + " mm is not within the positions of the table, " +
            csv::decimal(rows.front().position) + " to " + csv::decimal(rows.back().position) + " mm");
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
