// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_growth/growth_procedure.hpp"
#include "components/compensation/thermal_growth/growth_signals.hpp"
#include "components/math/blocks/delayed_bit.hpp"
#include "components/math/blocks/edge.hpp"
#include "hal/axes.hpp"
#include "hal/component.hpp"

#include <cmath>
#include <cstdint>

namespace plumb::growth_test {

// A state of the machine that the program wants and the control confirms.
class ConfirmedState {
public:
    // True while the control does not confirm the wanted state for longer than `patience`.
    bool late(bool wanted, bool is, double patience, double dt) noexcept {
        waited_ = wanted == is ? 0 : waited_ + dt;
        wanted_ = wanted;
        is_ = is;
        return waited_ > (patience >= 0 ? patience : 0);
    }
    bool wanted() const noexcept { return wanted_; }
    bool is() const noexcept { return is_; }
    bool confirmed() const noexcept { return wanted_ == is_; }

private:
    double waited_ = 0;
    bool wanted_ = false, is_ = false;
};

// The program of the test, and its probe.
struct Program : hal::Group {
    using Group::Group;

    hal::In<bool> running{this, "running", false, "The program of the test runs."};
    hal::In<bool> program_running{
        this, "program-running", true,
        "A program or an MDI command runs or is paused: net program-running of linuxcnc_alive."};
    hal::In<bool> program_paused{this, "program-paused", false, "A program is paused."};
    hal::In<bool> resumable{this, "resumable", false, "A test can be resumed: net resumable of growth_log."};
    hal::In<bool> resume{this, "resume", false, "Continue the restored test instead of a new one."};
    hal::In<double> gap{this, "gap", 0, "s",
                        "Time since the last record of the restored test; -1 when not known."};
    hal::In<bool> pass_running{this, "pass-running", false, "A pass over the bores runs."};
    hal::In<bool> at_bore{this, "at-bore", false, "A bore is probed."};
    hal::In<bool> measuring{this, "measuring", false, "The next touch of the probe counts."};
    hal::In<bool> cycle{this, "cycle", false, "A rising edge ends a cycle of the machine."};
    hal::In<double> bore_key{this, "bore-key", 0, "1", "Number of the bore, 1 to 16."};
    hal::In<bool> turned{this, "turned", false, "The table is at the second orientation, 180 deg."};
    hal::In<bool> probe{this, "probe", false, "The probe touches."};
    hal::In<bool> overtravel{this, "probe-overtravel", false, "The probe reports overtravel."};
    hal::In<bool> compensate{this, "compensate", false, "The program wants position compensation."};
    hal::In<bool> compensation_on{this, "compensation-on", false, "The control confirms compensation."};
    hal::In<bool> cool{this, "cool", false, "The program wants temperature control."};
    hal::In<bool> cooling_on{this, "cooling-on", false, "The control confirms temperature control."};
    hal::In<double> confirm_time{this, "confirm-time", 30, "s", "Longest time until a state is confirmed."};
    hal::In<double> max_pass_time{this, "max-pass-time", 3600, "s", "Longest pass; the machine cools in it."};
    hal::In<bool> acknowledge{this, "acknowledge", false, "A rising edge clears a fault of the past."};
    hal::In<double> spindle_speed{this, "spindle-speed", 0, "rpm", "Speed of the spindle, for the log."};

    Signals read(double dt) noexcept {
        Signals s;
        s.running = Bit::of(running_, running);
        s.pass = Bit::of(pass_, pass_running);
        s.bore = Bit::of(bore_, at_bore);
        s.measuring = Bit::of(measuring_, measuring);
        s.cycle = Bit::of(cycle_, cycle);
        s.probe = Bit::of(probe_, probe);
        s.resume = resume;
        s.gap = gap;
        s.bore_key = bore_key;
        s.max_pass_time = max_pass_time;
        s.turned = turned;
        s.overtravel = overtravel;
        s.spindle_speed = spindle_speed;
        running_now_ = s.running.now;
        gone_.step(running_now_ && !program_running, gone_time, 0, dt);
        paused_ = program_paused;
        resumable_ = resumable;
        acknowledges_ = acknowledging_.rises(acknowledge);
        const double patience = confirm_time;
        const bool late = compensation_.late(compensate, compensation_on, patience, dt);
        const bool late_cooling = cooling_.late(cool, cooling_on, patience, dt);
        unconfirmed_ = s.running.now && (late || late_cooling);
        s.compensated = compensation_.is();
        s.cooled = cooling_.is();
        s.confirmed = compensation_.confirmed() && cooling_.confirmed();
        return s;
    }

    // The program that runs the test has ended without saying so.
    bool is_gone() const noexcept { return gone_.value(); }
    bool runs() const noexcept { return running_now_; }
    bool is_paused() const noexcept { return paused_; }
    bool is_resumable() const noexcept { return resumable_; }
    bool acknowledges() const noexcept { return acknowledges_; }
    bool wants_compensation() const noexcept { return compensation_.wanted(); }
    bool wants_cooling() const noexcept { return cooling_.wanted(); }
    // For longer than confirm-time, while the test runs.
    bool unconfirmed() const noexcept { return unconfirmed_; }

private:
    static constexpr double gone_time = 1;  // s

    DelayedBit gone_;
    bool running_now_ = false, paused_ = false, resumable_ = false;
    Edge running_, pass_, bore_, measuring_, cycle_, probe_, acknowledging_;
    ConfirmedState compensation_, cooling_;
    bool acknowledges_ = false, unconfirmed_ = false;
};

// The sensors of temperature.
struct Temperatures : hal::Group {
    using Group::Group;

    hal::In<std::int32_t> sensors{this, "sensors", 0, "Number of temperature sensors, 0 to 8."};
    hal::Row<hal::In<double>, 8> value{this, "temperature", 20.0, "degC", "Temperature of this sensor."};
    hal::Row<hal::In<bool>, 8> valid{this, "temperature-valid", true, "The sensor reports that it is valid."};
    hal::Row<hal::In<double>, 8> age{this, "temperature-age", 0.0, "s", "Age of the temperature."};
    hal::Row<hal::In<bool>, 8> decides{this, "temperature-decides", true, "The stop rule reads this sensor."};
    hal::In<double> max_age{this, "max-age", 30, "s", "Largest age of a temperature."};
    hal::In<double> sample_time{this, "sample-time", 60, "s", "Time between two temperature records."};
    hal::In<std::int32_t> artifact{this, "artifact-sensor", -1, "Sensor of the artifact; -1 for none."};
    hal::In<double> artifact_low{this, "artifact-low", 10, "degC", "Lowest temperature of the artifact."};
    hal::In<double> artifact_high{this, "artifact-high", 35, "degC", "Highest temperature of the artifact."};

    void read(Warmth& r) noexcept {
        r.good = r.artifact_good = true;
        r.decides = 0;
        r.sample_time = sample_time;
        const std::int32_t wanted = sensors;
        r.count = wanted < 0 ? 0 : wanted > 8 ? 8 : wanted;
        r.good = wanted == r.count;
        const double oldest = max_age;
        for (std::size_t i = 0; i < 8; ++i) {
            const double now = value[i], since = age[i];
            const bool fine = valid[i] && now > -100 && now < 500 && since >= 0 && since <= oldest;
            const bool used = static_cast<int>(i) < r.count;
            r.value[i] = used && fine ? now : NAN;
            r.age[i] = std::abs(since) <= 1e6 ? since : 1e6;
            if (used && decides[i]) r.decides |= 1U << i;
            if (used && !fine) r.good = false;
        }
        const std::int32_t its = artifact;
        if (its >= 0 && its < r.count) {
            const double now = r.value[static_cast<std::size_t>(its)];
            r.artifact_good = !std::isfinite(now) || (now >= artifact_low && now <= artifact_high);
        }
    }
};

// When the machine is warm.
struct StopSettings : hal::Group {
    using Group::Group;

    hal::In<double> threshold{this, "threshold", 0.5, "K",
                              "Largest change of a temperature in the interval."};
    hal::In<double> interval{this, "interval", 3600, "s", "Interval of the threshold; 0 for one cycle."};
    hal::In<double> minimum_time{this, "minimum-time", 14400, "s", "The test does not pass before."};
    hal::In<double> maximum_time{this, "maximum-time", 43200, "s", "The test ends then in any case."};
    hal::In<bool> by_displacement{this, "by-displacement", true, "The displacements must stand, too."};
    hal::In<double> range_share{this, "range-share", 0.15, "1",
                                "Range of a displacement in the last hour, of that in the first."};
    hal::In<double> range_floor{this, "range-floor", 0.002, "mu", "A range this small is always accepted."};
    hal::In<double> uncertainty{this, "position-uncertainty", 0.0007, "mu",
                                "Standard uncertainty of a displacement; four of it are accepted."};
    hal::In<double> most_scatter{this, "max-scatter", 0.01, "mu",
                                 "Largest scatter of the touches of a bore about its circle."};
    hal::In<double> most_change{this, "max-shape-change", 0.004, "mu",
                                "Largest change of oval and radius of a bore since its first visit."};
    hal::In<double> farthest{this, "max-displacement", 0.5, "mu",
                             "Farthest that a bore may be from its place in the first pass."};
    hal::In<double> most_step{this, "max-step", 0.1, "mu",
                              "Largest displacement of a bore since its last pass."};
    hal::In<double> most_slip{this, "max-slip", 0.03, "mu",
                              "Largest part of this displacement that the other bores do not share."};
    hal::In<double> least_slip{this, "min-slip", 0.01, "mu",
                               "Smallest slip of the whole artifact that is reported."};
    hal::In<double> least_rise{this, "least-rise", 0.5, "K",
                               "Least rise of a machine that has warmed; 0 if it only stands."};

    GrowthTest::Settings read() const noexcept {
        GrowthTest::Settings s;
        s.stop.threshold = threshold;
        s.stop.interval = interval;
        s.stop.minimum_time = minimum_time;
        s.stop.maximum_time = maximum_time;
        s.stop.by_displacement = by_displacement;
        s.stop.range_share = range_share;
        s.stop.range_floor = range_floor;
        s.stop.uncertainty = uncertainty;
        s.most_scatter = most_scatter;
        s.most_change = most_change;
        s.farthest = farthest;
        s.most_step = most_step;
        s.most_slip = most_slip;
        s.least_slip = least_slip;
        s.least_rise = least_rise;
        return s;
    }
};

// The position of the machine, and the compensation that it contains.
struct Machine : hal::Group {
    using Group::Group;

    hal::Axes<hal::In<double>, 3> position{this, "%-position", 0.0, "mu",
                                           "Position of % by its encoder, compensation included."};
    hal::Axes<hal::In<double>, 3> offset{this, "%-offset", 0.0, "mu",
                                         "Compensation contained in %-position."};
    hal::Axes<hal::In<double>, 3> velocity{this, "%-velocity", 0.0, "mu/s", "Velocity of %."};
    hal::In<double> table_position{this, "table-position", 0, "deg", "Position of the table or trunnion."};
    hal::In<double> table_0{this, "table-0", 0, "deg", "Its position for the orientation 0."};
    hal::In<double> table_180{this, "table-180", 180, "deg", "Its position for the other orientation."};
    hal::In<double> table_tolerance{this, "table-tolerance", 0.01, "deg",
                                    "Largest error of the orientation."};
    hal::In<bool> table{this, "table", false, "The machine has a table or trunnion; check its position."};

    void read(Position& r) noexcept {
        r.good = true;
        for (std::size_t i = 0; i < 3; ++i) {
            r.position[i] = position[i];
            r.offset[i] = offset[i];
            r.velocity[i] = velocity[i];
            for (const double value : {r.position[i], r.offset[i], r.velocity[i]})
                if (!(std::abs(value) <= 1e6)) r.good = false;
        }
    }

    // Whether the table is where the program wants it.
    bool oriented(bool turned) const noexcept {
        const double wanted = turned ? table_180 : table_0;
        return !table || std::abs(std::remainder(table_position - wanted, 360)) <= table_tolerance;
    }
};

}  // namespace plumb::growth_test
