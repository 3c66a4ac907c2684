// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/growth_by_contact.hpp"
#include "hal/component.hpp"

#include <algorithm>

namespace plumb {

// How contacts are found, compared and accepted, as a machine's integrator sets it.
struct ContactSettings : hal::Group {
    using Group::Group;

    GrowthByContact::Settings read(hal::SettingsReader& setting) noexcept {
        GrowthByContact::Settings s;
        s.method = by_time ? Method::time : Method::coordinate;
        s.finder.program_clock = clock_from_program;
        std::copy(exclude.begin(), exclude.end(), s.finder.excluded.begin());
        s.finder.load_latency = setting(load_latency);
        s.reference_cycles = setting(reference_cycles);
        s.finder.contact.threshold = setting(threshold);
        s.finder.contact.release = setting(release);
        s.finder.contact.smoothing = setting(smoothing);
        s.finder.contact.debounce = setting(debounce);
        s.finder.contact.baseline_time = baseline_time;
        s.finder.contact.blanking_time = setting(blanking_time);
        s.limits.window = setting(window);
        s.limits.feed_tolerance = feed_tolerance;
        s.limits.feed_range = feed_range;
        s.limits.lost_time_tolerance = lost_time_tolerance;
        s.limits.steady_time = steady_time;
        s.growth.max_correction = setting(max_correction);
        s.growth.max_growth_rate = setting(max_growth_rate);
        s.growth.floor = setting(gate_floor);
        s.growth.cap = setting(gate_cap);
        return s;
    }

    // Of every load: a baseline that a plunge does not lift and a tool change does not leave behind.
    static constexpr double baseline_time = 0.5;  // s
    // A rounding of the feed is no other feed; one by half is fitted on too few points to compare.
    static constexpr double feed_tolerance = 0.02, feed_range = 0.5;
    // Two periods of LinuxCNC at 1 ms, by which its times of one program differ.
    static constexpr double lost_time_tolerance = 0.002;  // s
    // Ten samples of a load by a serial line, and longer than an axis accelerates.
    static constexpr double steady_time = 0.2;  // s

    static constexpr hal::Range loads{1e-6, 1e3}, falls{0, 1e3}, times{0, 10}, long_times{0, 1e3},
        lengths{0, 1e3}, growth_rates{0, 1}, cycles{1, 1e6};

    hal::In<bool> by_time{this, "by-time", false, "Compare the times of contacts, not their coordinates.",
                          hal::machine()};
    hal::In<bool> clock_from_program{
        this, "clock-from-program", false,
        "The clock starts with the cycle and with clock-start, not at start-height.", hal::machine()};
    hal::Row<hal::In<std::int32_t>, ContactFinder::Settings::exclusions> exclude{
        this, "exclude-operation", 0, "Key of an operation whose contacts are ignored; 0 for none.",
        hal::machine(hal::Range{0, 2147483647})};
    hal::In<double> threshold{
        this, "threshold", 1, "%", "Rise of the load that is a contact.", hal::must(loads)};
    hal::In<double> release{
        this, "release", 0.5, "%", "Rise below which the tool has left the work.", hal::must(falls)};
    hal::In<double> smoothing{
        this, "smoothing", 0.01, "s", "Time constant of a filter on the load.", hal::must(times)};
    hal::In<double> debounce{
        this, "debounce", 0.02, "s", "Time that a rise must last to be a contact.", hal::must(times)};
    hal::In<double> blanking_time{this,
                                  "blanking-time",
                                  2.5,
                                  "s",
                                  "Time for which a change of spindle speed disturbs the load.",
                                  hal::must(long_times)};
    hal::In<double> load_latency{
        this, "load-latency", 0, "s", "Age of the load, as of a serial line.", hal::must(times)};
    hal::In<std::int32_t> reference_cycles{this, "reference-cycles", 1,
                                           "Number of cycles of which a reference is the mean.",
                                           hal::machine(cycles)};
    hal::In<double> window{this,
                           "window",
                           0.5,
                           "mu",
                           "Largest distance of a contact from its reference, in this operation.",
                           hal::expert(lengths)};
    hal::In<double> max_growth_rate{this,   "max-growth-rate",           0.0002,
                                    "mu/s", "Fastest growth to expect.", hal::machine(growth_rates)};
    hal::In<double> gate_floor{this,
                               "gate-floor",
                               0.015,
                               "mu",
                               "Change of the growth that matters; 0.3 of it does no harm.",
                               hal::must(lengths)};
    hal::In<double> gate_cap{this,
                             "gate-cap",
                             0.06,
                             "mu",
                             "Largest change of the growth to expect between two contacts.",
                             hal::machine(lengths)};
    hal::In<double> max_correction{this,
                                   "max-correction",
                                   0.1,
                                   "mu",
                                   "Largest change from one accepted contact to the next.",
                                   hal::expert(lengths)};
};

}  // namespace plumb
