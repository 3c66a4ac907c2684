// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/stroke_motion.hpp"
#include "components/compensation/chopping/stroke_supervision.hpp"
#include "components/compensation/chopping/stroke_values.hpp"
#include "components/math/blocks/pi.hpp"
#include "hal/component.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

// The outputs that show a stroke.
struct StrokePins : hal::Group {
    using Group::Group;

    hal::Out<double> velocity{this, "velocity", "mu/s", "Velocity of the stroke, for a feed-forward."};
    hal::Out<double> acceleration{this, "acceleration", "mu/s2", "Acceleration of the stroke."};
    hal::Out<double> phase{this, "phase", "deg", "Phase: 0 at the lower, 180 at the upper dead point."};
    hal::Out<double> measured_phase{
        this, "measured-phase", "deg",
        "Phase by the measured position: 0 and 180 where the axis itself turns, or is expected to."};
    hal::Out<double> phase_lag{this, "phase-lag", "deg",
                               "Phase minus measured-phase, -180 to 180: how late the axis is."};
    hal::Out<bool> active{this, "active", "The axis strokes, or is on its way to the end, or the infeed is."};
    hal::Out<bool> stroking{this, "stroking", "The axis strokes, and nothing has ended its strokes."};
    hal::Out<bool> withdrawing{this, "withdrawing",
                               "The axis is on its way to position, by enable or go-to-end."};
    hal::Out<double> way_out_time{
        this, "way-out-time", "s",
        "Longest time until the axis is at a clear dead point, by its present speed."};
    hal::Out<bool> held{this, "held", "The axis stands for a hold."};
    hal::Out<bool> sparking_out{this, "sparking-out", "Spark-out strokes are under way."};
    hal::Out<bool> upper_pulse{this, "upper-pulse", "Infeed pulse at the upper dead point."};
    hal::Out<bool> lower_pulse{this, "lower-pulse", "Infeed pulse at the lower dead point."};
    hal::Out<std::int32_t> stroke_count{this, "stroke-count", "Strokes since the start; two are a cycle."};
    hal::Out<double> planned_cycle_time{this, "planned-cycle-time", "s", "Both strokes with their dwells."};
    hal::Out<double> actual_cycle_time{this, "actual-cycle-time", "s", "Time of the last cycle."};

    void show(const StrokeMotion& motion, const StrokeSupervision& supervision, const StrokeValues& values,
              bool moves) noexcept {
        const Oscillation& oscillation = motion.oscillation();
        const double its_phase = oscillation.phase(), seen_phase = supervision.phase().phase();
        velocity = motion.leading().velocity();
        acceleration = motion.leading().acceleration();
        phase = its_phase * (180 / pi);
        measured_phase = seen_phase * (180 / pi);
        phase_lag = std::remainder(its_phase - seen_phase, 2 * pi) * (180 / pi);
        active = moves;
        stroking = motion.state() == StrokeMotion::State::stroking;
        withdrawing = motion.state() == StrokeMotion::State::returning;
        way_out_time = oscillation.longest_way_out();
        held = motion.moves() && oscillation.held();
        sparking_out = motion.moves() && oscillation.sparking_out();
        upper_pulse = supervision.clock().pulse(true);
        lower_pulse = supervision.clock().pulse(false);
        stroke_count = oscillation.strokes();
        planned_cycle_time = oscillation.stroke_time(true) + oscillation.stroke_time(false) +
                             values.stroke.lower_dwell + values.stroke.upper_dwell;
        actual_cycle_time = supervision.clock().time();
    }
};

}  // namespace plumb
