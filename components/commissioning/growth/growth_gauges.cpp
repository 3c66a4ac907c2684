// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_gauges.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace plumb::commissioning {
namespace {

using Quantity = GrowthGauges::Quantity;
constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double hour = 3600, quarter = 900;
constexpr double turning = 1;             // rpm
constexpr double longest_interval = 300;  // s, between two values
constexpr double wanted_time = 4 * hour;  // of the warm-up
constexpr double settled = 0.15;          // change in the last hour, of that in the first
constexpr std::size_t most_fitted = 150;  // values

double at(const Quantity& its, double time) {
    return time > its.samples.back().first ? none : value_at(its.samples, time);
}

double range_in(const Quantity& its, double from, double to) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const auto& [time, value] : its.samples) {
        if (time < from || time > to) continue;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    return std::max(0.0, high - low);
}

// The largest change in a quarter of an hour, per h.
double rate_in(const Quantity& its, double from, double to) {
    double largest = 0;
    for (const auto& [end, value] : its.samples) {
        if (end - quarter < from || end > to) continue;
        const double rate = (value - at(its, end - quarter)) / quarter * hour;
        if (std::abs(rate) > std::abs(largest)) largest = rate;
    }
    return largest;
}

std::optional<GrowthCurve> curve_in(const Quantity& its, double from, double to) {
    GrowthSamples fitted;
    double next = from;
    for (const auto& [time, value] : its.samples) {
        if (time < next || time > to) continue;
        fitted.emplace_back(time, value);
        next = time + (to - from) / static_cast<double>(most_fitted);
    }
    return curve_of(fitted);
}

template <class Value>
Quantity series(const GrowthCourse& course, const std::string& name, const std::string& unit,
                Value value_of) {
    Quantity its;
    its.name = name;
    its.unit = unit;
    const double begin = course.values.front().time;
    double first = none;
    for (const GrowthCourse::Value& each : course.values) {
        const double value = value_of(each);
        if (!std::isfinite(value)) continue;
        if (!std::isfinite(first)) first = value;
        its.samples.emplace_back(each.time - begin, value - first);
    }
    return its;
}

void measure(Quantity& its, const GrowthGauges& test) {
    const double end = test.environment ? test.length : test.warmed;
    its.at_1_hour = end >= hour ? at(its, hour) : none;
    its.at_4_hours = end >= 4 * hour ? at(its, 4 * hour) : none;
    its.warm = at(its, std::min(end, its.samples.back().first));
    its.range = range_in(its, 0, end);
    its.rate = rate_in(its, 0, end);
    its.left = its.samples.back().second;
    its.cooling_rate = rate_in(its, test.warmed, test.length);
    its.curve = curve_in(its, 0, end);
    its.expanded = its.curve ? 2 * std::sqrt(2.0) * its.curve->noise : none;
}

void find_spindle(const GrowthCourse& course, GrowthGauges& test) {
    const double begin = course.values.front().time;
    double slowest = HUGE_VAL, fastest = 0, last = -1;
    bool stood = false;
    for (const auto& [time, speed] : course.speeds) {
        const double size = std::abs(speed);
        if (size < turning) {
            stood = last >= 0;
            continue;
        }
        if (stood) test.steady_duty = false;  // a rest in between
        last = time - begin;
        slowest = std::min(slowest, size);
        fastest = std::max(fastest, size);
    }
    test.environment = last < 0;
    if (test.environment) return;
    if (slowest < 0.8 * fastest) test.steady_duty = false;
    test.warmed = last;
    test.cooled = test.length - last;
}

void compare_with_standard(GrowthGauges& test) {
    const auto has = [&](const char* name) {
        return std::any_of(test.quantities.begin(), test.quantities.end(),
                           [&](const Quantity& its) { return its.name == name; });
    };
    for (const char* name : {"X", "Y", "Z"})
        if (!has(name)) test.missing.push_back(std::string("no sensor of ") + name);
    if (!has("tilt about X") || !has("tilt about Y"))
        test.missing.emplace_back("no tilt: it needs the columns X1, X2, Y1, Y2 and --distance");
    if (test.ranges.empty()) test.missing.emplace_back("no temperature");
    if (test.interval > longest_interval) test.missing.emplace_back("values further apart than 5 min");
    if (test.environment) return;
    const bool stands = std::all_of(test.quantities.begin(), test.quantities.end(), [&](const Quantity& its) {
        return test.warmed >= 2 * hour &&
               range_in(its, test.warmed - hour, test.warmed) <=
                   settled * range_in(its, 0, hour) + (its.expanded > 0 ? its.expanded : 0);
    });
    if (test.warmed < wanted_time && !stands)
        test.missing.emplace_back(
            "a warm-up of less than 4 h whose last hour changes by more than 15 % of the first");
    if (test.cooled < hour) test.missing.emplace_back("no cool-down of an hour");
}

}  // namespace

GrowthGauges growth_gauges(const GrowthCourse& course, double distance) {
    GrowthGauges test;
    test.file = course.file;
    test.taken = course.taken;
    test.length = course.values.back().time - course.values.front().time;
    if (!(test.length > 0)) throw std::runtime_error(course.file + ": has one value. " + course.taken);
    for (std::size_t i = 1; i < course.values.size(); ++i)
        test.interval = std::max(test.interval, course.values[i].time - course.values[i - 1].time);
    for (int axis = 0; axis < 3; ++axis) {
        Quantity its = series(course, std::string(1, "XYZ"[axis]), "um",
                              [&](const GrowthCourse::Value& value) { return value.place[axis] * 1e3; });
        if (!its.samples.empty()) test.quantities.push_back(std::move(its));
    }
    // About Y, X rises with Z; about X, Y falls with Z.
    for (int axis = 1; axis >= 0 && distance > 0; --axis) {
        Quantity its =
            series(course, axis == 0 ? "tilt about Y" : "tilt about X", "um/m",
                   [&](const GrowthCourse::Value& value) {
                       return (axis == 0 ? 1 : -1) * (value.upper[axis] - value.place[axis]) / distance * 1e6;
                   });
        if (!its.samples.empty()) test.quantities.push_back(std::move(its));
    }
    find_spindle(course, test);
    for (Quantity& its : test.quantities) measure(its, test);
    for (const GrowthCourse::Sensor& sensor : course.sensors) {
        const auto [low, high] = range_of(sensor.samples);
        test.ranges.emplace_back(sensor.name, high - low);
    }
    compare_with_standard(test);
    return test;
}

}  // namespace plumb::commissioning
