// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/contact.hpp"
#include "components/compensation/thermal_displacement/growth_by_contact.hpp"
#include "components/compensation/thermal_displacement/growth_filter.hpp"
#include "components/compensation/thermal_displacement/growth_offset.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"

#include <algorithm>
#include <cmath>

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

// The growth between contacts: its settings by an integrator, and its estimate.
struct GrowthSettings : hal::Group {
    using Group::Group;

    void read(GrowthFilter::Settings& s, hal::SettingsReader& setting) noexcept {
        s.hold_time = setting(hold_time);
        s.work_tolerance = setting(work_tolerance);
        s.by_speed = follow_speed;
        s.expected_growth = setting(expected_growth);
        s.unexplained_growth = setting(unexplained_growth);
        s.repeatability = setting(contact_repeatability);
        s.temperature_growth = setting(temperature_growth);
    }

    bool temperature_usable() noexcept {
        const double age = temperature_age;
        return temperature_valid && age >= 0 && age <= max_temperature_age;
    }

    void show(double estimate, double sigma) noexcept {
        growth_estimate = estimate;
        growth_sigma = sigma;
    }

    static constexpr hal::Range growths{1e-6, 1}, unexplained{0, 1}, scatters{1e-5, 1}, per_kelvin{0, 0.1},
        ages{0, 1e6}, times{1e-3, 1e6}, errors{1e-9, 1e3};

    hal::In<bool> follow_speed{this, "follow-speed", true,
                               "Between contacts the growth follows the speed; else the last contact holds.",
                               hal::machine()};
    hal::In<double> expected_growth{this,
                                    "expected-growth",
                                    0.015,
                                    "mu",
                                    "Growth of the spindle to expect at 5000 rpm, roughly.",
                                    hal::machine(growths)};
    hal::In<double> unexplained_growth{this,
                                       "unexplained-growth",
                                       0.006,
                                       "mu",
                                       "Growth in an hour that the speed does not explain.",
                                       hal::machine(unexplained)};
    hal::In<double> contact_repeatability{this,
                                          "contact-repeatability",
                                          0.001,
                                          "mu",
                                          "Standard deviation of a contact by seat and blank.",
                                          hal::machine(scatters)};
    hal::In<bool> temperature_valid{this, "temperature-valid", false,
                                    "The growth is to follow temperature too, and it is good."};
    hal::In<double> temperature_age{this, "temperature-age", 0, "s", "Time since temperature was read."};
    hal::In<double> max_temperature_age{this,
                                        "max-temperature-age",
                                        60,
                                        "s",
                                        "Age from which a temperature counts as lost.",
                                        hal::expert(ages)};
    hal::In<double> temperature_growth{this,
                                       "temperature-growth",
                                       0.003,
                                       "mu/K",
                                       "Growth with temperature to expect either way, roughly.",
                                       hal::expert(per_kelvin)};
    hal::In<double> hold_time{this,
                              "hold-time",
                              1800,
                              "s",
                              "Time without a contact that counts, after which the offset returns to 0.",
                              hal::expert(times)};
    hal::In<double> work_tolerance{
        this,
        "work-tolerance",
        0.01,
        "mu",
        "Error of the work along Z that matters: a larger one to expect is a doubt, half of it a shift.",
        hal::machine(errors)};
    hal::Out<double> growth_estimate{this, "growth-estimate", "mu",
                                     "Growth now: by the model, or by the last accepted contact."};
    hal::Out<double> growth_sigma{this, "growth-sigma", "mu", "Standard deviation of growth-estimate."};
};

// How the offset follows the growth.
struct OffsetSettings : hal::Group {
    using Group::Group;

    struct Values {
        GrowthOffset::Settings offset;
        double time_tolerance = 0;  // s
        double verify_step = 0;     // mu

        // By the time method a change counts as a distance of the feed, too.
        GrowthOffset::Settings at(Method method, double feed) const noexcept {
            GrowthOffset::Settings its = offset;
            if (method == Method::time)
                its.tolerance = std::max(its.tolerance, std::abs(feed) * time_tolerance);
            return its;
        }
    };

    Values read(hal::SettingsReader& setting) noexcept {
        Values s;
        s.offset.tolerance = setting(tolerance);
        s.offset.max_offset = setting(max_offset);
        s.offset.max_rate = setting(max_rate);
        s.time_tolerance = setting(time_tolerance);
        s.verify_step = setting(verify_step);
        return s;
    }

    static constexpr hal::Range steps{-1000, 1000}, lengths{0, 1000}, times{0, 1000}, rates{0, 1};
    hal::In<bool> dry_run{this, "dry-run", false, "Compare and count, but never apply.", hal::must()};
    hal::In<bool> verify{
        this, "verify", false,
        "Displace the offset by verify-step in the next cycle, never for a part that counts.",
        hal::machine()};
    hal::In<double> verify_step{
        this,
        "verify-step",
        0,
        "mu",
        "Displacement that shows which contacts are of the work, at most gate-cap; 0: none.",
        hal::machine(steps)};
    hal::In<bool> constant_in_part{
        this, "constant-in-part", false,
        "The offset changes only at the start of a cycle: an even part, whose error changes.",
        hal::machine()};
    hal::In<double> tolerance{
        this, "tolerance", 0.002, "mu", "Smallest change that is applied.", hal::machine(lengths)};
    hal::In<double> time_tolerance{this,
                                   "time-tolerance",
                                   0,
                                   "s",
                                   "Smallest change that is applied by the time method, as a time.",
                                   hal::expert(times)};
    hal::In<double> max_offset{
        this, "max-offset", 0.15, "mu", "Largest offset either way.", hal::machine(lengths)};
    hal::In<double> max_rate{
        this, "max-rate", 0.01, "mu/s", "Fastest change of the offset.", hal::must(rates)};
    hal::Effects next_cycle{this,      hal::Effect::next_cycle, verify,    verify_step, constant_in_part,
                            tolerance, time_tolerance,          max_offset};
};

}  // namespace plumb
