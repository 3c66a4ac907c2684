// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/crc_32.hpp"
#include "components/io/files/csv.hpp"
#include "components/math/geometry/error_table.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {

// Error tables of axes, as CSV: a header of the axis and of its error motions by their names in
// ISO 230-1, and a row for each position.
//
//     # machine: portal mill 7
//     # date: 2026-11-20
//     # temperature: 20.1 degC
//     Y,EXY,EYY,EZY,EAY,EBY,ECY
//     0,0,0,0,0,0,0
//     50,0.0012,-0.003,0,0,0,1.5e-5
//     # end, seal 3fd7b136, 2 rows
//
// Positions and EX, EY, EZ are in mm, EA, EB, EC in rad, positive where the axes of the machine are.
// An error that differs by the direction of motion has two columns, as EXX+ and EXX-: after motion to the +
// end and to the - end. Columns come in any order; an error without a column is 0. A file may hold several
// tables, one after the other, each with its header. The last line of a file counts the rows of all its
// tables: a truncated file has no such line, or another count. A number has a decimal point in every locale.
//
// A table of A, B or C has its positions in deg, and no columns by direction. If it ends 360 deg after its
// first row, it holds for all turns, and both rows are the same.
//
// The head, before the first table, may state machine, date and temperature. Other lines that begin with #,
// and empty ones, are ignored.
//
// A file is sealed if its last line has a seal: the CRC-32 of all its other lines that are not empty, the
// head and remarks too, each with a line feed at its end. Line ends of DOS, empty lines and a byte order mark
// change no seal. A seal in that line cannot be lost by a changed byte: without the line the file is refused.
//
// Files of before may state a checksum in the head. It is the CRC-32 of the lines that do not begin with #,
// without blanks at their ends, and is no seal.
namespace error_table_file {

using csv::decimal, csv::quoted;

constexpr std::string_view linear_axes = "XYZUVW";
constexpr std::string_view axes = "XYZUVWABC";
constexpr bool is_rotary(char axis) {
    return axis <= 'C';
}

// Beyond these no machine is real, but a file in other units easily is.
constexpr double longest = 1e5;                                      // mm, a position
constexpr double nearest = 1e-3;                                     // mm, between two positions
constexpr double largest[] = {10, 10, 10, 0.1, 0.1, 0.1};            // mm, rad
constexpr double steepest[] = {1e-3, 1e-3, 1e-3, 1e-4, 1e-4, 1e-4};  // mm/mm, rad/mm
constexpr double most_half[] = {0.1, 0.1, 0.1, 1e-3, 1e-3, 1e-3};    // mm, rad; of a difference by direction
constexpr std::size_t most_rows = 4096;

// Whether an error changes too much from one row to the next, `step` mm or deg further. A screw repeats its
// error with each turn: rows within a turn may differ by as much as rows a turn apart. Where an axis takes up
// its play, one direction changes and the other one does not: the change of their difference, `played`, is no
// slope of the axis. The cubics of a table are at most three times as steep as its rows, and squareness
// follows a slope of 0.5.
inline bool too_steep(std::size_t error, double change, double step, double played) {
    constexpr double turn = 20;  // mm, of a screw
    const double most = error < 3
                            ? std::min(steepest[error] * std::max(step, turn) + std::abs(played), step / 6)
                            : steepest[error] * step;
    return !(std::abs(change) <= most);
}

inline std::vector<std::string> error_names(char axis) {
    std::vector<std::string> names;
    for (const char* error : {"EX", "EY", "EZ", "EA", "EB", "EC"})
        names.push_back(error + std::string(1, axis));
    return names;
}

inline std::string counted(std::size_t count, const std::string& what) {
    return std::to_string(count) + ' ' + what + (count == 1 ? "" : "s");
}

// For a shell.
inline std::string seal_command(const std::string& file) {
    std::string word = file;
    if (file.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/._-+@%:,=") !=
        std::string::npos) {
        word = "'";
        for (const char c : file) word += c == '\'' ? "'\\''" : std::string(1, c);
        word += '\'';
    }
    return "plumb squareness --table " + word + " --seal";
}

// The statements of a file about its tables.
struct Facts {
    std::string file;
    std::string axes;  // X, Y
    std::size_t rows = 0;
    std::string machine, date, temperature;  // as they are written, or ""
    std::string seal;                        // or ""

    std::string sentence() const {
        std::string text = file + ": error tables of " + axes + ", " + counted(rows, "row");
        const auto add = [&](const std::string& name, const std::string& value) {
            text += value.empty() ? ", no " + name : ", " + name + ' ' + value;
        };
        add("machine", machine);
        add("date", date);
        add("temperature", temperature);
        add("seal", seal);
        return text;
    }
    // For a file without a seal.
    std::string advice() const {
        return file +
               " has no seal, so a damaged digit can go unseen: check the table, then: " + seal_command(file);
    }
};

inline std::string end_line(std::size_t rows, const std::string& seal = "") {
    return "# end, " + (seal.empty() ? "" : "seal " + seal + ", ") + counted(rows, "row");
}

// Takes the tables out of one text after the other. Throws std::runtime_error; its sentence begins with the
// name and the line of the text.
class Reader {
public:
    void read(const std::string& name, std::string_view text) {
        take_lines(name, text);
        check_end();
        check_seal();
        check_sum();
        files_.push_back(facts_);
    }

    // The text with a seal for its present content, and without blanks at the ends of lines. A former seal or
    // checksum counts for nothing; all else is judged as by read().
    static std::string sealed(const std::string& name, std::string_view text) {
        Reader reader;
        reader.take_lines(name, text);
        reader.check_end();
        std::string result(text.substr(0, text.size() - csv::without_byte_order_mark(text).size())), content;
        std::string_view ending = "\n";
        std::size_t line = 0;
        for_each_line(text, [&](std::string_view raw, std::string_view its_ending) {
            ++line;
            if (!its_ending.empty()) ending = its_ending;
            raw = raw.substr(0, raw.find_last_not_of(" \t\r") + 1);
            const bool is_old = line == reader.end_.line || line == reader.stated_.line;
            if (is_old || (raw.empty() && line > reader.end_.line)) return;
            result.append(raw).append(ending);
            if (!raw.empty()) content.append(raw).append("\n");
        });
        return result.append(end_line(reader.facts_.rows, sum_of(content))).append(ending);
    }

    std::map<char, DirectedErrorTable> tables() && { return std::move(tables_); }
    const std::vector<Facts>& files() const { return files_; }

private:
    struct Column {
        std::string name;
        bool is_position;
        std::size_t error;  // in ErrorMotions
        int direction = 0;  // 1 after motion to the + end, -1 to the - end, 0 in both
    };

    void take_lines(const std::string& name, std::string_view text) {
        name_ = name;
        line_ = 0;
        axis_ = 0;
        facts_ = {};
        facts_.file = name;
        content_.clear();
        sealed_content_.clear();
        stated_ = {};
        end_ = misplaced_end_ = {};
        for_each_line(text, [this](std::string_view raw, std::string_view) {
            ++line_;
            take(csv::trimmed(raw));
            if (end_.line == line_)
                end_is_exact_ = raw == end_.text;
            else if (!raw.empty())
                sealed_content_.append(raw).append("\n");
        });
        if (axis_ == 0) throw std::runtime_error(name_ + ": there is no table in it");
        finish();
    }

    // Calls visit(line, ending) for each line; the ending of the last one may be empty.
    template <class Visit>
    static void for_each_line(std::string_view text, const Visit& visit) {
        for (text = csv::without_byte_order_mark(text); !text.empty();) {
            const std::size_t end = std::min(text.find('\n'), text.size());
            const std::size_t next = std::min(end + 1, text.size());
            const std::size_t length = end > 0 && text[end - 1] == '\r' ? end - 1 : end;
            visit(text.substr(0, length), text.substr(length, next - length));
            text.remove_prefix(next);
        }
    }

    static std::string sum_of(const std::string& content) {
        char digits[9];
        std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(crc_32(content)));
        return digits;
    }

    static bool is_axis(std::string_view field) {
        return field.size() == 1 && axes.find(field[0]) != std::string_view::npos;
    }

    [[noreturn]] void refuse(const std::string& why) const { refuse_at(line_, why); }
    [[noreturn]] void refuse_at(std::size_t line, const std::string& why) const {
        throw std::runtime_error(name_ + ": line " + std::to_string(line) + ": " + why);
    }
    [[noreturn]] void refuse(std::size_t column, const std::string& why) const {
        refuse("column " + columns_[column].name + ": " + why);
    }

    void take(std::string_view line) {
        if (line.empty()) return;
        if (line[0] == '#') return take_comment(line);
        supersede_end();
        content_.append(line).append("\n");
        const std::vector<std::string_view> fields = csv::split_at_commas(line);
        if (std::any_of(fields.begin(), fields.end(), is_axis)) {
            if (axis_ != 0) finish();
            begin(fields);
        } else if (axis_ == 0) {
            refuse(quoted(line) + " names no axis: a header comes first, such as X,EXX,EYX");
        } else {
            add(fields);
        }
    }

    // A spreadsheet appends commas, as many as the widest line has.
    void take_comment(std::string_view line) {
        line = line.substr(0, line.find_last_not_of(", \t\r") + 1);
        const std::string_view words = csv::trimmed(line.substr(1));
        const std::size_t comma = words.find(','), colon = words.find(':');
        if (comma != std::string_view::npos && csv::trimmed(words.substr(0, comma)) == "end") {
            supersede_end();
            end_ = {line_, "# " + std::string(words)};
        }
        if (colon == std::string_view::npos) return;
        std::string name;
        for (const char c : csv::trimmed(words.substr(0, colon)))
            name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        const std::string_view value = csv::trimmed(words.substr(colon + 1));
        if (name == "checksum" && axis_ != 0)
            refuse("the checksum stands in the head, before the first table");
        if (axis_ != 0) return;
        if (name == "machine") state(facts_.machine, name, value);
        if (name == "date") state(facts_.date, name, value);
        if (name == "temperature") state(facts_.temperature, name, value);
        if (name == "checksum") {
            state(stated_.text, name, value);
            stated_.line = line_;
        }
    }

    void supersede_end() {
        if (end_.line != 0 && misplaced_end_.line == 0) misplaced_end_ = end_;
        end_ = {};
    }

    void state(std::string& fact, const std::string& name, std::string_view value) const {
        if (value.empty()) refuse("there is no " + name);
        if (!fact.empty()) refuse("the " + name + " is there twice");
        for (const char c : value) fact += static_cast<unsigned char>(c) < ' ' || c == 127 ? '?' : c;
    }

    // The seal in the last line, or "".
    std::string stated_seal() const {
        constexpr std::string_view before = "# end, seal ";
        if (end_.text.substr(0, before.size()) != before) return "";
        return end_.text.substr(before.size(), end_.text.find(',', before.size()) - before.size());
    }

    void check_end() const {
        const std::string seal = stated_seal(), right = end_line(facts_.rows);
        const std::string then = seal.empty() ? "" : ", then: " + seal_command(name_);
        if (misplaced_end_.line != 0)
            refuse_at(
                misplaced_end_.line,
                "rows or another end follow the end: delete this line, and let the last line be: " + right);
        if (end_.line == 0)
            throw std::runtime_error(
                name_ + ": the end is missing, and with it perhaps a part of the table; if the " +
                counted(facts_.rows, "row") + " are all, add as the last line: " + right);
        if (end_.text != end_line(facts_.rows, seal))
            refuse_at(end_.line,
                      csv::quoted(end_.text) + " does not count the " + counted(facts_.rows, "row") +
                          " before it: a part may be missing; if they are all, write: " + right + then);
    }

    void check_seal() {
        facts_.seal = stated_seal();
        if (facts_.seal.empty()) return;
        if (!end_is_exact_)
            refuse_at(end_.line, "the last line of a sealed file has nothing but: " + end_.text);
        const std::string sum = sum_of(sealed_content_);
        if (facts_.seal != sum)
            refuse_at(end_.line, "seal " + csv::quoted(facts_.seal) +
                                     " is not that of the file, which gives " + sum +
                                     ": it was changed after it was sealed, or is damaged; check it, then: " +
                                     seal_command(name_));
    }

    void check_sum() const {
        std::string stated;
        for (const char c : stated_.text)
            stated += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (stated_.line != 0 && stated != sum_of(content_))
            refuse_at(stated_.line, "checksum " + csv::quoted(stated_.text) +
                                        " is not that of the rows, which were changed or are damaged; check "
                                        "them, then: " +
                                        seal_command(name_));
    }

    void begin(const std::vector<std::string_view>& fields) {
        header_line_ = line_;
        axis_ = (*std::find_if(fields.begin(), fields.end(), is_axis))[0];
        columns_.clear();
        rows_.clear();
        const std::vector<std::string> names = error_names(axis_);
        for (const std::string_view field : fields) {
            const bool position = field == std::string_view(&axis_, 1);
            const char last = field.empty() || position ? ' ' : field.back();
            const int direction = last == '+' ? 1 : last == '-' ? -1 : 0;
            const auto name =
                std::find(names.begin(), names.end(), field.substr(0, field.size() - (direction != 0)));
            if (field.empty()) refuse("column " + std::to_string(columns_.size() + 1) + " has no name");
            if (!position && name == names.end()) refuse_name(field, names);
            if (std::any_of(columns_.begin(), columns_.end(),
                            [&](const Column& c) { return c.name == field; }))
                refuse(quoted(field) + " is there twice");
            columns_.push_back(
                {std::string(field), position, static_cast<std::size_t>(name - names.begin()), direction});
        }
        for (const Column& column : columns_) check_direction(column);
        if (columns_.size() == 1) refuse("there is no error beside " + std::string(1, axis_));
        const auto there = places_.find(axis_);
        if (there != places_.end())
            refuse(std::string(1, axis_) + " has a table already, in " + there->second);
        places_[axis_] = name_ + ", line " + std::to_string(line_);
    }

    // An error has one column, or one for each direction.
    void check_direction(const Column& column) const {
        if (column.direction == 0) return;
        if (is_rotary(axis_))
            refuse(csv::quoted(column.name) + " has a direction, which is not possible for a rotary axis");
        bool paired = false;
        for (const Column& other : columns_) {
            if (other.is_position || other.error != column.error) continue;
            if (other.direction == 0)
                refuse(csv::quoted(column.name) + " stands beside " + csv::quoted(other.name));
            paired |= other.direction == -column.direction;
        }
        if (!paired)
            refuse(csv::quoted(column.name) + " stands without " +
                   csv::quoted(column.name.substr(0, 3) + (column.direction > 0 ? '-' : '+')));
    }

    [[noreturn]] void refuse_name(std::string_view field, const std::vector<std::string>& names) const {
        std::string known;
        for (const std::string& name : names) known += ' ' + name;
        refuse(quoted(field) + " is no error of " + std::string(1, axis_) + ", which are" + known);
    }

    void add(const std::vector<std::string_view>& fields) {
        if (fields.size() != columns_.size())
            refuse(counted(fields.size(), "value") + ", but the header has " +
                   std::to_string(columns_.size()));
        if (rows_.size() == most_rows) refuse("more than " + counted(most_rows, "row"));
        std::vector<double> row;
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const Column& column = columns_[i];
            const double value = number(i, fields[i]);
            row.push_back(value);
            const double limit = column.is_position ? longest : largest[column.error];
            if (!(std::abs(value) <= limit))
                refuse(i, quoted(fields[i]) + " is beyond " + decimal(limit) + unit(column) + "; is it in" +
                              unit(column) + '?');
        }
        if (!rows_.empty()) check_step(rows_.back(), row);
        check_halves(row);
        rows_.push_back(row);
    }

    void check_halves(const std::vector<double>& row) const {
        for (std::size_t up = 0; up < columns_.size(); ++up)
            for (std::size_t down = 0; down < columns_.size() && columns_[up].direction > 0; ++down)
                if (columns_[down].direction < 0 && columns_[down].error == columns_[up].error &&
                    !(std::abs(row[up] - row[down]) <= 2 * most_half[columns_[up].error]))
                    refuse(up, decimal(row[up]) + " and " + decimal(row[down]) + " in " +
                                   columns_[down].name + " differ by more than " +
                                   decimal(2 * most_half[columns_[up].error]) + unit(columns_[up]));
    }

    void check_step(const std::vector<double>& before, const std::vector<double>& row) const {
        double step = 0;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            if (!columns_[i].is_position) continue;
            step = row[i] - before[i];
            if (!(step >= nearest))
                refuse(i, decimal(row[i]) + " is not beyond " + decimal(before[i]) + " by at least " +
                              decimal(nearest) + unit(columns_[i]));
        }
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            if (columns_[i].is_position) continue;
            const double from = before[i], to = row[i];
            if (too_steep(columns_[i].error, to - from, step, difference(row, i) - difference(before, i)))
                refuse(i, "from " + decimal(from) + " to " + decimal(to) + " within " + decimal(step) +
                              (is_rotary(axis_) ? " deg" : " mm") + " is too steep; is it in" +
                              unit(columns_[i]) + '?');
        }
    }

    // Of both directions of this column's error in a row; 0 if it has one column.
    double difference(const std::vector<double>& row, std::size_t column) const {
        double result = 0;
        for (std::size_t i = 0; i < columns_.size(); ++i)
            if (!columns_[i].is_position && columns_[i].error == columns_[column].error)
                result += columns_[i].direction * row[i];
        return result;
    }

    double number(std::size_t column, std::string_view field) const {
        if (field.empty()) refuse(column, "there is no value");
        const std::optional<double> value = csv::number(field);
        if (!value) refuse(column, quoted(field) + " is no number");
        return *value;
    }

    void finish() {
        if (rows_.size() < 2)
            refuse_at(header_line_,
                      std::string(1, axis_) + " has " + counted(rows_.size(), "row") + ", and needs 2");
        std::vector<ErrorTable::Row> mean(rows_.size()), half(rows_.size());
        bool directed = false, scale = false, scale_directed = false;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const Column& column = columns_[i];
            directed |= column.direction != 0;
            const bool of_scale =
                !column.is_position && column.error == axes.find(axis_) % 3 + (is_rotary(axis_) ? 3 : 0);
            scale |= of_scale;
            scale_directed |= of_scale && column.direction != 0;
            for (std::size_t k = 0; k < rows_.size(); ++k) {
                const double value = rows_[k][i];
                if (column.is_position) {
                    mean[k].position = half[k].position = value;
                } else {
                    mean[k].errors[column.error] += column.direction == 0 ? value : value / 2;
                    half[k].errors[column.error] += column.direction * value / 2;
                }
            }
        }
        const std::optional<double> turn_from = is_rotary(axis_) ? round(mean) : std::nullopt;
        tables_.emplace(axis_, DirectedErrorTable(ErrorTable(mean),
                                                  directed ? std::optional(ErrorTable(half)) : std::nullopt,
                                                  scale, scale_directed, turn_from));
        facts_.rows += rows_.size();
        facts_.axes += (facts_.axes.empty() ? "" : ", ") + std::string(1, axis_);
    }

    // Where the turn of a table that reaches round begins. A row beyond either end gives the slope there.
    std::optional<double> round(std::vector<ErrorTable::Row>& rows) const {
        constexpr double turn = DirectedErrorTable::turn;
        const double length = rows.back().position - rows.front().position;
        if (length > turn + 1e-9)
            refuse_at(header_line_,
                      std::string(1, axis_) + " has rows over " + decimal(length) + " deg, more than a turn");
        if (length < turn - 1e-9) return {};
        if (rows.back().errors != rows.front().errors)
            refuse_at(header_line_, std::string(1, axis_) + ": the first and the last row are one place, " +
                                        decimal(turn) + " deg apart, and differ");
        const double from = rows.front().position;
        ErrorTable::Row before = rows[rows.size() - 2], behind = rows[1];
        before.position -= turn;
        behind.position += turn;
        rows.insert(rows.begin(), before);
        rows.push_back(behind);
        return from;
    }

    std::string unit(const Column& column) const {
        if (column.is_position && is_rotary(axis_)) return " deg";
        return column.is_position || column.error < 3 ? " mm" : " rad";
    }

    std::string name_;
    std::size_t line_ = 0, header_line_ = 0;
    char axis_ = 0;  // of the table that is being read
    std::vector<Column> columns_;
    std::vector<std::vector<double>> rows_;  // by column
    std::map<char, std::string> places_;
    std::map<char, DirectedErrorTable> tables_;

    struct Line {
        std::size_t line = 0;  // 0: none
        std::string text;
    };
    Facts facts_;                 // of the file that is being read
    std::string content_;         // of the file that is being read: the lines that a checksum covers
    std::string sealed_content_;  // those that its seal covers
    Line end_, misplaced_end_, stated_;
    bool end_is_exact_ = false;
    std::vector<Facts> files_;
};

}  // namespace error_table_file

struct ErrorTableFiles {
    std::map<char, DirectedErrorTable> tables;  // by axis
    std::vector<error_table_file::Facts> files;
};

// If one of the files is wrong, takes no table and throws std::runtime_error with file, line, value and
// reason.
inline ErrorTableFiles read_error_tables(const std::vector<std::filesystem::path>& files) {
    error_table_file::Reader reader;
    for (const std::filesystem::path& file : files) reader.read(file.string(), csv::text_of(file));
    const std::vector<error_table_file::Facts> facts = reader.files();
    return {std::move(reader).tables(), facts};
}

}  // namespace plumb
