// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/direction_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// Tables of one axis as controls keep them. `error` is one as EXX or EYX; its last letter is the axis.
// Lengths are in mm, angles in rad. Each reader refuses a file with line, value and reason.
namespace plumb {

namespace control_files {

inline std::vector<std::string> words(std::string_view line) {
    std::vector<std::string> result;
    while (!(line = csv::trimmed(line)).empty()) {
        const std::size_t end = line.find_first_of(" \t");
        result.emplace_back(line.substr(0, end));
        line = end == std::string_view::npos ? "" : line.substr(end);
    }
    return result;
}

inline double number(const direction_rows::Lines& lines, std::size_t i, const std::string& word) {
    const auto value = csv::number(word);
    if (!value)
        lines.refuse(i, csv::quoted(word) + " is no number" +
                            (word.find(',') == std::string::npos ? "" : "; the decimal mark is a point"));
    return *value;
}

inline void add(DirectionRows& rows, const direction_rows::Lines& lines, std::size_t i,
                const DirectionRow& row) {
    if (!rows.empty() && !(row.position > rows.back().position))
        lines.refuse(i, csv::decimal(row.position) + " is not beyond " + csv::decimal(rows.back().position));
    rows.push_back(row);
}

inline std::string line(const char* format, double a, double b, double c = 0) {
    char text[120];
    std::snprintf(text, sizeof text, format, a, b, c);
    return text;
}

}  // namespace control_files

// The CSV of ISG and Beckhoff: a line of names, as "X EXX EYX", then lines of numbers, between blanks. //
// begins a remark, and # a new part with names of its own. One direction only; linear between the lines.
namespace isg_file {

inline DirectionRows read(const std::string& name, std::string_view text, const std::string& error) {
    const direction_rows::Lines lines(name, text);
    const std::string axis = error.substr(2);
    std::vector<std::string> names;
    DirectionRows rows;
    bool found = false;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const std::string_view content = lines[i].substr(0, lines[i].find("//"));
        const std::vector<std::string> words = control_files::words(content);
        if (words.empty()) continue;
        if (words[0][0] == '#') {
            names.clear();
            continue;
        }
        if (names.empty()) {
            if (csv::number(words[0])) lines.refuse(i, "numbers without a line of names before them");
            names = words;
            const auto is = [&](const std::string& its) {
                return std::count(names.begin(), names.end(), its) > 0;
            };
            if (!is(error)) continue;
            if (found) lines.refuse(i, error + " is there a second time");
            found = true;
            for (const std::string& its : names)
                if (its.size() == 1 && its != axis)
                    lines.refuse(
                        i, error + " depends on " + its + ", too: plumb volume takes tables of one axis");
            if (!is(axis)) lines.refuse(i, "there is no column " + axis + " beside " + error);
            continue;
        }
        if (words.size() != names.size())
            lines.refuse(i, error_table_file::counted(words.size(), "value") + ", but " +
                                error_table_file::counted(names.size(), "name") + " stand above");
        DirectionRow row;
        bool its = false;
        for (std::size_t k = 0; k < names.size(); ++k) {
            const double value = control_files::number(lines, i, words[k]);
            if (names[k] == axis) row.position = value;
            if (names[k] == error) row.up = row.down = value, its = true;
        }
        if (its) control_files::add(rows, lines, i, row);
    }
    if (!found) lines.refuse("there is no column " + error);
    if (rows.size() < 2) lines.refuse("there are fewer than 2 lines of " + error);
    return rows;
}

inline std::string text(const DirectionRows& rows, const std::string& error) {
    std::string result = "// " + error + ": actual less nominal, mean of both directions, mm and rad\n" +
                         error.substr(2) + ' ' + error + '\n';
    for (const DirectionRow& row : rows)
        result += control_files::line("%.6f %.9f\n", row.position, (row.up + row.down) / 2);
    return result;
}

}  // namespace isg_file

// The table .COM of a TNC: AXISPOS, and a column of the error for each axis. BACKLASH has the errors after
// motion to the - end; without it both directions are alike. The lines BEGIN and [END] may be missing.
namespace heidenhain_file {

inline DirectionRows read(const std::string& name, std::string_view text, const std::string& error) {
    const direction_rows::Lines lines(name, text);
    const std::string column = error.substr(1, 1);
    std::vector<std::string> names;
    DirectionRows rows;
    bool ended = false;
    const auto place = [&](const std::string& its) {
        const auto at = std::find(names.begin(), names.end(), its);
        return at == names.end() ? std::optional<std::size_t>()
                                 : std::optional<std::size_t>(at - names.begin());
    };
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const std::vector<std::string> words = control_files::words(lines[i]);
        if (words.empty()) continue;
        if (words[0] == "[END]") {
            ended = true;
            continue;
        }
        if (ended) lines.refuse(i, "a line behind [END]");
        if (words[0] == "BEGIN") {
            if (words.back() != "MM") lines.refuse(i, csv::quoted(lines[i]) + " is not in MM");
            continue;
        }
        if (names.empty()) {
            names = words;
            if (!place("AXISPOS")) lines.refuse(i, "there is no column AXISPOS");
            if (!place(column)) lines.refuse(i, "there is no column " + column + ", which has " + error);
            continue;
        }
        if (words.size() != names.size())
            lines.refuse(i, error_table_file::counted(words.size(), "value") + ", but the table has " +
                                error_table_file::counted(names.size(), "column"));
        const auto value = [&](const std::string& its) {
            return control_files::number(lines, i, words[*place(its)]);
        };
        DirectionRow row{value("AXISPOS"), value(column), 0};
        row.down = place("BACKLASH") ? value("BACKLASH") : row.up;
        control_files::add(rows, lines, i, row);
    }
    if (rows.size() < 2) lines.refuse("there are fewer than 2 lines in it");
    return rows;
}

inline std::string text(const DirectionRows& rows, const std::string& error) {
    std::string result =
        "BEGIN " + error.substr(2) + ".COM MM\nNR AXISPOS BACKLASH " + error.substr(1, 1) + '\n';
    std::size_t n = 0;
    for (const DirectionRow& row : rows)
        result +=
            std::to_string(n++) + control_files::line(" %.6f %.6f %.6f\n", row.position, row.down, row.up);
    return result + "[END]\n";
}

}  // namespace heidenhain_file

// Cross error compensation of a SINUMERIK: $AN_CEC[table,N]=value at MIN + N STEP, for one direction of
// motion or for both. The input axis is the axis of the table; the output axis is the axis whose error this
// is.
namespace cec_file {

constexpr std::size_t most_rows = 2000;

inline DirectionRows read(const std::string& name, std::string_view text, const std::string& error) {
    const direction_rows::Lines lines(name, text);
    struct Table {
        std::map<std::string, std::pair<std::string, std::size_t>> settings;  // by name: value, line
        std::map<std::size_t, std::pair<double, std::size_t>> values;         // by N
    };
    std::map<std::size_t, Table> tables;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const std::string_view its = csv::trimmed(lines[i].substr(0, lines[i].find(';')));
        if (its.substr(0, 7) != "$AN_CEC") continue;
        const std::size_t open = its.find('['), close = its.find(']'), equals = its.find('=');
        if (open == its.npos || close == its.npos || equals == its.npos || !(open < close && close < equals))
            lines.refuse(i, csv::quoted(its) + " has no form as $AN_CEC[0,1]=0.01");
        const std::string key(its.substr(1, open - 1)), value(csv::trimmed(its.substr(equals + 1)));
        const std::vector<std::string_view> at = csv::split_at_commas(its.substr(open + 1, close - open - 1));
        std::vector<std::size_t> index;
        for (const std::string_view word : at) {
            const auto n = csv::number(csv::trimmed(word));
            if (!n || *n < 0 || *n != std::floor(*n) || *n > 1e4)
                lines.refuse(i, csv::quoted(word) + " is no index");
            index.push_back(static_cast<std::size_t>(*n));
        }
        Table& table = tables[index[0]];
        if (key == "AN_CEC" && index.size() == 2) {
            if (!table.values.emplace(index[1], std::pair(control_files::number(lines, i, value), i)).second)
                lines.refuse(i, csv::quoted(its.substr(0, equals)) + " is there twice");
        } else if (index.size() == 1) {
            table.settings[key] = {value, i};
        } else {
            lines.refuse(i, csv::quoted(its) + " has no form as $AN_CEC[0,1]=0.01");
        }
    }
    DirectionRows up, down;
    for (auto& [t, table] : tables) {
        const std::string of = "[" + std::to_string(t) + "]";
        const auto text_of = [&](const std::string& key) {
            const auto at = table.settings.find("AN_CEC_" + key);
            if (at == table.settings.end()) lines.refuse("there is no $AN_CEC_" + key + of);
            return at->second;
        };
        const auto axis = [&](const std::string& key) {
            std::string word = text_of(key).first;
            if (word.size() > 2 && word.front() == '(' && word.back() == ')')
                word = word.substr(1, word.size() - 2);
            return word;
        };
        const auto number = [&](const std::string& key) {
            const auto [word, at] = text_of(key);
            return control_files::number(lines, at, word);
        };
        // AX1, X1 or X: the letter of the axis stands in it, or its number in the order X Y Z.
        const auto is = [&](const std::string& word, char letter) {
            if (word.substr(0, 2) == "AX" && word.size() == 3)
                return std::string("123").find(word[2]) == std::string("XYZ").find(letter);
            return !word.empty() && word[0] == letter;
        };
        if (!is(axis("INPUT_AXIS"), error[2]) || !is(axis("OUTPUT_AXIS"), error[1])) continue;
        for (const char* const key : {"IS_MODULO", "MULT_BY_TABLE"}) {
            const auto other = table.settings.find(std::string("AN_CEC_") + key);
            if (other != table.settings.end() && other->second.first != "0")
                lines.refuse(other->second.second, csv::quoted(lines[other->second.second]) +
                                                       ": only tables of a travel, by 0, are taken");
        }
        const double step = number("STEP"), low = number("MIN"), high = number("MAX"),
                     way = number("DIRECTION");
        if (!(step > 0))
            lines.refuse(text_of("STEP").second, "a step of " + csv::decimal(step) + " mm is not above 0");
        if (way != 0 && way != 1 && way != -1)
            lines.refuse(text_of("DIRECTION").second,
                         "a direction of " + csv::decimal(way) + " is none of 0, 1 and -1");
        const double last = (high - low) / step;
        if (!(last >= 1 && last < most_rows) || std::abs(last - std::round(last)) > 1e-6)
            lines.refuse(text_of("MAX").second, "from " + csv::decimal(low) + " to " + csv::decimal(high) +
                                                    " mm there are no whole steps of " + csv::decimal(step) +
                                                    " mm");
        const auto count = static_cast<std::size_t>(std::llround(last)) + 1;
        for (const auto& [n, value] : table.values)
            if (n >= count)
                lines.refuse(value.second, "N " + std::to_string(n) + " is beyond the last step, " +
                                               std::to_string(count - 1));
        for (const bool rising : {true, false}) {
            if (way == (rising ? -1 : 1)) continue;
            DirectionRows& rows = rising ? up : down;
            if (!rows.empty())
                lines.refuse(text_of("DIRECTION").second,
                             "table " + std::to_string(t) + " is a second one for this direction");
            for (std::size_t n = 0; n < count; ++n) {
                const auto value = table.values.find(n);
                if (value == table.values.end())
                    lines.refuse("there is no $AN_CEC[" + std::to_string(t) + ',' + std::to_string(n) + ']');
                rows.push_back(
                    {low + static_cast<double>(n) * step, value->second.first, value->second.first});
            }
        }
    }
    if (up.empty() && down.empty())
        lines.refuse("there is no table from " + error.substr(2) + " to " + error.substr(1, 1) +
                     ", which has " + error);
    if (up.empty() || down.empty()) return up.empty() ? down : up;
    if (up.size() != down.size() || std::abs(up[0].position - down[0].position) > 1e-6 ||
        std::abs(up.back().position - down.back().position) > 1e-6)
        lines.refuse("the tables of both directions have other places");
    for (std::size_t i = 0; i < up.size(); ++i) up[i].down = down[i].down;
    return up;
}

// At even steps, linear between the rows.
inline DirectionRows even(const DirectionRows& rows) {
    double step = rows[1].position - rows[0].position;
    bool is_even = true;
    for (std::size_t i = 2; i < rows.size(); ++i) {
        is_even &= std::abs(rows[i].position - rows[i - 1].position - step) < 1e-6;
        step = std::min(step, rows[i].position - rows[i - 1].position);
    }
    if (is_even) return rows;
    const double length = rows.back().position - rows.front().position;
    const auto count = static_cast<std::size_t>(std::min(std::ceil(4 * length / step), most_rows - 2.0));
    DirectionRows result;
    std::size_t k = 1;
    for (std::size_t n = 0; n <= count; ++n) {
        const double at =
            rows.front().position + length * static_cast<double>(n) / static_cast<double>(count);
        while (k + 1 < rows.size() && rows[k].position < at) ++k;
        const DirectionRow &a = rows[k - 1], &b = rows[k];
        const double part = (at - a.position) / (b.position - a.position);
        result.push_back({at, a.up + part * (b.up - a.up), a.down + part * (b.down - a.down)});
    }
    return result;
}

inline std::string text(const DirectionRows& rows, const std::string& error) {
    bool directed = false;
    for (const DirectionRow& row : rows) directed |= row.up != row.down;
    std::string result;
    const double step = (rows.back().position - rows.front().position) / static_cast<double>(rows.size() - 1);
    for (int t = 0; t < (directed ? 2 : 1); ++t) {
        const std::string of = '[' + std::to_string(t) + "]=";
        const auto setting = [&](const std::string& key, const std::string& value) {
            result += "$AN_CEC_" + key + of + value + '\n';
        };
        setting("INPUT_AXIS", '(' + error.substr(2) + ')');
        setting("OUTPUT_AXIS", '(' + error.substr(1, 1) + ')');
        setting("STEP", csv::decimal(step));
        setting("MIN", csv::decimal(rows.front().position));
        setting("MAX", csv::decimal(rows.front().position + step * static_cast<double>(rows.size() - 1)));
        setting("DIRECTION", !directed ? "0" : t == 0 ? "1" : "-1");
        setting("IS_MODULO", "0");
        for (std::size_t n = 0; n < rows.size(); ++n)
            result += "$AN_CEC[" + std::to_string(t) + ',' + std::to_string(n) +
                      control_files::line("]=%.6f\n", t == 0 ? rows[n].up : rows[n].down, 0);
    }
    return result + "M17\n";
}

}  // namespace cec_file
}  // namespace plumb
