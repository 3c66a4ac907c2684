// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/oscillation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace plumb {

using Stop = Oscillation::Stop;
using State = Oscillation::State;

inline constexpr double dt = 0.001;
inline constexpr double nm = 1e-6;  // mm
inline constexpr std::size_t nodes = 32;

inline Oscillation::Settings usual() {
    Oscillation::Settings settings;
    settings.lower = 10;
    settings.upper = 40;
    settings.speed = 100;
    settings.acceleration = 1000;
    settings.largest_speed = 500;
    settings.lowest = -1000;
    settings.highest = 1000;
    settings.end_position = 50;
    settings.upward_first = true;
    return settings;
}

// An oscillation that is watched: its samples never break the acceleration, and stay where they may be.
struct Watched {
    explicit Watched(const Oscillation::Settings& its, double position = 50) : settings(its) {
        it.start(settings, position);
        samples.assign(3, position);
    }

    void step() {
        it.set(settings);
        it.see_axis(there());
        it.step(dt, hold, nodes, [this](bool upper, double, double, double) { return offset[upper]; });
        const std::size_t n = samples.size();
        samples.push_back(it.position());
        hardest = std::max(hardest, std::abs(samples[n] - 2 * samples[n - 1] + samples[n - 2]) / (dt * dt));
        if (it.arrival().happened) arrivals.push_back(it.arrival());
        late |= it.late();
        if (it.state() == State::stroke) lowest = std::min(lowest, it.position());
    }
    void run(double seconds) {
        for (int i = 0; i < seconds / dt; ++i) step();
    }
    void until(const std::function<bool()>& condition) {
        for (int i = 0; i < 100000; ++i) {
            if (condition()) return;
            step();
        }
        FAIL() << "never";
    }
    void stop(Stop kind) { it.stop(kind); }

    Oscillation::Settings settings;
    Oscillation it;
    std::function<bool()> there = [] { return true; };  // of the axis, at an exact stop
    Stop hold = Stop::none;
    bool late = false;
    double offset[2] = {0, 0};
    std::vector<double> samples;
    std::vector<Oscillation::Arrival> arrivals;
    double hardest = 0, lowest = 1e9;
};

}  // namespace plumb
