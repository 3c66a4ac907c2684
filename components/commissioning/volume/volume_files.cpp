// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/volume/volume_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "components/io/files/csv.hpp"
#include "components/io/files/direction_rows.hpp"
#include "components/io/files/error_table_file.hpp"
#include "components/io/files/table_file.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/geometry/error_table.hpp"

namespace plumb::commissioning {
namespace {

constexpr double farthest = 1e5;  // mm

// A table in mm and deg. States on standard error how it was read, if it is no plain CSV.
struct Columns : TableFile {
    // `wanted`: the columns that are read; all if there are none.
    explicit Columns(const std::string& file, const std::vector<std::string>& wanted = {}) : TableFile(file) {
        std::string said = form(), unread;
        for (std::size_t k = 0; k < columns().size(); ++k) {
            const Column& its = columns()[k];
            if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), its.name) == wanted.end()) {
                unread += (unread.empty() ? "" : ", ") + csv::quoted(its.head);
                continue;
            }
            if (!its.unit.empty() && its.known.quantity != length && its.known.quantity != angle)
                refuse(head_line(), "column " + csv::quoted(its.head) + " is neither a length nor an angle");
            if (!its.unit.empty()) said += (said.empty() ? "" : ", ") + its.name + " in " + its.unit;
            for (std::size_t i = 0; i < rows(); ++i)
                if (!(std::abs(number(i, k).value_or(0)) <= farthest))
                    refuse_value(i, k, "is beyond 1e5; is it in mm?");
        }
        if (!said.empty()) std::cerr << file << ": taken as: " << said << ".\n";
        if (!unread.empty()) std::cerr << file << ": not read: " << unread << ".\n";
    }

    double stated_number(const std::string& name) const {
        const auto value = csv::number(stated(name));
        if (!value) refuse(stated_line(name), name + ": " + csv::quoted(stated(name)) + " is no number");
        return *value;
    }
};

}  // namespace

std::vector<BothWays> read_readings(const std::string& file) {
    const Columns columns(file);
    const std::size_t position = columns.column("position");
    std::vector<BothWays> places;
    for (std::size_t i = 0; i < columns.rows(); ++i) {
        BothWays place;
        place.position = columns.value(i, position);
        for (std::size_t k = 0; k < columns.columns().size(); ++k) {
            if (k == position) continue;
            const std::string& name = columns.columns()[k].name;
            const bool up = name.rfind("up", 0) == 0;
            if (!up && name.rfind("down", 0) != 0)
                columns.refuse(
                    columns.head_line(),
                    "column " + csv::quoted(name) + " is none of position, up1, up2, ..., down1, down2, ...");
            const auto value = columns.number(i, k);
            if (!value) continue;
            if (std::abs(place.position) >= 5 && std::abs(*value - place.position) < 2)
                columns.refuse_value(
                    i, k,
                    "is the place that the axis reached; a reading is the place less the position, here " +
                        csv::decimal(*value - place.position));
            if (!(std::abs(*value) <= 10)) columns.refuse_value(i, k, "is beyond 10 mm; is it in mm?");
            (up ? place.up : place.down).push_back(*value);
        }
        places.push_back(place);
    }
    return places;
}

std::vector<BothWays> read_recording(const std::string& file, int places, double distance) {
    const Columns columns(file, {"motor", "load"});
    const std::size_t motor = columns.column("motor"), load = columns.column("load");
    double low = farthest, high = -farthest;
    for (std::size_t i = 0; i < columns.rows(); ++i) {
        low = std::min(low, columns.value(i, motor));
        high = std::max(high, columns.value(i, motor));
    }
    if (!(high - low > 100 * distance))
        throw std::runtime_error(file + ": the axis moves by " + csv::decimal(high - low) + " mm only");
    std::vector<BothWays> result(static_cast<std::size_t>(places));
    const double part = (high - low) / places;
    for (int i = 0; i < places; ++i) result[static_cast<std::size_t>(i)].position = low + (i + 0.5) * part;
    // A passage of a part gives one reading: its samples are not independent.
    DirectionOfMotion watch;
    double turned_at = 0, sum = 0;
    int direction = 0, count = 0;
    std::size_t here = result.size();
    const auto close = [&] {
        if (count > 0 && here < result.size())
            (direction > 0 ? result[here].up : result[here].down).push_back(sum / count);
        sum = 0, count = 0;
    };
    for (std::size_t i = 0; i < columns.rows(); ++i) {
        const double at = columns.value(i, motor);
        watch.step(at, distance);
        if (watch.direction() != direction) {
            close();
            turned_at = at;
            direction = watch.direction();
        }
        const auto now = std::min(static_cast<std::size_t>((at - low) / part), result.size() - 1);
        if (now != here) close();
        here = now;
        if (direction == 0 || std::abs(at - turned_at) < 10 * distance) continue;  // the play is taken up
        sum += columns.value(i, load) - at;
        ++count;
    }
    close();
    result.erase(std::remove_if(result.begin(), result.end(),
                                [](const BothWays& its) { return its.up.empty() || its.down.empty(); }),
                 result.end());
    if (result.empty())
        throw std::runtime_error(file + ": no part of the travel is passed in both directions");
    return result;
}

BallbarFile read_ballbar(const std::string& file) {
    const Columns columns(file, {"angle", "radius"});
    BallbarFile result;
    result.plane = columns.stated("plane");
    if (result.plane.size() != 2 || std::string("XYZUVW").find(result.plane[0]) == std::string::npos ||
        std::string("XYZUVW").find(result.plane[1]) == std::string::npos ||
        result.plane[0] == result.plane[1])
        columns.refuse(columns.stated_line("plane"),
                       "plane: " + csv::quoted(result.plane) + " is none as XY, ZX or YZ");
    result.radius = columns.stated_number("radius");
    result.feed = columns.stated_number("feed");
    if (!(result.radius > 1 && result.radius <= 1e4))
        columns.refuse(columns.stated_line("radius"),
                       "radius: " + csv::decimal(result.radius) + " is not from 1 to 1e4 mm");
    if (!(result.feed > 0 && result.feed <= 6e5))
        columns.refuse(columns.stated_line("feed"),
                       "feed: " + csv::decimal(result.feed) + " is not above 0 and up to 6e5 mm/min");
    const std::string direction = columns.stated("direction"), object = columns.stated("object");
    if (direction != "CW" && direction != "CCW")
        columns.refuse(columns.stated_line("direction"),
                       "direction: " + csv::quoted(direction) + " is not CW or CCW");
    if (object != "part")
        columns.refuse(
            columns.stated_line("object"),
            "object: " + csv::quoted(object) +
                " is not part; for a ring or ball that a probe measured: plumb squareness --points");
    result.path.clockwise = direction == "CW";
    const std::size_t angle = columns.column("angle"), radius = columns.column("radius");
    for (std::size_t i = 0; i < columns.rows(); ++i) {
        result.path.angles.push_back(columns.value(i, angle) * pi / 180);
        result.path.radii.push_back(columns.value(i, radius));
    }
    const auto [first, last] = std::minmax_element(result.path.angles.begin(), result.path.angles.end());
    if (columns.rows() > 10 && *last - *first < 7 * pi / 180)
        columns.refuse(columns.head_line(), "the angles go from " + csv::decimal(*first * 180 / pi) + " to " +
                                                csv::decimal(*last * 180 / pi) + " only; are they in deg?");
    return result;
}

std::vector<StraightedgeRow> read_straightedge(const std::string& file) {
    const Columns columns(file, {"position", "before", "turned"});
    const std::size_t position = columns.column("position"), before = columns.column("before"),
                      turned = columns.column("turned");
    std::vector<StraightedgeRow> rows;
    for (std::size_t i = 0; i < columns.rows(); ++i) {
        rows.push_back({columns.value(i, position), columns.value(i, before), columns.value(i, turned)});
        if (i > 0 && !(rows[i].position > rows[i - 1].position))
            columns.refuse(columns.line(i), csv::decimal(rows[i].position) + " is not beyond " +
                                                csv::decimal(rows[i - 1].position));
    }
    if (rows.size() < 3) throw std::runtime_error(file + ": fewer than 3 rows show no straightness");
    return rows;
}

std::vector<DiagonalStep> read_steps(const std::string& file) {
    const Columns columns(file, {"distance", "deviation"});
    const std::size_t distance = columns.column("distance"), deviation = columns.column("deviation");
    std::vector<DiagonalStep> steps;
    for (std::size_t i = 0; i < columns.rows(); ++i) {
        steps.push_back({columns.value(i, distance), columns.value(i, deviation)});
        if (!(std::abs(steps[i].deviation) <= 10))
            columns.refuse(columns.line(i), "column deviation: " + csv::decimal(steps[i].deviation) +
                                                " is beyond 10 mm; is it in mm?");
        if (!(steps[i].distance > (i == 0 ? 0 : steps[i - 1].distance)))
            columns.refuse(columns.line(i),
                           "column distance: " + csv::decimal(steps[i].distance) + " does not rise");
    }
    return steps;
}

namespace {

// NAME VALUE [per AXIS], ...
void read_u(UncertainTable& table, const std::string& file, const std::string& name, std::string_view text) {
    const auto refuse = [&](std::string_view what) {
        throw std::runtime_error(file + ": " + name + ": " + csv::quoted(what) + " is none as EXX 0.3e-3" +
                                 (name == "u" || name == "repeatability" ? "" : " or EXX 1e-6 per X"));
    };
    for (const std::string_view entry : csv::split_at_commas(text)) {
        const std::size_t blank = entry.find(' ');
        if (blank == std::string_view::npos) refuse(entry);
        const std::string error(entry.substr(0, blank));
        std::string_view rest = csv::trimmed(entry.substr(blank));
        bool per = false;
        const std::size_t word = rest.find(" per ");
        if (word != std::string_view::npos && name != "u" && name != "repeatability") {
            if (rest.substr(word + 5) != std::string_view(&error[2], 1)) refuse(entry);
            per = true;
            rest = csv::trimmed(rest.substr(0, word));
        }
        const auto value = csv::number(rest);
        if (!value || !(*value >= 0 && *value < 1) || error.size() < 3 || error[0] != 'E') refuse(entry);
        if (error[2] != table.axis) continue;
        if (name == "u")
            table.u[error] = *value;
        else if (name == "repeatability")
            table.repeatability[error] = *value;
        else
            (name == "drift" ? table.drift : table.common)[error] = {*value, per};
    }
}

// The number before a unit, as 365 of "365 d".
std::optional<double> quantity(std::string_view text, std::string_view unit) {
    const std::size_t end = text.size() > unit.size() ? text.size() - unit.size() : 0;
    const auto value = csv::number(csv::trimmed(text.substr(0, end)));
    return value && text.substr(end) == unit && std::abs(*value) <= 1e5 ? value : std::nullopt;
}

}  // namespace

std::vector<UncertainTable> read_uncertain_tables(const std::vector<std::string>& files,
                                                  std::string* rotary) {
    read_error_tables({files.begin(), files.end()});  // which judges all of them
    std::vector<UncertainTable> tables;
    for (const std::string& file : files) {
        const std::string text = csv::text_of(file);
        const direction_rows::Lines lines(file, text);
        std::vector<std::pair<std::string, std::string>> heads;
        std::string date, by;
        double valid_for = UncertainTable{}.valid_for;
        std::optional<double> temperature;
        std::vector<std::string> names;
        bool left_out = false;
        const std::size_t first = tables.size();
        for (std::size_t i = 0; i < lines.size(); ++i) {
            if (lines[i].empty()) continue;
            if (lines[i][0] == '#') {
                const std::string_view words = csv::trimmed(lines[i].substr(1));
                const std::size_t colon = words.find(':');
                const std::string name(words.substr(0, std::min(colon, words.size())));
                if (name == "u" || name == "u-common" || name == "drift" || name == "repeatability")
                    heads.emplace_back(name, csv::trimmed(words.substr(colon + 1)));
                if (name == "date") date = csv::trimmed(words.substr(colon + 1));
                if (name == "by") by = csv::trimmed(words.substr(colon + 1));
                if (name == "temperature")  // its text is free
                    temperature = quantity(csv::trimmed(words.substr(colon + 1)), "degC");
                if (name != "valid-for") continue;
                const auto days = quantity(csv::trimmed(words.substr(colon + 1)), "d");
                if (!days || !(*days > 0)) lines.refuse(i, "valid-for has no form as 365 d");
                valid_for = *days;
                continue;
            }
            const auto fields = csv::split_at_commas(lines[i]);
            const auto is_axis = [](std::string_view field) {
                return field.size() == 1 && error_table_file::axes.find(field[0]) != std::string_view::npos;
            };
            const auto axis = std::find_if(fields.begin(), fields.end(), is_axis);
            if (axis != fields.end()) {
                names.assign(fields.begin(), fields.end());
                left_out = error_table_file::is_rotary((*axis)[0]);
                if (left_out && !rotary) lines.refuse(i, "plumb volume takes no table of a rotary axis here");
                if (left_out) {
                    *rotary += (*axis)[0];
                    continue;
                }
                tables.push_back({});
                tables.back().axis = (*axis)[0];
                for (const std::string& name : names)
                    if (name.size() > 1) tables.back().columns.push_back(name);
                continue;
            }
            if (left_out) continue;
            ErrorTable::Row mean, half;
            bool directed = false;
            for (std::size_t k = 0; k < names.size(); ++k) {
                const double value = *csv::number(fields[k]);
                if (names[k].size() == 1) {
                    mean.position = half.position = value;
                    continue;
                }
                const std::size_t error = error_index(names[k]);
                const char last = names[k].back();
                const bool its = names[k].size() == 4;
                directed |= its;
                mean.errors[error] += its ? value / 2 : value;
                if (its) half.errors[error] += last == '+' ? value / 2 : -value / 2;
            }
            tables.back().mean.push_back(mean);
            if (directed) tables.back().half.push_back(half);
        }
        for (std::size_t i = first; i < tables.size(); ++i) {
            tables[i].file = file;
            tables[i].date = date;
            tables[i].by = by;
            tables[i].valid_for = valid_for;
            tables[i].temperature = temperature;
            for (const auto& [name, value] : heads) read_u(tables[i], file, name, value);
        }
    }
    return tables;
}

TableError read_table_error(const std::string& file, const std::string& error) {
    const std::vector<UncertainTable> tables = read_uncertain_tables({file});
    for (const UncertainTable& table : tables) {
        if (table.axis != error[2]) continue;
        const bool given = std::any_of(table.columns.begin(), table.columns.end(),
                                       [&](const std::string& name) { return name.substr(0, 3) == error; });
        if (!given) break;
        const std::size_t k = error_index(error);
        TableError result{table.axis, {}};
        for (std::size_t i = 0; i < table.mean.size(); ++i) {
            const double mean = table.mean[i].errors[k],
                         half = table.half.empty() ? 0 : table.half[i].errors[k];
            result.rows.push_back({table.mean[i].position, mean + half, mean - half});
        }
        return result;
    }
    throw std::runtime_error(file + ": there is no " + error + " in it");
}

}  // namespace plumb::commissioning
