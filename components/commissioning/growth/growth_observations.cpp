// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_observations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

#include "components/math/growth/growth_law.hpp"

namespace plumb::commissioning {
namespace {

constexpr double least_warming = 1;  // K
constexpr double lasts = 1800;       // s, for which a residual of slow growth lasts
constexpr int least_speeds = 3;      // that tell the exponent of the speed
constexpr int duties = 5;            // into which the course is cut
constexpr std::size_t most_values = 250;

double range_of(const GrowthCourse::Sensor& sensor) {
    const auto [low, high] =
        std::minmax_element(sensor.samples.begin(), sensor.samples.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; });
    return high->second - low->second;
}

// How many speeds the spindle has had for a tenth of the time each. Two show no exponent.
int speeds_of(const GrowthCourse& course) {
    std::map<int, double> times;  // by steps of a fifth
    double all = 0;
    for (std::size_t i = 1; i < course.speeds.size(); ++i) {
        const auto& [time, speed] = course.speeds[i - 1];
        const double length = course.speeds[i].first - time, size = std::abs(speed);
        times[size < 1 ? -1 : static_cast<int>(std::lround(std::log(size) / std::log(1.2)))] += length;
        all += length;
    }
    return static_cast<int>(
        std::count_if(times.begin(), times.end(), [&](const auto& its) { return its.second >= 0.1 * all; }));
}

// The sensor from which the others differ least: of the body that most of them share.
std::size_t most_typical(const GrowthObservations& data) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < data.sensors.size(); ++i) {
        std::vector<double> distances;
        for (std::size_t j = 0; j < data.sensors.size(); ++j) {
            if (i == j) continue;
            double mean = 0, square = 0;
            for (const auto& value : data.values) {
                const double d = value_at(data.sensors[i].samples, value.time) -
                                 value_at(data.sensors[j].samples, value.time);
                mean += d, square += d * d;
            }
            const auto count = static_cast<double>(data.values.size());
            distances.push_back(std::sqrt(std::max(0.0, square / count - std::pow(mean / count, 2))));
        }
        const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
        std::nth_element(distances.begin(), middle, distances.end());
        // Of two the one that moves less.
        const double size = *middle + 1e-3 * range_of(data.sensors[i]);
        if (size >= least) continue;
        least = size;
        best = i;
    }
    return best;
}

// Stretches of the course, cut where the speed changes.
void cut_into_duties(GrowthObservations& data) {
    const double begin = data.values.front().time, span = data.values.back().time - begin;
    double since = begin, before = begin;
    int duty = 0;
    for (const auto& value : data.values) {
        const auto changes = [&] {
            double last = std::numeric_limits<double>::quiet_NaN();
            for (const auto& [time, speed] : data.course->speeds) {
                if (time > value.time) break;
                if (time > before && std::abs(speed - last) > 0.1 * std::abs(last)) return true;
                last = speed;
            }
            return false;
        };
        const double length = value.time - since;
        const bool apart = value.time > before;
        if (apart && (length >= span / duties || (length >= 0.8 * span / duties && changes()))) {
            ++duty;
            since = value.time;
        }
        before = value.time;
        data.duty.push_back(duty);
    }
}

void weigh(GrowthObservations& data) {
    const auto count = data.values.size();
    data.weight.assign(count, 0);
    for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
        while (end < count && data.values[end].pass == data.values[begin].pass) ++end;
        const double gap = begin > 0 ? data.values[begin].time - data.values[begin - 1].time : lasts;
        const double length = data.values[end - 1].time - data.values[begin].time;
        const double weight = std::min(1.0, (gap + length) / lasts) / static_cast<double>(end - begin);
        for (std::size_t i = begin; i < end; ++i) data.weight[i] = weight;
    }
}

}  // namespace

GrowthObservations growth_observations(const GrowthCourse& course, const GrowthIdentifyOptions& options) {
    const auto refuse = [&](const std::string& why) { throw std::runtime_error(course.file + ": " + why); };
    GrowthObservations data;
    data.course = &course;
    data.values = course.values;
    if (!course.places && data.values.size() > most_values) {
        data.values.clear();
        const double step =
            (course.values.back().time - course.values.front().time) / static_cast<double>(most_values);
        for (const auto& value : course.values)
            if (data.values.empty() || value.time >= data.values.back().time + step)
                data.values.push_back(value);
    }
    std::set<int> passes;
    for (const auto& value : data.values) {
        passes.insert(value.pass);
        for (int axis = 0; axis < 3; ++axis)
            data.measured[static_cast<std::size_t>(axis)] |= std::isfinite(value.place[axis]);
    }
    if (passes.size() < 4)
        refuse("has " + std::to_string(passes.size()) +
               " passes; a law of temperatures needs four, and better eight");
    data.cold = data.values.front().time;
    data.turned = options.speed && speeds_of(course) >= least_speeds;
    for (const GrowthCourse::Sensor& sensor : course.sensors) {
        const bool is_artifact = sensor.name == options.artifact;
        const auto& wanted = options.sensors;
        const bool chosen = wanted.empty()
                                ? !is_artifact
                                : std::find(wanted.begin(), wanted.end(), sensor.name) != wanted.end();
        if (is_artifact && !chosen && !course.expansion_out) data.artifact = sensor;
        if (!chosen) continue;
        if (sensor.number >= GrowthLaw::sensors)
            refuse("sensor " + std::to_string(sensor.number + 1) +
                   " is chosen; axis_growth reads the sensors 1 to 4");
        data.sensors.push_back(sensor);
    }
    const auto there = [&](const std::string& name) {
        const bool found =
            std::any_of(course.sensors.begin(), course.sensors.end(),
                        [&](const GrowthCourse::Sensor& sensor) { return sensor.name == name; });
        if (!found) refuse("there is no sensor '" + name + "'");
    };
    for (const std::string& wanted : options.sensors) there(wanted);
    const bool warmed =
        std::any_of(data.sensors.begin(), data.sensors.end(),
                    [](const GrowthCourse::Sensor& sensor) { return range_of(sensor) >= least_warming; });
    if (!warmed && !data.turned)
        refuse("no sensor has warmed by 1 K, and there is no spindle speed: nothing shows the heat");
    if (options.structure.empty() ? data.sensors.size() > 1 : options.structure != "none") {
        if (!options.structure.empty()) there(options.structure);
        auto its = data.sensors.begin();
        if (options.structure.empty())
            its += static_cast<std::ptrdiff_t>(most_typical(data));
        else
            its = std::find_if(
                data.sensors.begin(), data.sensors.end(),
                [&](const GrowthCourse::Sensor& sensor) { return sensor.name == options.structure; });
        if (its == data.sensors.end()) refuse("the sensor '" + options.structure + "' was not chosen");
        data.structure = *its;
        data.sensors.erase(its);
    }
    weigh(data);
    cut_into_duties(data);
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
