// SPDX-License-Identifier: GPL-2.0-or-later
// The pins of the settings. read() reads them all; a copy of the settings keeps the last good ones.
#pragma once

#include "components/compensation/thermal_displacement/displacement_settings.hpp"
#include "components/compensation/thermal_displacement/growth_offset.hpp"
#include "hal/settings.hpp"

#include <cstddef>
#include <string>

namespace plumb {

// A member keeps its default as that of its pin.
struct BoundSettings : hal::Settings {
    using Settings::Settings;

protected:
    template <class T, class... Rest>
    void bind(T& member, const std::string& name, const Rest&... rest) {
        member = pin(member, name, member, rest...);
    }
};

struct DisplacementPins : BoundSettings, DisplacementSettings {
    explicit DisplacementPins(hal::Owner owner) : BoundSettings(owner) {
        constexpr hal::Range loads{1e-6, 1e3}, falls{0, 1e3}, times{0, 10}, long_times{0, 1e3},
            lengths{0, 1e3}, rates{0, 1}, cycles{1, 1e6}, growths{1e-6, 1}, unexplained{0, 1},
            scatters{1e-5, 1}, per_kelvin{0, 0.1}, ages{0, 1e6}, holds{1e-3, 1e6}, errors{1e-9, 1e3};
        bind(work_tolerance, "work-tolerance", "mu",
             "Error of the work along Z that matters: a larger one to expect is a doubt, half of it a shift.",
             hal::must(errors));
        bind(by_time, "by-time", "Compare the times of contacts, not their coordinates.", hal::machine());
        bind(program_clock, "clock-from-program",
             "The clock starts with the cycle and with clock-start, not at start-height.", hal::machine());
        for (std::size_t i = 0; i < excluded.size(); ++i)
            excluded[i] = unjudged(excluded[i], "exclude-operation-" + std::to_string(i), 0,
                                   "Key of an operation whose contacts are ignored; 0 for none.",
                                   hal::machine(hal::Range{0, 2147483647}));
        bind(threshold, "threshold", "%", "Rise of the load that is a contact.", hal::must(loads));
        bind(release, "release", "%", "Rise below which the tool has left the work.", hal::must(falls));
        bind(smoothing, "smoothing", "s", "Time constant of a filter on the load.", hal::must(times));
        bind(debounce, "debounce", "s", "Time that a rise must last to be a contact.", hal::must(times));
        bind(blanking_time, "blanking-time", "s",
             "Time for which a change of spindle speed disturbs the load.", hal::must(long_times));
        bind(load_latency, "load-latency", "s", "Age of the load, as of a serial line.", hal::must(times));
        bind(reference_cycles, "reference-cycles", "Number of cycles of which a reference is the mean.",
             hal::machine(cycles));
        bind(window, "window", "mu", "Largest distance of a contact from its reference, in this operation.",
             hal::expert(lengths));
        bind(max_growth_rate, "max-growth-rate", "mu/s", "Fastest growth to expect.", hal::machine(rates));
        bind(floor, "gate-floor", "mu", "Change of the growth that matters; 0.3 of it does no harm.",
             hal::must(lengths));
        bind(cap, "gate-cap", "mu", "Largest change of the growth to expect between two contacts.",
             hal::machine(lengths));
        bind(max_correction, "max-correction", "mu", "Largest change from one accepted contact to the next.",
             hal::expert(lengths));
        bind(by_speed, "follow-speed",
             "Between contacts the growth follows the speed; else the last contact holds.", hal::machine());
        bind(expected_growth, "expected-growth", "mu",
             "Growth of the spindle to expect at 5000 rpm, roughly.", hal::machine(growths));
        bind(unexplained_growth, "unexplained-growth", "mu",
             "Growth in an hour that the speed does not explain.", hal::machine(unexplained));
        bind(repeatability, "contact-repeatability", "mu",
             "Standard deviation of a contact by seat and blank.", hal::machine(scatters));
        bind(surface_repeatability, "surface-repeatability", "mu",
             "Standard deviation of the height of a fixed surface that is probed.", hal::machine(scatters));
        max_temperature_age = unjudged(max_temperature_age, "max-temperature-age", max_temperature_age, "s",
                                       "Age from which a temperature counts as lost.", hal::expert(ages));
        bind(temperature_growth, "temperature-growth", "mu/K",
             "Growth with temperature to expect either way, roughly.", hal::expert(per_kelvin));
        bind(hold_time, "hold-time", "s",
             "Time without a contact that counts, after which the offset returns to 0.", hal::expert(holds));
    }
};

struct OffsetPins : BoundSettings, GrowthOffset::Settings {
    explicit OffsetPins(hal::Owner owner) : BoundSettings(owner) {
        constexpr hal::Range steps{-1000, 1000}, lengths{0, 1000}, times{0, 1000}, rates{0, 1};
        bind(verify_step, "verify-step", "mu",
             "Displacement that shows which contacts are of the work, at most gate-cap; 0: none.",
             hal::machine(steps));
        bind(constant_in_part, "constant-in-part",
             "The offset changes only at the start of a cycle: an even part, whose error changes.",
             hal::machine());
        bind(tolerance, "tolerance", "mu", "Smallest change that is applied.", hal::machine(lengths));
        bind(time_tolerance, "time-tolerance", "s",
             "Smallest change that is applied by the time method, as a time.", hal::expert(times));
        bind(max_offset, "max-offset", "mu", "Largest offset either way.", hal::machine(lengths));
        bind(max_rate, "max-rate", "mu/s", "Fastest change of the offset.", hal::must(rates));
    }
};

}  // namespace plumb
