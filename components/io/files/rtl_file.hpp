// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/direction_rows.hpp"
#include "components/math/geometry/lost_motion.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// Renishaw's .rtl of a linear measurement: targets in mm, five a line, and a line "run target value" for each
// reading, in um, measured minus target. Targets rise or fall. A run goes along the targets or comes back; by
// that it shows one direction of motion or the other. The second number of Flags is 1 if all runs go the same
// way: a run of zeros between two of them is a mere return. Readings of another kind have other units: the
// reader refuses them, unless the user gives that unit.
namespace rtl_file {

// In mm; with the `size` of a told unit, in mm or rad.
inline std::vector<BothWays> read(const std::string& name, std::string_view text,
                                  std::optional<double> size = {}) {
    const direction_rows::Lines lines(name, text);
    const auto find = [&](std::string_view what, std::size_t from) {
        for (std::size_t i = from; i < lines.size(); ++i)
            if (lines[i].substr(0, what.size()) == what) return i;
        lines.refuse("there is no line " + csv::quoted(what) +
                     (from > 0 ? " behind line " + std::to_string(from) : ""));
    };
    const auto count = [&](std::string_view what, std::size_t from, std::size_t most) {
        const std::size_t at = find(what, from);
        const auto value = csv::number(csv::trimmed(lines[at].substr(what.size())));
        if (!value || *value != std::floor(*value) || *value < 1 || *value > static_cast<double>(most))
            lines.refuse(at, csv::quoted(lines[at]) + " states no number from 1 to " + std::to_string(most));
        return static_cast<std::size_t>(*value);
    };
    const auto lower = [](std::string_view line) {
        std::string result;
        for (const char c : line) result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        return result;
    };
    const std::size_t header = find("HEADER::", 0), data = find("TARGET DATA::", header);
    for (std::size_t i = header; i < data && !size; ++i)
        for (const char* other : {"angular", "straightness", "flatness", "squareness", "rotary"})
            if (lower(lines[i]).find(other) != std::string::npos)
                lines.refuse(i, csv::quoted(lines[i]) +
                                    " is no linear measurement: its unit is not um. Give --error and --unit");
    const std::size_t targets = count("Target-count:", data, 4096), list = find("Targets", data);
    std::vector<BothWays> places;
    std::size_t at = list + 1;
    for (; places.size() < targets; ++at) {
        if (at == lines.size()) lines.refuse("the file ends before its targets do");
        for (const double position : lines.numbers(at)) {
            places.push_back({position, {}, {}});
            if (places.size() > targets)
                lines.refuse(at, "more targets than the " + std::to_string(targets) + " of Target-count");
            if (places.size() < 2) continue;
            const double step = position - places[places.size() - 2].position,
                         first = places[1].position - places[0].position;
            if (!(step * first > 0))
                lines.refuse(at, csv::decimal(position) + " is not beyond " +
                                     csv::decimal(places[places.size() - 2].position) +
                                     ": targets rise or fall");
        }
    }
    bool same_way = false;
    for (std::size_t i = list; i < lines.size() && lines[i].find("::") == std::string_view::npos; ++i) {
        if (lines[i].substr(0, 6) != "Flags:") continue;
        const std::string_view second = csv::trimmed(lines[i].substr(6));
        same_way = second.size() > 2 && second[second.find_first_of(" \t") + 1] == '1';
    }
    const bool falling = targets > 1 && places[1].position < places[0].position;
    const std::size_t runs = count("Run-count:", find("RUNS::", at), 1000);
    const std::size_t table = find("Run Target Data:", find("DEVIATIONS::", at));
    std::size_t read = 0;
    double largest = 0;
    bool back = false, zeros = true;  // of the present run
    for (at = table + 1; at < lines.size() && lines[at].find("::") == std::string_view::npos; ++at) {
        if (lines[at].empty()) continue;
        const std::vector<double> row = lines.numbers(at);
        if (row.size() != 3)
            lines.refuse(at, error_table_file::counted(row.size(), "value") + ", not run, target and value");
        const std::size_t run = read / targets + 1, nth = read % targets;
        if (nth == 0) back = targets > 1 && row[1] == static_cast<double>(targets), zeros = true;
        const std::size_t target = back ? targets - nth : nth + 1;
        if (row[0] != static_cast<double>(run) || row[1] != static_cast<double>(target))
            lines.refuse(at, "run " + csv::decimal(row[0]) + ", target " + csv::decimal(row[1]) +
                                 ", where run " + std::to_string(run) + ", target " + std::to_string(target) +
                                 " comes next");
        if (!(std::abs(row[2]) <= 10'000))
            lines.refuse(at, csv::decimal(row[2]) + (size ? " is beyond 10,000; is it in its unit?"
                                                          : " um is beyond 10 mm; is it in um?"));
        BothWays& place = places[target - 1];
        std::vector<double>& readings = back != falling ? place.down : place.up;
        readings.push_back(size ? row[2] * *size : row[2] / 1000);
        zeros &= row[2] == 0;
        if (same_way && back && nth + 1 == targets) {  // the last one of a return
            if (!zeros)
                lines.refuse(at, "Flags state that all runs go the same way, but run " + std::to_string(run) +
                                     " comes back with readings");
            for (BothWays& its : places) (falling ? its.up : its.down).clear();
        }
        largest = std::max(largest, std::abs(row[2]));
        ++read;
    }
    if (read != runs * targets)
        lines.refuse(error_table_file::counted(read, "reading") + ", but " + std::to_string(runs) +
                     " runs of " + std::to_string(targets) + " targets are announced");
    find("EOF::", at);
    if (!size && largest > 0 && largest < 0.1)
        lines.refuse("the largest reading is " + csv::decimal(largest) +
                     " um; are the readings in um, not mm?");
    return places;
}

// One run up, and one down if the rows differ by direction.
inline std::string text(const DirectionRows& rows) {
    bool directed = false;
    for (const DirectionRow& row : rows) directed |= row.up != row.down;
    std::string result =
        "HEADER::\nTARGET DATA::\nTarget-count: " + std::to_string(rows.size()) + "\nTargets :\n";
    const auto add = [&](const char* format, auto... values) {
        char line[80];
        std::snprintf(line, sizeof line, format, values...);
        result += line;
    };
    for (std::size_t i = 0; i < rows.size(); ++i)
        add("%.6f%s", rows[i].position, i % 5 == 4 || i + 1 == rows.size() ? "\n" : " ");
    result += "Flags: 0 0 0 0\nUSER-TEXT::\nRUNS::\nRun-count: " + std::string(directed ? "2" : "1") +
              "\nDEVIATIONS::\nRun Target Data:\n";
    for (std::size_t i = 0; i < rows.size(); ++i) add("1 %zu %.4f\n", i + 1, rows[i].up * 1000);
    for (std::size_t i = rows.size(); directed && i > 0; --i) add("2 %zu %.4f\n", i, rows[i - 1].down * 1000);
    return result + "ENVIRONMENT::\nEOF::\n";
}

}  // namespace rtl_file
}  // namespace plumb
