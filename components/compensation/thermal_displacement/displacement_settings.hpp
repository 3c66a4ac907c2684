// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <cstdint>

namespace plumb {

enum class Method { coordinate, time };

// How contacts are found, compared and accepted, and what growth to expect. DisplacementPins says more of
// each.
struct DisplacementSettings {
    bool by_time = false;
    bool program_clock = false;
    std::array<std::int32_t, 4> excluded{};  // keys of operations; 0 for none
    double threshold = 1;                    // %
    double release = 0.5;                    // %
    double smoothing = 0.01;                 // s
    double debounce = 0.02;                  // s
    double blanking_time = 2.5;              // s
    double load_latency = 0;                 // s
    std::int32_t reference_cycles = 1;
    double window = 0.5;              // mu
    double max_growth_rate = 0.0002;  // mu/s
    double floor = 0.015;             // mu
    double cap = 0.06;                // mu
    double max_correction = 0.1;      // mu
    bool by_speed = true;
    double expected_growth = 0.015;        // mu
    double unexplained_growth = 0.006;     // mu
    double repeatability = 0.001;          // mu
    double surface_repeatability = 0.002;  // mu
    double max_temperature_age = 60;       // s
    double temperature_growth = 0.003;     // mu/K
    double hold_time = 1800;               // s
    double work_tolerance = 0.01;          // mu

    // Of every load: a baseline that a plunge does not lift and a tool change does not leave behind.
    double baseline_time = 0.5;  // s
    // A rounding of the feed is no other feed; one by half is fitted on too few points to compare.
    double feed_tolerance = 0.02, feed_range = 0.5;  // parts of the feed, by time and by coordinate
    // Two periods of LinuxCNC at 1 ms, by which its times of one program differ.
    double lost_time_tolerance = 0.002;  // s
    // Ten samples of a load by a serial line, and longer than an axis accelerates.
    double steady_time = 0.2;  // s

    Method method() const noexcept { return by_time ? Method::time : Method::coordinate; }
    bool consistent() const noexcept { return release <= threshold && floor <= cap; }
};

}  // namespace plumb
