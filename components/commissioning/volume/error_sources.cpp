// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/volume/error_sources.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "components/commissioning/quantity_text.hpp"
#include "components/commissioning/squareness/squareness_of_chain.hpp"
#include "components/io/files/csv.hpp"
#include "components/io/files/direction_rows.hpp"

namespace plumb::commissioning {
namespace {

using Kind = ErrorLine::Kind;
using State = ErrorLine::State;

constexpr double reference_temperature = 20;  // degC, of ISO 1
constexpr double thermometer = 0.3;           // K, standard, of the difference of two readings
// 1/K. A screw of steel grows by 11.5e-6, one that a cold scale replaces by nothing: any value between is
// alike.
const double growth_per_kelvin = 11.5e-6 / std::sqrt(3.0);

Axis axis_of(char letter) {
    return static_cast<Axis>(std::string_view("XYZ").find(letter));
}

double opening_of_tilt(const KinematicChain::Settings& chain, std::size_t coordinate, int rotation, Axis a,
                       Axis b) {
    for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W})
        if (chain.axes.has(axis) && static_cast<std::size_t>(plumb::coordinate(axis)) == coordinate &&
            direction(axis) != rotation)
            return effect_of_tilt(chain.axes, chain.reading, chain.datum, axis, rotation).opening(a, b);
    return 0;
}

// A tilt that opens this corner, and no other one of X, Y and Z, by 1 rad.
UncertaintySource::Angle tilt_of_corner(const KinematicChain::Settings& chain, Axis a, Axis b) {
    const int rotation = 3 - direction(a) - direction(b);
    for (const Axis axis : {b, a}) {
        const auto place = static_cast<std::size_t>(coordinate(axis));
        const double opening = opening_of_tilt(chain, place, rotation, a, b);
        if (opening != 0) return {place, rotation, 1 / opening};
    }
    throw std::logic_error("no tilt opens a corner");
}

// By up to `most` of the travel: tolerances of ISO 10791-1, -2 and -4 for machining centres, in mm or rad.
struct Tolerances {
    double most, straightness, scale, lost_motion, repeatability;
};
constexpr Tolerances tolerances[] = {{500, 0.010, 0.010, 0.010, 0.006},
                                     {800, 0.015, 0.012, 0.010, 0.008},
                                     {1250, 0.020, 0.015, 0.012, 0.010},
                                     {2000, 0.025, 0.020, 0.012, 0.013}};
constexpr double square_tolerance = 0.020 / 500, angle_tolerance = 0.060 / 1000;

// A tolerance counts as U (k = 2) of the difference between two places, so the error of one place has the u
// tolerance / (2 sqrt 2). Lost motion is somewhere between 0 and its tolerance. Repeatability is 4 u.
void take_class(VolumeQuestion& q, ErrorLine& line) {
    const char letter = line.name.back();
    const std::size_t k = std::string_view("XYZ").find(letter);
    if (k == std::string_view::npos || line.kind > Kind::repeatability) return;
    const std::string iso = "ISO 10791, ";
    if (line.kind == Kind::corner) {
        ErrorList::set(line, State::assumed, square_tolerance / 2, iso + "20 um over 500 mm");
        return;
    }
    if (line.kind == Kind::angle) {
        ErrorList::set(line, State::assumed, angle_tolerance / std::sqrt(8.0), iso + "60 urad");
        return;
    }
    const double travel = q.high[k] - q.low[k];
    for (const Tolerances& its : tolerances) {
        if (travel > its.most) continue;
        const auto [tolerance, u] =
            line.kind == Kind::scale          ? std::pair(its.scale, its.scale / std::sqrt(8.0))
            : line.kind == Kind::straightness ? std::pair(its.straightness, its.straightness / std::sqrt(8.0))
            : line.kind == Kind::lost_motion  ? std::pair(its.lost_motion, its.lost_motion / std::sqrt(3.0))
                                              : std::pair(its.repeatability, its.repeatability / 4);
        ErrorList::set(line, State::assumed, u,
                       iso + csv::decimal(std::round(tolerance * 1000)) + " um, travel to " +
                           csv::decimal(its.most) + " mm");
        return;
    }
    line.by = "ISO 10791 ends at a travel of 2000 mm";
}

// K, by which the temperature differs from the temperature at which this axis was measured. Empty if one of
// the two is unknown.
std::optional<double> warmed(const VolumeQuestion& q, std::optional<double> now, char axis) {
    if (!now) return {};
    for (const UncertainTable& table : q.tables)
        if (table.axis == axis)
            return table.temperature ? std::optional(std::hypot(*now - *table.temperature, thermometer))
                                     : std::nullopt;
    return std::hypot(*now - reference_temperature, thermometer);
}

void take_sheet(const std::string& file, std::optional<double> kelvin, VolumeQuestion& q) {
    const std::string text = csv::text_of(file);
    const direction_rows::Lines lines(file, text);
    bool headed = false;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (lines[i].empty() || lines[i][0] == '#') continue;
        const auto fields = csv::split_at_commas(lines[i]);
        if (!headed) {
            if (fields.size() < 3 || fields[0] != "error" || fields[1] != "u" || fields[2] != "source")
                lines.refuse(i, csv::quoted(lines[i]) + " is not the head error,u,source");
            headed = true;
            continue;
        }
        if (fields.size() < 3 || csv::trimmed(fields[2]).empty())
            lines.refuse(i, csv::quoted(lines[i]) + " has no source: without one the error stays unknown");
        const std::string name(csv::trimmed(fields[0]));
        ErrorLine* const line = q.list.find(name);
        if (!line)
            lines.refuse(i, csv::quoted(name) +
                                " is no error of this chain, as XY, EYX, lost motion X or second axis");
        std::string_view value = csv::trimmed(fields[1]);
        const bool per_kelvin =
            line->kind == Kind::bending && value.size() > 2 && value.substr(value.size() - 2) == "/K";
        if (per_kelvin) value.remove_suffix(2);
        double u = 0;
        try {
            u = line->is_angle() || line->kind == Kind::growth ? angle_of(value) : length_of(value);
        } catch (const std::invalid_argument& error) {
            lines.refuse(i, name + ": " + error.what());
        }
        if (!(u > 0 && u < (line->is_angle() || line->kind == Kind::growth ? 0.1 : 10)))
            lines.refuse(i, name + ": " + csv::quoted(value) + " is no u above 0");
        if (line->state != State::unknown) continue;
        if (per_kelvin && !kelvin) {
            line->by = "the temperature is not known";
            continue;
        }
        ErrorList::set(*line, State::assumed, per_kelvin ? u * *kelvin : u,
                       std::string(lines[i].substr(
                           static_cast<std::size_t>(csv::trimmed(fields[2]).data() - lines[i].data()))) +
                           (per_kelvin ? ", by " + csv::decimal(std::round(*kelvin * 10) / 10) + " K" : ""));
    }
    if (!headed) lines.refuse("there is no line error,u,source in it");
}

// Rows of 0 in the places of a table that the axis does not have.
void need_rows(VolumeQuestion& q, std::size_t axis, bool half) {
    auto& rows = q.measured.means[axis];
    if (rows.empty())
        for (const double part : {0.0, 0.5, 1.0})
            rows.push_back({q.low[axis] + part * (q.high[axis] - q.low[axis]), {}});
    auto& halves = q.measured.halves[axis];
    if (half && halves.empty())
        for (const ErrorTable::Row& row : rows) halves.push_back({row.position, {}});
}

// An error of an axis that may be anything along it: independent at both ends and in the middle, and linear
// between.
void add_along(VolumeQuestion& q, const ErrorLine& line) {
    const std::size_t axis = static_cast<std::size_t>(coordinate(axis_of(line.name[2]))),
                      error = error_index(line.name);
    need_rows(q, axis, false);
    const double half = (q.high[axis] - q.low[axis]) / 2;
    for (const double part : {0.0, 1.0, 2.0}) {
        UncertaintySource source{line.name, {}, {}};
        const auto& rows = q.measured.means[axis];
        for (std::size_t row = 0; row < rows.size(); ++row) {
            const double at = std::min(2.0, std::max(0.0, (rows[row].position - q.low[axis]) / half));
            const double weight = std::max(0.0, 1 - std::abs(at - part));
            if (weight > 0) source.rows.push_back({axis, row, error, weight * line.u});
        }
        q.measured.sources.push_back(source);
    }
}

void add_corner(VolumeQuestion& q, const std::string& name, Axis a, Axis b, double u) {
    UncertaintySource::Angle its = tilt_of_corner(q.measured.chain, a, b);
    its.factor *= u;
    q.measured.sources.push_back({name, {its}, {}});
}

void add_sources(VolumeQuestion& q, const ErrorLine& line, std::optional<double> now) {
    auto& sources = q.measured.sources;
    const auto along = [&](char letter, auto factor, bool half) {
        const auto axis = static_cast<std::size_t>(coordinate(axis_of(letter)));
        need_rows(q, axis, half);
        UncertaintySource source{line.name, {}, {}};
        for (std::size_t row = 0; row < q.measured.means[axis].size(); ++row)
            source.rows.push_back(
                {axis, row, axis, factor(q.measured.means[axis][row].position - q.low[axis]), half});
        sources.push_back(source);
    };
    const auto tip = [&](const Eigen::Vector3d& u) {
        UncertaintySource source{line.name, {}, {}};
        source.tip = u;
        sources.push_back(source);
    };
    switch (line.kind) {
        case Kind::corner:
            add_corner(q, line.name, axis_of(line.name[0]), axis_of(line.name[1]), line.u);
            break;
        case Kind::scale:
        case Kind::straightness:
        case Kind::angle: add_along(q, line); break;
        case Kind::lost_motion:
            along(
                line.name.back(), [&](double) { return line.u / 2; }, true);
            break;
        case Kind::repeatability:
            tip(line.u * Eigen::Vector3d::Unit(direction(axis_of(line.name.back()))));
            break;
        case Kind::second_axis: tip(Eigen::Vector3d::Constant(line.u)); break;
        case Kind::growth: {  // of all axes alike: screws of one make
            UncertaintySource together{line.name, {}, {}};
            for (const char axis : {'X', 'Y', 'Z'}) {
                if (!q.measured.chain.axes.has(axis_of(axis))) continue;
                const auto kelvin = warmed(q, now, axis);
                const double u =
                    line.state == State::measured && kelvin ? growth_per_kelvin * *kelvin : line.u;
                along(
                    axis, [&](double from) { return u * from; }, false);
                const UncertaintySource& its = sources.back();
                together.rows.insert(together.rows.end(), its.rows.begin(), its.rows.end());
                sources.pop_back();
            }
            sources.push_back(together);
            break;
        }
        case Kind::bending:
            for (const ErrorLine& corner : q.list.lines())
                if (corner.kind == Kind::corner)
                    add_corner(q, line.name, axis_of(corner.name[0]), axis_of(corner.name[1]), line.u);
            break;
        case Kind::drift: break;
    }
}

}  // namespace

void state_corners(const std::vector<GivenTilt>& given, VolumeQuestion& q) {
    for (const ErrorLine& its : std::vector<ErrorLine>(q.list.lines())) {
        if (its.kind != Kind::corner) continue;
        const Axis a = axis_of(its.name[0]), b = axis_of(its.name[1]);
        std::string by;
        bool without = false;
        for (const GivenTilt& tilt : given) {
            const auto [axis, rotation, factor] = tilt.angle;
            if (axis != static_cast<std::size_t>(coordinate(a)) &&
                axis != static_cast<std::size_t>(coordinate(b)))
                continue;
            if (opening_of_tilt(q.measured.chain, axis, rotation, a, b) == 0) continue;
            by += (by.empty() ? "" : ", ") + tilt.name + (tilt.by.empty() ? "" : " (" + tilt.by + ')');
            bool certain = false;
            for (const UncertaintySource& source : q.measured.sources)
                for (const UncertaintySource::Angle& angle : source.angles)
                    certain |= angle.axis == axis && angle.rotation == rotation && angle.factor != 0;
            without |= !certain;
        }
        if (by.empty()) continue;
        double variance = 0;
        for (const UncertaintySource& source : q.measured.sources) {
            double opens = 0;
            for (const UncertaintySource::Angle& angle : source.angles)
                opens += opening_of_tilt(q.measured.chain, angle.axis, angle.rotation, a, b) * angle.factor;
            variance += opens * opens;
        }
        ErrorList::set(*q.list.find(its.name), State::measured, without ? 0 : std::sqrt(variance), by);
    }
}

void assume(const std::vector<std::string>& sources, std::optional<double> now, VolumeQuestion& q) {
    // Before the sources: without a temperature nothing states growth but a sheet.
    double largest = 0;
    bool known = true;
    for (const char axis : {'X', 'Y', 'Z'}) {
        const auto kelvin = warmed(q, now, axis);
        known &= kelvin.has_value();
        largest = std::max(largest, kelvin.value_or(0));
    }
    ErrorLine& growth = *q.list.find("growth");
    if (known)
        ErrorList::set(growth, State::measured, growth_per_kelvin * largest,
                       "thermometer, " + csv::decimal(std::round(largest * 10) / 10) +
                           " K, a screw of 0 to 11.5 um/m for each K");
    for (const std::string& source : sources) {
        if (source != "iso-10791") {
            take_sheet(source, known ? std::optional(largest) : std::nullopt, q);
            continue;
        }
        for (const ErrorLine& line : std::vector<ErrorLine>(q.list.lines()))
            if (line.state == State::unknown) take_class(q, *q.list.find(line.name));
    }
    for (const ErrorLine& line : std::vector<ErrorLine>(q.list.lines()))
        if (line.state == State::assumed || (line.state == State::measured && line.kind == Kind::growth))
            add_sources(q, line, now);
}

}  // namespace plumb::commissioning
