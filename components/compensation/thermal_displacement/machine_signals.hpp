// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/contact.hpp"
#include "components/compensation/thermal_displacement/growth_by_contact.hpp"
#include "components/math/blocks/edge.hpp"
#include "hal/component.hpp"

#include <cstdint>

namespace plumb {

// The signals of the machine and its program.
struct MachineSignals : hal::Group {
    using Group::Group;

    GrowthByContact::Sample read() noexcept {
        GrowthByContact::Sample s;
        s.learn = learn;
        s.cycle_running = cycle_running;
        s.cycle_complete = cycle_complete;
        s.motion = motion_type;
        s.tool = tool_number;
        s.operation = operation;
        s.load = load;
        s.load_valid = load_valid;
        s.speed = spindle_speed_cmd;
        s.z = z_position;
        s.velocity = z_velocity_cmd;
        s.feed_override = feed_override;
        s.motor_offset = z_motor_offset;
        s.start_height = start_height;
        s.clock_start = clock_start;
        s.applied_offset = applied_offset;
        s.work_offset = work_offset;
        s.tool_length = tool_length;
        return s;
    }

    hal::In<bool> learn{this, "learn", false, "Learn from the next cycle."};
    hal::In<bool> cycle_running{this, "cycle-running", false, "A cycle of the part program runs."};
    hal::In<bool> cycle_complete{this, "cycle-complete", false, "The cycle that ends was not aborted."};
    hal::In<double> load{this, "load", 0, "%", "Load of the spindle or Z motor, of its rating."};
    hal::In<bool> load_valid{this, "load-valid", true, "The sensor reports that load is valid."};
    hal::In<double> spindle_speed_cmd{this, "spindle-speed-cmd", 0, "rpm", "Commanded speed of the spindle."};
    hal::In<double> z_position{this, "z-position", 0, "mu", "Z by its encoder, offset included."};
    hal::In<double> z_velocity_cmd{this, "z-velocity-cmd", 0, "mu/s", "Speed of Z, negative to the work."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 2, "As in LinuxCNC: 1 rapid, 2 feed."};
    hal::In<double> feed_override{this, "feed-override", 1, "1", "Feed override in force."};
    hal::In<std::int32_t> tool_number{this, "tool-number", 0, "Tool in the spindle."};
    hal::In<std::int32_t> operation{this, "operation", 0, "Key of the operation; 0 for none."};
    hal::In<double> z_motor_offset{this, "z-motor-offset", 0, "mu",
                                   "Offset of the motor that z-position contains, found by homing."};
    hal::In<double> start_height{this, "start-height", 0, "mu",
                                 "Height of the joint at which the clock of this operation starts."};
    hal::In<bool> clock_start{this, "clock-start", false,
                              "With clock-from-program: a rising edge starts the clock again."};
    hal::In<double> applied_offset{this, "applied-offset", 0, "mu",
                                   "Offset that the stage adds to the Z origin."};
    hal::In<double> work_offset{this, "work-offset", 0, "mu", "Work offset of Z in force, with G92."};
    hal::In<double> tool_length{this, "tool-length", 0, "mu", "Tool length in force along Z, by G43."};
};

// The setup that a reference belongs to, and the conditions that are remembered with it.
struct ReferenceConditions : hal::Group {
    using Group::Group;

    MachiningSetup setup() const noexcept {
        MachiningSetup now;
        now.program = program_id;
        now.tool_set = tool_set_id;
        return now;
    }

    bool temperature_usable(double oldest) const noexcept {
        const double age = temperature_age;
        return temperature_valid && age >= 0 && age <= oldest;
    }
    bool acknowledges() noexcept { return acknowledging_.rises(acknowledge); }

    hal::In<std::int32_t> program_id{this, "program-id", 0, "Identifies the program and its version."};
    hal::In<std::int32_t> tool_set_id{this, "tool-set-id", 0,
                                      "Identifies the set of tools, as a checksum of the tool table."};
    hal::In<double> temperature{this, "temperature", 20, "degC", "Temperature to remember with a reference."};
    hal::In<std::int32_t> date{this, "date", 0, "YYYYMMDD to remember with a reference; 0 when not known."};
    hal::In<bool> acknowledge{
        this, "acknowledge", false,
        "A rising edge ends a refusal of the reference, and lets one part be made in spite of a "
        "doubt."};
    hal::In<bool> temperature_valid{this, "temperature-valid", false,
                                    "The growth is to follow temperature too, and it is good."};
    hal::In<double> temperature_age{this, "temperature-age", 0, "s", "Time since temperature was read."};

private:
    Edge acknowledging_;
};

}  // namespace plumb
