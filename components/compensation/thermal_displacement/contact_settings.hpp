// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/growth_by_contact.hpp"
#include "hal/component.hpp"

#include <algorithm>

namespace plumb {

// How contacts are found, compared and accepted, as a machine's integrator sets it.
struct ContactSettings : hal::Group {
    using Group::Group;

    GrowthByContact::Settings read() noexcept {
        GrowthByContact::Settings s;
        s.method = by_time ? Method::time : Method::coordinate;
        s.finder.program_clock = clock_from_program;
        std::copy(exclude.begin(), exclude.end(), s.finder.excluded.begin());
        s.finder.load_latency = load_latency;
        s.reference_cycles = reference_cycles;
        s.finder.contact.threshold = threshold;
        s.finder.contact.release = release;
        s.finder.contact.smoothing = smoothing;
        s.finder.contact.debounce = debounce;
        s.finder.contact.baseline_time = baseline_time;
        s.finder.contact.blanking_time = blanking_time;
        s.limits.window = window;
        s.limits.feed_tolerance = feed_tolerance;
        s.limits.feed_range = feed_range;
        s.limits.lost_time_tolerance = lost_time_tolerance;
        s.growth.max_correction = max_correction;
        s.limits.steady_time = steady_time;
        s.growth.gate.max_growth_rate = max_growth_rate;
        s.growth.gate.floor = gate_floor;
        s.growth.gate.cap = gate_cap;
        s.growth.gate.confirm = confirm_contacts;
        return s;
    }

    hal::In<bool> by_time{this, "by-time", false, "Compare the times of contacts, not their coordinates."};
    hal::In<bool> clock_from_program{
        this, "clock-from-program", false,
        "The clock starts with the cycle and with clock-start, not at start-height."};
    hal::Row<hal::In<std::int32_t>, 8> exclude{this, "exclude-operation", 0,
                                               "Key of an operation whose contacts are ignored; 0 for none."};
    hal::In<double> threshold{this, "threshold", 1, "%", "Rise of the load that is a contact."};
    hal::In<double> release{this, "release", 0.5, "%", "Rise below which the tool has left the work."};
    hal::In<double> smoothing{this, "smoothing", 0.01, "s", "Time constant of a filter on the load."};
    hal::In<double> debounce{this, "debounce", 0.02, "s", "Time that a rise must last to be a contact."};
    hal::In<double> baseline_time{this, "baseline-time", 0.5, "s", "Time constant of the running baseline."};
    hal::In<double> blanking_time{this, "blanking-time", 2.5, "s",
                                  "Time for which a change of spindle speed disturbs the load."};
    hal::In<double> load_latency{this, "load-latency", 0, "s", "Age of the load, as of a serial line."};
    hal::In<std::int32_t> reference_cycles{this, "reference-cycles", 1,
                                           "Number of cycles of which a reference is the mean."};
    hal::In<double> window{this, "window", 0.5, "mu",
                           "Largest distance of a contact from its reference, in this operation."};
    hal::In<double> feed_tolerance{this, "feed-tolerance", 0.02, "1",
                                   "Largest difference of feed and override from the reference, as a part."};
    hal::In<double> feed_range{this, "feed-range", 0.5, "1",
                               "By coordinate: difference beyond it that is compared, with less certainty."};
    hal::In<double> lost_time_tolerance{this, "lost-time-tolerance", 0.002, "s",
                                        "By time: largest difference of the lost time from the reference."};
    hal::In<double> steady_time{this, "steady-time", 0.2, "s",
                                "Time of steady feed that a contact needs after a hold."};
    hal::In<double> max_growth_rate{this, "max-growth-rate", 0.0002, "mu/s",
                                    "Fastest growth to expect; the gate opens with it."};
    hal::In<double> gate_floor{this, "gate-floor", 0.015, "mu", "Narrowest gate."};
    hal::In<double> gate_cap{this, "gate-cap", 0.06, "mu", "Widest gate."};
    hal::In<std::int32_t> confirm_contacts{this, "confirm-contacts", 0,
                                           "Further contacts that confirm one beyond the gate; 0 for never."};
    hal::In<double> max_correction{this, "max-correction", 0.1, "mu",
                                   "Largest change from one accepted contact to the next."};
};

}  // namespace plumb
