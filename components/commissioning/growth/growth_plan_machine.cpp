// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/growth/growth_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "components/commissioning/growth/growth_identify.hpp"
#include "components/math/blocks/first_order_lag.hpp"

namespace plumb::commissioning {
namespace {

using Sensor = GrowthCourse::Sensor;

constexpr double step = 60;         // s
constexpr double least_rise = 1;    // K
constexpr double least_rest = 0.5;  // um

double warming_of(const Sensor& sensor) {
    const auto [low, high] = range_of(sensor.samples);
    return high - low;
}

// The part of the machine that warms least; the air stands for it if there is one part alone.
const Sensor& structure_of(const GrowthCourse& course) {
    const Sensor *least = nullptr, *air = nullptr;
    int parts = 0;
    for (const Sensor& sensor : course.sensors) {
        if (sensor.artifact) continue;
        if (sensor.name == GrowthIdentifyOptions().air) {
            air = &sensor;
            continue;
        }
        ++parts;
        if (!least || warming_of(sensor) < warming_of(*least)) least = &sensor;
    }
    if (parts < 2) least = air;
    if (!least)
        throw std::runtime_error(course.file +
                                 ": has one sensor; a plan needs the spindle and the structure");
    return *least;
}

// The rise of a temperature, in steps from the first value on, and the share of the highest speed there.
struct Rises {
    std::vector<double> share, rise;
};

template <class Temperature>
Rises rises_of(const GrowthCourse& course, double fastest, Temperature temperature) {
    Rises its;
    const double begin = course.values.front().time, cold = temperature(begin);
    for (double t = begin; t <= course.values.back().time; t += step) {
        its.share.push_back(std::abs(value_at(course.speeds, t)) / fastest);
        its.rise.push_back(temperature(t) - cold);
    }
    return its;
}

struct Fit {
    double rise = 0, turning = 0, stopped = 0, misfit = std::numeric_limits<double>::infinity();
};

// rise * lag(drive), by least squares; `drive` of a share of the speed.
template <class Drive>
void improve(Fit& best, const Rises& rises, double turning, double stopped, Drive drive) {
    FirstOrderLag lag;
    double ff = 0, fr = 0, rr = 0;
    for (std::size_t i = 0; i < rises.rise.size(); ++i) {
        const double share = rises.share[i];
        const double f = lag.step(drive(share), share > 0.001 ? turning : stopped, step);
        ff += f * f;
        fr += f * rises.rise[i];
        rr += rises.rise[i] * rises.rise[i];
    }
    if (!(ff > 0)) return;
    const double rise = fr / ff, misfit = rr - rise * fr;
    if (misfit < best.misfit) best = {rise, turning, stopped, misfit};
}

}  // namespace

GrowthPlanMachine plan_machine_of(const GrowthCourse& course, double fastest) {
    const auto refuse = [&](const std::string& why) { throw std::runtime_error(course.file + ": " + why); };
    if (course.speeds.empty()) refuse("has no spindle speed");
    const GrowthIdentified law = growth_identified({course});
    const Sensor& structure = structure_of(course);
    GrowthPlanMachine machine;
    machine.log = course.file;
    machine.artifact_known = course.expansion_out;
    double drift = 0;
    for (const GrowthIdentified::Axis& axis : law.axes) {
        if (!axis.probed || axis.drift <= drift) continue;
        drift = axis.drift;
        machine.rest = std::max(axis.rest * 1e3, least_rest);
    }
    Fit spindle;
    for (const Sensor& sensor : course.sensors) {
        if (sensor.name == structure.name || sensor.artifact) continue;
        const Rises rises = rises_of(course, fastest, [&](double t) {
            return value_at(sensor.samples, t) - value_at(structure.samples, t);
        });
        Fit its;
        for (const double turning : {300., 450., 600., 900., 1200., 1500., 2000., 2700., 3600.})
            for (const double ratio : {1., 1.5, 2., 3., 4.})
                improve(its, rises, turning, ratio * turning, [](double share) { return share; });
        if (std::abs(its.rise) > std::abs(spindle.rise)) spindle = its;
    }
    if (std::abs(spindle.rise) < least_rise) refuse("shows no sensor that the spindle warms");
    Fit whole;
    const Rises rises = rises_of(course, fastest, [&](double t) { return value_at(structure.samples, t); });
    for (const double time : {1500., 2100., 3000., 4200., 6000., 8400., 12000.})
        improve(whole, rises, time, time,
                [](double share) { return (share > 0.001 ? 0.5 : 0) + 0.5 * share; });
    machine.spindle_rise = spindle.rise;
    machine.turning_time = spindle.turning;
    machine.stopped_time = spindle.stopped;
    machine.structure_rise = whole.rise;
    machine.structure_time = whole.turning;
    return machine;
}

}  // namespace plumb::commissioning
