// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/volume/volume_of.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <ctime>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>

#include <sys/stat.h>

#include "components/commissioning/quantity_text.hpp"
#include "components/commissioning/volume/error_sources.hpp"
#include "components/commissioning/volume/volume_files.hpp"
#include "components/io/files/csv.hpp"
#include "components/math/geometry/axis_chain.hpp"

namespace plumb::commissioning {
namespace {

using Kind = ErrorLine::Kind;
using State = ErrorLine::State;

[[noreturn]] void refuse(const std::string& option, std::string_view text, const std::string& why) {
    throw std::invalid_argument(option + ": " + csv::quoted(text) + ' ' + why);
}

// The coordinate of an axis of the chain.
std::size_t place_of(char letter, const AxisChain& chain, const std::string& option, std::string_view text) {
    for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W})
        if (plumb::letter(axis) == letter && chain.has(axis))
            return static_cast<std::size_t>(coordinate(axis));
    refuse(option, text, "names an axis that the chain does not have");
}

double angle(const std::string& option, const std::string& text) {
    try {
        return angle_of(text);
    } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(option + ": " + error.what());
    }
}

double u_length(const std::string& option, const std::string& text) {
    try {
        const double u = length_of(text);
        if (u >= 0 && u < 10) return u;
    } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(option + ": " + error.what());
    }
    refuse(option, text, "is not from 0 to 10 mm");
}

double u_angle(const std::string& option, const std::string& text) {
    const double u = angle(option, text);
    if (!(u >= 0 && u < 0.1)) refuse(option, text, "is not from 0 to 0.1 rad");
    return u;
}

// NAME=VALUE
std::pair<std::string, std::string> halves(const std::string& option, std::string_view text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos || equals == 0) refuse(option, text, "has no form as NAME=VALUE");
    return {std::string(csv::trimmed(text.substr(0, equals))),
            std::string(csv::trimmed(text.substr(equals + 1)))};
}

// Days since 1970 of a date as 2026-11-20; none if it is no date.
std::optional<int> days_of(std::string_view date) {
    int y = 0, m = 0, d = 0;
    char rest = 0;
    if (std::sscanf(std::string(date).c_str(), "%4d-%2d-%2d%c", &y, &m, &d, &rest) != 3 || y < 1970 ||
        m < 1 || m > 12 || d < 1)
        return {};
    const bool leap = (y % 4 == 0 && y % 100 != 0) || y % 400 == 0;
    if (d > (m == 2 ? 28 + leap : 30 + (m + m / 8) % 2)) return {};
    y -= m <= 2;  // of years that begin in March
    const int in_era = y % 400, day = (153 * (m > 2 ? m - 3 : m + 9) + 2) / 5 + d - 1;
    return y / 400 * 146097 + in_era * 365 + in_era / 4 - in_era / 100 + day - 719468;
}

constexpr double year = 365.25;  // days

// The age in days of a measurement; none if it has no date, or the clock is not set.
std::optional<double> age_of(const VolumeOptions& options, const std::string& date) {
    const auto then = days_of(date);
    std::optional<int> now;
    if (options.today.empty()) {
        now = static_cast<int>(std::time(nullptr) / 86400);
        if (*now < days_of("2025-01-01")) now.reset();
    } else {
        now = days_of(options.today);
        if (!now) refuse("--today", options.today, "is no date, as 2026-11-26");
    }
    if (!then || !now || *now < *then) return {};
    return *now - *then;
}

std::optional<double> temperature_of(const std::string& given) {
    if (given.empty()) return {};
    std::string_view text = given;
    const bool named = text.size() > 4 && text.substr(text.size() - 4) == "degC";
    const auto now = csv::number(csv::trimmed(named ? text.substr(0, text.size() - 4) : ""));
    if (!now || !(*now > -50 && *now < 100)) refuse("--temperature", given, "has no form as 24degC");
    return now;
}

// A measurement ages: the machine drifts, and its temperature changes. `add` adds a common cause by its
// standard uncertainty: a constant, and one per mm of the position.
void add_age(
    const VolumeOptions& options, const UncertainTable& table, VolumeQuestion& q,
    const std::function<void(const std::string& name, const std::string& error, double, double)>& add) {
    const std::string letter(1, table.axis), its = "The table of " + letter + " in " + table.file;
    const std::optional<double> age = age_of(options, table.date);
    const double counted = age ? *age : table.valid_for;
    const bool old = age && *age > table.valid_for;
    if (!age && (!table.drift.empty() || !table.date.empty()))
        q.notes.push_back(
            {"age-unknown", letter, table.valid_for, 0,
             its +
                 (table.date.empty() ? " has no date"
                  : !days_of(table.date)
                      ? " has the date " + csv::quoted(table.date) + ", which is none as 2026-11-20"
                      : " is of " + table.date + ", and the clock shows no later date") +
                 ": its age is unknown, and counts as " + csv::decimal(table.valid_for) + " days."});
    if (old)
        q.notes.push_back({"old", letter, *age, table.valid_for,
                           its + " is " + csv::decimal(*age) + " days old, and valid for " +
                               csv::decimal(table.valid_for) + ": measure again."});
    double longest = 0;
    for (const ErrorTable::Row& row : table.mean) longest = std::max(longest, std::abs(row.position));
    for (const auto& [error, drift] : table.drift) {
        const double u = drift.value * counted / year;
        const std::string name = "drift " + error;
        ErrorList::set(q.list.line(Kind::drift, name), State::measured, drift.per_position ? u * longest : u,
                       table.file + ", " + csv::decimal(counted) + " days");
        add(name, error, drift.per_position ? 0 : u, drift.per_position ? u : 0);
    }
    if (old && table.drift.empty())
        q.list.line(Kind::drift, "drift " + letter).by = "an old table without # drift";
}

// EC0Y
UncertaintySource::Angle tilt_of(const std::string& option, const std::string& name, const AxisChain& chain) {
    if (name.size() != 4 || name[0] != 'E' || name[1] < 'A' || name[1] > 'C' || name[2] != '0')
        refuse(option, name, "is no tilt, as EC0Y");
    return {place_of(name[3], chain, option, name), name[1] - 'A', 1};
}

// Rotary axes of the chain stand at 0.
void add_rotary(const VolumeOptions& options, const std::string& with_tables, VolumeQuestion& q) {
    std::string turning, names;
    for (const char axis : {'A', 'B', 'C'})
        if (options.chain.find(axis) != std::string::npos) turning += axis;
    if (turning == "C" && options.chain.find('C') > options.chain.find('b')) turning.clear();  // a spindle
    for (const char axis : with_tables)
        if (turning.find(axis) == std::string::npos) turning += axis;
    for (const char axis : turning) names += (names.empty() ? "" : ", ") + std::string(1, axis);
    if (!names.empty())
        q.notes.push_back(
            {"rotary", names, 0, 0,
             "The rotary axes stand at 0: " + names + ". Their errors, and other angles, are not in U."});
}

// The line of a column: EXX, or of the difference by direction, which is the lost motion of a scale.
ErrorLine& line_of(const UncertainTable& table, const std::string& name, bool half, ErrorList& list) {
    const std::string error = name.substr(0, 3);
    const bool scale = error_index(error) == std::string_view("XYZUVW").find(table.axis) % 3;
    if (half && scale) return list.line(Kind::lost_motion, "lost motion " + error.substr(2));
    return list.line(scale                    ? Kind::scale
                     : error_index(error) < 3 ? Kind::straightness
                                              : Kind::angle,
                     half ? error + " by direction" : error);
}

void state_table(const UncertainTable& table, const std::string& name, bool half, double u, ErrorList& list) {
    ErrorLine& line = line_of(table, name, half, list);
    const std::string by = table.by.empty() ? table.file : table.by;
    ErrorList::set(line, State::measured, line.kind == Kind::lost_motion ? 2 * u : u,
                   by + (table.date.empty() ? ", no date" : ", " + table.date));
}

void add_tables(const VolumeOptions& options, VolumeQuestion& q) {
    MeasuredVolume& m = q.measured;
    std::string rotary;
    const std::vector<UncertainTable> tables = read_uncertain_tables(options.tables, &rotary);
    add_rotary(options, rotary, q);
    for (const UncertainTable& table : tables) {
        const std::size_t axis = place_of(table.axis, m.chain.axes, "--table", std::string(1, table.axis));
        m.means[axis] = table.mean;
        m.halves[axis] = table.half;
        q.tables.push_back(table);
        for (const auto& [error, value] : table.repeatability)
            ErrorList::set(q.list.line(Kind::repeatability, "repeatability " + error.substr(2)),
                           State::measured, value, table.file);
        add_age(options, table, q,
                [&](const std::string& name, const std::string& error, double constant, double per) {
                    UncertaintySource source{name, {}, {}};
                    for (std::size_t row = 0; row < table.mean.size(); ++row)
                        source.rows.push_back(
                            {axis, row, error_index(error), constant + per * table.mean[row].position});
                    m.sources.push_back(source);
                });
        for (const std::string& column : table.columns) {
            if (column.back() == '-') continue;
            const bool directed = column.back() == '+';
            const std::string error = column.substr(0, 3);
            const std::size_t e = error_index(error);
            // Of a column for each direction the mean may be unknown: an indicator shows no scale.
            std::vector<std::pair<std::string, bool>> parts{{error, false}};
            if (directed) parts.emplace_back(error + '+', true);
            for (const auto& [name, half] : parts) {
                const auto u = table.u.find(name);
                const auto common = table.common.find(name);
                const double one = u == table.u.end() ? 0 : u->second;
                double all = 0;
                for (const ErrorTable::Row& row : table.mean)
                    if (common != table.common.end())
                        all = std::max(all, common->second.value *
                                                (common->second.per_position ? std::abs(row.position) : 1));
                state_table(table, name, half, std::hypot(one, all), q.list);
                const std::size_t rows = table.mean.size();
                for (std::size_t row = 0; u != table.u.end() && u->second > 0 && row < rows; ++row)
                    m.sources.push_back({error, {}, {{axis, row, e, u->second, half}}});
                if (common == table.common.end() || common->second.value == 0) continue;
                UncertaintySource together{error + ", all rows together", {}, {}};
                for (std::size_t row = 0; row < rows; ++row)
                    together.rows.push_back(
                        {axis, row, e,
                         common->second.value * (common->second.per_position ? table.mean[row].position : 1),
                         half});
                m.sources.push_back(together);
            }
        }
    }
}

}  // namespace

namespace {

std::string date_of(std::time_t time) {
    char text[11];
    std::tm parts{};
    if (time / 86400 < *days_of("2025-01-01") || !localtime_r(&time, &parts)) return "";
    return std::strftime(text, sizeof text, "%Y-%m-%d", &parts) ? text : "";
}

}  // namespace

std::string date_of_today() {
    return date_of(std::time(nullptr));
}

std::string date_of_file(const std::string& file) {
    struct stat its {};
    return stat(file.c_str(), &its) == 0 ? date_of(its.st_mtime) : "";
}

std::string date_line(const std::string& date) {
    if (!date.empty() && !days_of(date)) refuse("--date", date, "is no date, as 2026-11-26");
    return date.empty() ? "" : "# date: " + date + '\n';
}

namespace {

// Beyond its ends a table holds its last value, and nothing was measured.
void add_table_ends(VolumeQuestion& q) {
    for (const UncertainTable& table : q.tables) {
        const std::size_t k = std::string_view("XYZ").find(table.axis);
        if (k == std::string_view::npos) continue;
        const double first = table.mean.front().position, last = table.mean.back().position;
        if (first <= q.low[k] + 1e-6 && last >= q.high[k] - 1e-6) continue;
        const std::string ends = "ends at " + csv::decimal(first) + " and " + csv::decimal(last) + " mm";
        for (const std::string& column : table.columns)
            for (const bool half : {false, true}) {
                if (half && column.size() < 4) continue;
                ErrorLine& line = line_of(table, column, half, q.list);
                line.state = State::unknown;
                line.by = table.file + ' ' + ends;
            }
        q.notes.push_back(
            {"table-ends", std::string(1, table.axis), first, last,
             "The table of " + std::string(1, table.axis) + " in " + table.file + ' ' + ends +
                 ", within the work space: beyond, the last value holds, and nothing was measured."});
    }
}

}  // namespace

VolumeQuestion question_of(const VolumeOptions& options) {
    VolumeQuestion q;
    MeasuredVolume& m = q.measured;
    m.chain.axes = AxisChainReader::read_linear(options.chain);
    q.list = ErrorList(m.chain.axes);
    age_of(options, "");  // which judges the options
    temperature_of(options.temperature);
    m.max_correction = options.max_correction;
    if (!(m.max_correction > 0 && m.max_correction <= 100))
        refuse("--max-correction", csv::decimal(options.max_correction), "is not from 0 to 100 mm");
    for (const std::string& text : options.pivots) {
        const auto [key, value] = halves("--pivot", text);
        const auto position = csv::number(value);
        if (key.size() != 1 || !position || !(std::abs(*position) <= 1e5))
            refuse("--pivot", text, "has no form as Y=300");
        m.pivot[static_cast<Eigen::Index>(place_of(key[0], m.chain.axes, "--pivot", text))] = *position;
    }
    std::set<std::string> given_tilts;
    std::vector<GivenTilt> tilts;
    std::vector<UncertaintySource> aging;
    for (const std::string& text : options.tilts) {
        std::optional<UncertaintySource::Angle> its;
        std::optional<double> u;
        double drift = 0;
        std::string name, date, by;
        for (const std::string_view field : csv::split_at_commas(text)) {
            const auto [key, value] = halves("--tilt", field);
            if (key == "u") {
                u = u_angle("--tilt", value);
            } else if (key == "drift") {
                drift = u_angle("--tilt", value);
            } else if (key == "date") {
                if (!days_of(value)) refuse("--tilt", field, "is no date, as 2026-11-20");
                date = value;
            } else if (key == "by") {
                by = value;
            } else {
                if (its) refuse("--tilt", text, "has two angles: give each its own --tilt, with its own u");
                its = tilt_of("--tilt", key, m.chain.axes);
                name = key;
                if (!given_tilts.insert(name).second)
                    refuse("--tilt", text, "gives " + name + " a second time");
                double& its_angle = m.chain.tilts[its->axis].angles[its->rotation];
                its_angle = angle("--tilt", value);
                if (!(std::abs(its_angle) < 0.1)) refuse("--tilt", text, "is no angle below 0.1 rad");
            }
        }
        if (!its) refuse("--tilt", text, "has no angle, as EC0Y=-80urad");
        if (u && *u > 0) m.sources.push_back({name, {{its->axis, its->rotation, *u}}, {}});
        tilts.push_back({*its, name, by + (by.empty() || date.empty() ? "" : ", ") + date});
        const auto age = age_of(options, date);
        if (age && *age > UncertainTable{}.valid_for)
            q.notes.push_back({"old", name, *age, UncertainTable{}.valid_for,
                               name + " was measured " + csv::decimal(*age) + " days ago: measure again."});
        if (drift > 0 && !age)
            q.notes.push_back({"age-unknown", name, UncertainTable{}.valid_for, 0,
                               "The age of " + name + " is unknown, and counts as a year."});
        if (drift > 0) {
            const double days = age.value_or(UncertainTable{}.valid_for), u_drift = drift * days / year;
            aging.push_back({"drift " + name, {{its->axis, its->rotation, u_drift}}, {}});
            ErrorList::set(q.list.line(Kind::drift, "drift " + name), State::measured, u_drift,
                           "--tilt, " + csv::decimal(days) + " days");
        }
    }
    for (const std::string& text : options.commons) {
        UncertaintySource source;
        std::optional<double> u;
        for (const std::string_view field : csv::split_at_commas(text)) {
            if (field.find('=') == std::string_view::npos) {
                source.name = field;
                continue;
            }
            const auto [key, value] = halves("--common", field);
            if (key == "u") {
                u = u_angle("--common", value);
                continue;
            }
            UncertaintySource::Angle its = tilt_of("--common", key, m.chain.axes);
            const auto factor = csv::number(value);
            if (!factor || !(std::abs(*factor) <= 100))
                refuse("--common", field, "has no factor, as EC0X=0.5");
            its.factor = *factor;
            source.angles.push_back(its);
        }
        if (source.name.empty() || source.angles.empty() || !u)
            refuse("--common", text, "has no form as NAME,EC0Y=1,EC0X=0.5,u=3urad");
        for (UncertaintySource::Angle& its : source.angles) its.factor *= *u;
        m.sources.push_back(source);
    }
    state_corners(tilts, q);
    m.sources.insert(m.sources.end(), aging.begin(), aging.end());
    add_tables(options, q);
    for (const std::string& text : options.repeatability) {
        const auto [key, value] = halves("--repeatability", text);
        if (key.size() != 1) refuse("--repeatability", text, "has no form as X=0.5um");
        place_of(key[0], m.chain.axes, "--repeatability", text);
        ErrorList::set(q.list.line(Kind::repeatability, "repeatability " + key), State::measured,
                       u_length("--repeatability", value), "--repeatability");
    }
    for (const ErrorLine& line : q.list.lines()) {
        if (line.kind != Kind::repeatability || line.state == State::unknown) continue;
        UncertaintySource source{"repeatability", {}, {}};
        source.tip[static_cast<Eigen::Index>(std::string("XYZUVW").find(line.name.back()) % 3)] = line.u;
        m.sources.push_back(source);
    }
    if (!options.tool_u.empty()) {
        UncertaintySource source{"tool length", {}, {}};
        source.tool.z() = u_length("--tool-u", options.tool_u);
        m.sources.push_back(source);
    }

    bool given[3] = {};
    double clamped = 0;  // of U, V or W
    for (const std::string_view field : csv::split_at_commas(options.box)) {
        const auto [key, value] = halves("--box", field);
        if (key.size() == 1 && std::string("UVW").find(key) != std::string::npos) {
            const auto at = csv::number(value);
            place_of(key[0], m.chain.axes, "--box", field);
            if (!at || !(std::abs(*at) <= 1e5)) refuse("--box", field, "has no form as W=300");
            clamped = *at;
            continue;
        }
        const std::size_t k = key.size() == 1 ? std::string("XYZ").find(key) : std::string::npos;
        const std::size_t colon = value.find(':');
        const auto from = csv::number(value.substr(0, std::min(colon, value.size())));
        const auto to = csv::number(colon == std::string::npos ? "" : value.substr(colon + 1));
        if (k > 2 || !from || !to || !(*to - *from >= 1) || !(std::abs(*from) <= 1e5 && std::abs(*to) <= 1e5))
            refuse("--box", field, "has no form as X=0:800, at least 1 mm long");
        if (given[k]) refuse("--box", options.box, "gives " + key + " a second time");
        q.low[k] = *from, q.high[k] = *to, given[k] = true;
    }
    if (!(given[0] && given[1] && given[2])) refuse("--box", options.box, "does not name X, Y and Z");
    std::vector<std::string> tools = options.tools;
    if (tools.empty()) tools = {"no tool=0,0,0"};
    for (const std::string& text : tools) {
        VolumePlace place;
        const std::size_t equals = text.rfind('=');
        const auto fields = csv::split_at_commas(std::string_view(text).substr(equals + 1));
        if (equals == std::string::npos || fields.size() != 3)
            refuse("--tool", text, "has no form as T3=0,0,-200");
        place.name = text.substr(0, equals);
        for (Eigen::Index i = 0; i < 3; ++i) {
            const auto value = csv::number(fields[static_cast<std::size_t>(i)]);
            if (!value || !(std::abs(*value) <= 1e4)) refuse("--tool", text, "has no lengths below 1e4 mm");
            place.tool[i] = *value;
        }
        if (place.tool.z() > 0)
            refuse("--tool", text,
                   "points to +Z, into the spindle: a tool that is " + csv::decimal(place.tool.z()) +
                       " mm long has -" + csv::decimal(place.tool.z()));
        for (int x = 0; x < 3; ++x)
            for (int y = 0; y < 3; ++y)
                for (int z = 0; z < 3; ++z) {
                    place.position[3] = clamped;
                    place.position.head<3>() << q.low[0] + x * (q.high[0] - q.low[0]) / 2,
                        q.low[1] + y * (q.high[1] - q.low[1]) / 2, q.low[2] + z * (q.high[2] - q.low[2]) / 2;
                    q.places.push_back(place);
                }
    }
    add_table_ends(q);
    q.reference = q.places.front();
    if (!options.reference.empty())
        for (const std::string_view field : csv::split_at_commas(options.reference)) {
            const auto [key, value] = halves("--reference", field);
            const std::size_t k = key.size() == 1 ? std::string("XYZ").find(key) : std::string::npos;
            const auto number = csv::number(value);
            if (k > 2 || !number || !(std::abs(*number) <= 1e5))
                refuse("--reference", field, "has no form as X=0");
            q.reference.position[static_cast<Eigen::Index>(k)] = *number;
        }
    assume(options.assumed, temperature_of(options.temperature), q);
    return q;
}

std::vector<DiagonalState> diagonals_of(const VolumeQuestion& q, const VolumeOptions& options) {
    std::map<std::string, std::vector<DiagonalStep>> steps;
    for (const std::string& text : options.steps) {
        const auto [name, file] = halves("--steps", text);
        if (name != "PPP" && name != "NPP" && name != "PNP" && name != "NNP")
            refuse("--steps", text, "has no form as PPP=steps.csv; NPP, PNP and NNP are the other diagonals");
        steps[name] = read_steps(file);
    }
    std::vector<DiagonalState> result;
    for (const char* name : {"PPP", "NPP", "PNP", "NNP"}) {
        VolumePlace from = q.places.front();
        Eigen::Vector3d way;
        for (Eigen::Index i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const bool back = name[i] == 'N';
            from.position[i] = back ? q.high[k] : q.low[k];
            way[i] = back ? q.low[k] - q.high[k] : q.high[k] - q.low[k];
        }
        const double length = way.norm();
        const Eigen::Vector3d along = way / length;
        std::vector<VolumePlace> places;
        const auto add = [&](double distance) {
            VolumePlace place = from;
            place.position.head<3>() += distance * along;
            places.push_back(place);
        };
        for (const DiagonalStep& step : steps[name]) {
            if (step.distance > length + 1e-3)
                throw std::runtime_error("--steps: " + std::string(name) + " has a step at " +
                                         csv::decimal(step.distance) + " mm, beyond the diagonal of the box");
            add(step.distance);
        }
        add(length);
        const VolumeUncertainty r =
            uncertainty_of(q.measured, from, places, options.draws, static_cast<std::uint64_t>(options.seed));
        const auto at = [&](std::size_t i) {
            const PlaceUncertainty& its = r.places[i];
            return DiagonalPoint{its.without.dot(along), its.rest.dot(along),
                                 2 * std::sqrt(std::max(0.0, along.dot(its.covariance * along)))};
        };
        DiagonalState its{name, length, at(places.size() - 1), {}};
        for (std::size_t i = 0; i + 1 < places.size(); ++i)
            its.steps.push_back({steps[name][i].distance, steps[name][i].deviation, at(i)});
        result.push_back(its);
    }
    return result;
}

std::string table_with_reversal(const std::string& file, char axis, const std::string& error,
                                const DirectionRows& rows, const std::string& head, const std::string& date) {
    std::vector<ErrorTable::Row> half;
    for (const DirectionRow& row : rows) {
        half.push_back({row.position, {}});
        half.back().errors[0] = (row.up - row.down) / 2;
    }
    const ErrorTable reversal(half);
    std::string text;
    std::size_t count = 0;
    bool found = false;
    std::string older;
    const std::size_t e = error_index(error);
    for (const UncertainTable& table : read_uncertain_tables({file})) {
        if (table.axis != axis) throw std::runtime_error(file + ": holds a table of another axis");
        found = true;
        if (days_of(table.date))
            older = days_of(date) && *days_of(date) < *days_of(table.date) ? date : table.date;
        std::vector<std::string> names;
        for (const std::string& name : table.columns)
            if (name.substr(0, 3) != error) names.push_back(name);
        text += std::string(1, axis) + ',' + error + "+," + error + '-';
        for (const std::string& name : names) text += ',' + name;
        text += '\n';
        for (std::size_t i = 0; i < table.mean.size(); ++i, ++count) {
            const ErrorTable::Row& mean = table.mean[i];
            const double h = reversal.at(mean.position).errors[0];
            text += csv::decimal(mean.position) + ',' + csv::decimal(mean.errors[e] + h) + ',' +
                    csv::decimal(mean.errors[e] - h);
            for (const std::string& name : names) {
                const double its = name.size() == 4 ? table.half[i].errors[error_index(name)] : 0;
                text +=
                    ',' + csv::decimal(mean.errors[error_index(name)] + (name.back() == '-' ? -its : its));
            }
            text += '\n';
        }
        for (const auto& [name, value] : table.u)
            if (name != error + '+') text = "# u: " + name + ' ' + csv::decimal(value) + '\n' + text;
    }
    if (!found) throw std::runtime_error(file + ": there is no table of " + std::string(1, axis));
    return error_table_file::Reader::sealed(
        file, date_line(older) + head + text + error_table_file::end_line(count) + '\n');
}

}  // namespace plumb::commissioning
