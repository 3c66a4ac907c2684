// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_observations.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/growth/growth_law.hpp"

namespace plumb::commissioning {
namespace {

constexpr double smoothing = 20;     // s, of axis_growth
constexpr double least_warming = 1;  // K
constexpr double lasts = 1800;       // s, for which a residual of slow growth lasts
constexpr int least_speeds = 3;      // that tell the exponent of the speed
constexpr int blocks = 5;            // into which a day is cut
constexpr std::size_t most_values = 1000;

GrowthSamples smoothed(const GrowthSamples& samples) {
    GrowthSamples result;
    FirstOrderLag lag(samples.front().second);
    double before = samples.front().first;
    for (const auto& [time, value] : samples) {
        if (time > before) lag.step(value, smoothing, time - before);
        before = time;
        result.emplace_back(time, lag.value());
    }
    return result;
}

// How many speeds the spindle has had for a tenth of the time each. Two show no exponent.
int speeds_of(const std::vector<GrowthCourse>& days) {
    std::map<int, double> times;  // by steps of a fifth
    double all = 0;
    for (const GrowthCourse& course : days)
        for (std::size_t i = 1; i < course.speeds.size(); ++i) {
            const auto& [time, speed] = course.speeds[i - 1];
            const double length = course.speeds[i].first - time, size = std::abs(speed);
            times[size < 1 ? -1 : static_cast<int>(std::lround(std::log(size) / std::log(1.2)))] += length;
            all += length;
        }
    return static_cast<int>(
        std::count_if(times.begin(), times.end(), [&](const auto& its) { return its.second >= 0.1 * all; }));
}

// The block of each value of a course: a fifth of its length.
std::vector<int> blocks_of(const std::vector<GrowthCourse::Value>& values) {
    const double begin = values.front().time, span = values.back().time - begin;
    std::vector<int> result;
    for (const auto& value : values)
        result.push_back(std::min(static_cast<int>((value.time - begin) / span * blocks), blocks - 1));
    return result;
}

// Values that follow each other within half an hour count as one observation.
std::vector<double> weights_of(const std::vector<GrowthCourse::Value>& values) {
    std::vector<double> result(values.size(), 0);
    for (std::size_t begin = 0, end = 0; begin < values.size(); begin = end) {
        while (end < values.size() && values[end].pass == values[begin].pass) ++end;
        const double gap = begin > 0             ? values[begin].time - values[begin - 1].time
                           : end < values.size() ? values[end].time - values[end - 1].time
                                                 : lasts;
        const double length = values[end - 1].time - values[begin].time;
        const double weight = std::min(1.0, (gap + length) / lasts) / static_cast<double>(end - begin);
        std::fill(result.begin() + static_cast<std::ptrdiff_t>(begin),
                  result.begin() + static_cast<std::ptrdiff_t>(end), weight);
    }
    return result;
}

[[noreturn]] void refuse(const GrowthCourse& course, const std::string& why) {
    throw std::runtime_error(course.file + ": " + why + (course.taken.empty() ? "" : ". " + course.taken));
}

void add_values(GrowthObservations& data, const GrowthCourse& course, std::size_t day, int& groups) {
    std::vector<GrowthCourse::Value> values;
    const double span = course.values.back().time - course.values.front().time;
    const bool dense = !course.places && course.values.size() > most_values;
    const double step = dense ? span / static_cast<double>(most_values) : 0;
    for (const auto& value : course.values)
        if (values.empty() || value.time >= values.back().time + step) values.push_back(value);
    std::set<int> passes;
    for (const auto& value : values) passes.insert(value.pass);
    if (passes.size() < 4)
        refuse(course, "has " + std::to_string(passes.size()) +
                           " passes; a law of temperatures needs four, and better eight");
    const std::vector<double> weights = weights_of(values);
    const std::vector<int> its_blocks = blocks_of(values);
    int last = groups;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto& value = values[i];
        for (int axis = 0; axis < 3; ++axis)
            data.measured[static_cast<std::size_t>(axis)] |= std::isfinite(value.place[axis]);
        data.values.push_back(
            {value.place, day, value.time, weights[i], groups + value.group, its_blocks[i]});
        last = std::max(last, groups + value.group + 1);
    }
    groups = last;
}

}  // namespace

GrowthObservations growth_observations(const std::vector<GrowthCourse>& days,
                                       const GrowthIdentifyOptions& options) {
    GrowthObservations data;
    data.places = days.front().places;
    // Friction depends on grease, preload and load: one day cannot show that it comes back on another.
    data.turned = days.size() > 1 && speeds_of(days) >= least_speeds;
    int groups = 0;
    for (std::size_t day = 0; day < days.size(); ++day) {
        if (days[day].places != data.places)
            refuse(days[day], "is of another kind than " + days.front().file +
                                  ": logs of growth_log and CSV files of gauges do not go together");
        add_values(data, days[day], day, groups);
        data.speeds.push_back(days[day].speeds);
        data.turned &= !days[day].speeds.empty();
    }
    const auto named = [](const GrowthCourse& course, const std::string& name) {
        return std::find_if(course.sensors.begin(), course.sensors.end(),
                            [&](const GrowthCourse::Sensor& sensor) { return sensor.name == name; });
    };
    for (const GrowthCourse& course : days)
        for (const std::string& wanted : options.sensors)
            if (named(course, wanted) == course.sensors.end())
                refuse(course, "there is no sensor '" + wanted + "'");
    bool warmed = false;
    for (const GrowthCourse::Sensor& first : days.front().sensors) {
        const auto& wanted = options.sensors;
        const bool chosen = wanted.empty()
                                ? !first.artifact
                                : std::find(wanted.begin(), wanted.end(), first.name) != wanted.end();
        if (!chosen && (!first.artifact || days.front().expansion_out)) continue;
        GrowthObservations::Sensor sensor{first.name, first.number, first.name == options.air, {}};
        for (const GrowthCourse& course : days) {
            const auto its = named(course, first.name);
            if (its == course.sensors.end())
                refuse(course, "has no sensor '" + first.name + "', which " + days.front().file + " has");
            sensor.days.push_back(smoothed(its->samples));
            const auto [low, high] = range_of(sensor.days.back());
            warmed |= chosen && high - low >= least_warming;
        }
        if (!chosen) {
            data.artifact = sensor;
            continue;
        }
        if (sensor.number >= GrowthLaw::sensors)
            refuse(days.front(), "sensor " + std::to_string(sensor.number + 1) +
                                     " is chosen; axis_growth reads the sensors 1 to 4");
        data.sensors.push_back(sensor);
    }
    if (!warmed && !data.turned)
        refuse(days.front(),
               "no sensor has warmed by 1 K: nothing shows the heat");
    return data;
}

std::pair<double, double> travel_of(const GrowthObservations& data, int axis) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const auto& value : data.values) {
        if (!std::isfinite(value.place[axis])) continue;
        low = std::min(low, value.place[axis]);
        high = std::max(high, value.place[axis]);
    }
    return {low, high};
}

}  // namespace plumb::commissioning
