// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/compensation/chopping/chopping_settings.hpp"
#include "components/compensation/chopping/chopping_status.hpp"
#include "components/compensation/chopping/dead_point_pins.hpp"
#include "components/compensation/chopping/infeed_pins.hpp"
#include "components/compensation/chopping/learned_row.hpp"
#include "components/compensation/chopping/stroke_pins.hpp"
#include "components/compensation/chopping/stroking_axis.hpp"
#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/offset.hpp"
#include "hal/records.hpp"
#include "pages/chopping.page.hpp"

#include <cmath>
#include <cstdint>
#include <string>

namespace plumb {

struct Chopping final : hal::Component {
    static constexpr hal::About about{
        "chopping", "strokes an axis between two dead points, while others follow a contour", page,
        "Chopping"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::In<bool> run{this, "run", false, "A rising edge starts strokes; false stops them."};
    hal::In<bool> stop{this, "stop", false,
                       "True ends strokes as run false does, and refuses a start: for a button."};
    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock,
                               "Strokes are permitted; false withdraws the axis to position.", true};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> homed{this, "homed", false, "The joint is homed."};
    hal::In<bool> feed_hold{this, "feed-hold", false, "Stand where hold-kind selects, and go on when false."};
    hal::In<bool> emergency_hold{this, "emergency-hold", false,
                                 "Brake at once and stand within the region, also amid a stroke, where a "
                                 "wheel in contact marks the work."};
    hal::In<bool> go_to_end{this, "go-to-end", false,
                            "A rising edge moves the axis to position, and ends strokes."};
    hal::In<bool> shift{this, "shift", false, "Each change takes over the dead points while stroking."};
    hal::In<bool> shift_at_crossing{this, "shift-at-crossing", false,
                                    "A crossing of crossing-at takes over the dead points, too.",
                                    hal::machine()};
    hal::In<double> crossing_position{this, "crossing-position", 0, "mu", "Position of the crossing axis."};
    hal::In<double> crossing_at{this,
                                "crossing-at",
                                0,
                                "mu",
                                "Coordinate that it crosses, either way.",
                                hal::machine(ChoppingSettings::places)};
    hal::In<bool> program_running{this, "program-running", false,
                                  "A part program runs, not an MDI command. Strokes that it began end "
                                  "when it becomes false, others when it becomes true."};
    hal::In<bool> outlast{this, "outlast", false,
                          "Strokes go on when their program ends, and when another one begins.",
                          hal::machine()};
    hal::In<double> position{this, "position", 0, "mu",
                             "Commanded position of the joint, point R: joint.N.pos-cmd."};
    hal::In<double> joint_velocity{this, "joint-velocity", 0, "mu/s",
                                   "Commanded velocity of the joint, for command-velocity: joint.N.vel-cmd."};
    hal::In<double> joint_feedback{this, "joint-feedback", 0, "mu",
                                   "Measured position of the joint, without the offset: joint.N.pos-fb."};
    hal::In<double> motor_feedback{
        this, "motor-feedback", 0, "mu",
        "Position by the encoder of the motor, beside a scale at joint-feedback; its frame does not matter."};
    hal::In<double> applied_offset{this, "applied-offset", 0, "mu",
                                   "Offset that joint-feedback lacks: offset, with joint_offset; 0 for an "
                                   "extra joint."};
    hal::In<bool> stage_limited{this, "stage-limited", false, "The stage does not apply the whole offset."};
    hal::In<std::int32_t> stage_released{
        this, "stage-released", -1,
        "Net released of joint_offset: with 1, machine off has made the offset "
        "part of position; -1 without such a stage."};
    hal::In<bool> spindle_on{this, "spindle-on", true, "The spindle of the wheel is on: spindle.0.on."};
    hal::In<bool> spindle_at_speed{this, "spindle-at-speed", true,
                                   "The spindle turns at its speed: the signal at spindle.0.at-speed."};
    hal::In<double> program_word{this, "program-word", 0, "1",
                                 "Number of a word of the program, whose value is program-value; each change "
                                 "takes it. chop_numbers.ngc has the numbers."};
    hal::In<double> program_value{this, "program-value", 0, "1",
                                  "Value of this word, in machine units or s."};
    hal::Count sections{this,
                        "sections",
                        0,
                        0,
                        SpeedSections::most,
                        "Number of sections by pins, 0 to 4: the rows section-N-...; a program has its own."};
    ChoppingSettings settings{this, sections};

    hal::Out<double> offset{this, "offset", "mu", "For the stage of the joint."};
    hal::Out<double> command{this, "command", "mu",
                             "Position with the offset: joint.N.posthome-cmd, or for other functions."};
    hal::Out<double> command_velocity{this, "command-velocity", "mu/s",
                                      "Velocity of joint and stroke together, for other functions."};
    hal::Out<bool> at_end{this, "at-end", "The axis rests at position, and the offset is 0."};
    hal::Out<bool> place_known{
        this, "place-known",
        "The command of an extra joint is where its axis stands; false must keep its drive off."};
    hal::Out<bool> stands_off{
        this, "stands-off",
        "Machine off has ended strokes, and the axis has not been at their point R since: "
        "position is where it stood."};
    hal::Out<double> stands_off_by{this, "stands-off-by", "mu",
                                   "Position minus the point R of those strokes while stands-off is true, or "
                                   "0, for a display."};
    hal::Out<bool> program_refused{this, "program-refused",
                                   "The last word of the program is invalid, or the stroke that it checks."};
    hal::Out<std::int32_t> program_sections{this, "program-sections", "Sections that the program gave."};
    hal::Out<bool> feed_wait{
        this, "feed-wait",
        "Moves of a program have to wait: strokes end that no program orders any more, or "
        "a fault has stopped the axis away from position."};
    hal::Out<double> end_position{
        this, "end-position", "mu",
        "Point R, where strokes end, for a display: position at its last good value."};
    hal::Out<double> measured_position{this, "measured-position", "mu",
                                       "Measured position of the axis, with the offset."};
    StrokePins stroke{this};
    DeadPointPins dead_points{this};
    hal::Records records{this};
    LearnedRow row{this};
    hal::Codes<Bound> limited{this, "limited", "A bound is active; limited-code gives it."};
    hal::Count infeeds{this, "infeed", 0, 0, 1, "1 with an infeed by another axis, else 0."};
    InfeedPins infeed{this, infeeds, limited.active()};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Status<ChoppingStatus> status{this, permission};

    hal::Offset moves{this, hal::MovingPin(offset)
                                .bound(settings.max_offset)
                                .follows_while(stroke.active)
                                .rate(settings.max_rate)
                                .acceleration(settings.max_acceleration, StrokingAxis::guard_factor)
                                .undriven(motion_enabled, homed)
                                .limited(limited.active())};

    hal::Effects withholds{this, hal::Effect::withholds, go_to_end};
    hal::Effects at_once{this, hal::Effect::at_once, run};

    hal::Function update_function{this, "update", &Chopping::update, hal::Place::source};

    void prepare() override { axis_.begin(settings.read(), 1 / unit.millimetres()); }

    void update(double dt) noexcept {
        permission.step();
        const StrokingAxis::Inputs inputs = judged();
        take_records();
        Infeed::Settings its_infeed = infeed.read();
        const StrokeValues values = settings.read();
        its_infeed.taper = values.taper;
        axis_.step(inputs, values, dt, its_infeed);
        show(inputs);
        permission.report({axis_.moves(), false, axis_.busy(), false});
    }

private:
    StrokingAxis::Inputs judged() noexcept {
        StrokingAxis::Inputs its;
        its.orders = {run,
                      stop,
                      permission.enabled(),
                      go_to_end,
                      shift,
                      shift_at_crossing,
                      program_running,
                      outlast,
                      crossing_position,
                      crossing_at,
                      StrokingAxis::farthest};
        its.feed_hold = feed_hold;
        // Somebody has let go of the button, or the program has died.
        const bool untried = permission.reason() == hal::Common::uncommissioned ||
                             permission.reason() == hal::Common::stage_uncommissioned;
        its.emergency_hold = emergency_hold;
        its.trial_over = untried && !its.orders.enable;
        its.on = motion_enabled;
        its.homed = homed;
        its.spindle_on = spindle_on;
        its.at_speed = spindle_at_speed;
        its.stage_limited = stage_limited;
        const std::int32_t released = stage_released;
        its.releasable = released >= 0;
        its.released = released == 1 && !its.on;
        its.position = position;
        its.joint = joint_feedback;
        its.applied = applied_offset;
        const double motor = motor_feedback;
        motor_ = usable(motor, StrokingAxis::farthest, motor_);
        its.motor = motor_;
        its.word = program_word;
        its.word_value = program_value;
        its.infeed = infeed.inputs();
        return its;
    }

    void take_records() noexcept {
        DeadPointLearning& learning = axis_.learning();
        if (records.wants_forget()) axis_.forget();
        if (records.wants_restore()) records.restored(learning.restore(row.given()));
    }

    void show(const StrokingAxis::Inputs& inputs) noexcept {
        offset = axis_.offset();
        command = axis_.command();
        const double rate = joint_velocity;
        command_velocity =
            (std::abs(rate) <= StrokingAxis::farthest ? rate : 0) + axis_.motion().leading().velocity();
        feed_wait = axis_.busy();
        end_position = axis_.position();
        measured_position = axis_.measured();
        at_end = axis_.at_end();
        place_known = axis_.place_known();
        stands_off = axis_.stands_off();
        stands_off_by = axis_.stands_off_by();
        program_refused = axis_.refused();
        program_sections = static_cast<std::int32_t>(axis_.words().sections());
        stroke.show(axis_.motion(), axis_.supervision(), axis_.values(), axis_.moves());
        infeed.show(axis_.infeed());
        dead_points.show(axis_.supervision(), axis_.values());
        const LearnedStrokes& strokes = axis_.learning().strokes();
        records.show(strokes.size(), [&](std::int32_t i) noexcept { row.show(strokes[i]); });
        limited = axis_.bound();
        fault = axis_.fault();
        show_status(inputs);
    }

    void show_status(const StrokingAxis::Inputs& inputs) noexcept {
        ChoppingSeen seen;
        seen.fault = axis_.fault() != Fault::none;
        seen.bounded = axis_.bound() != Bound::none;
        seen.moves = axis_.motion().moves();
        seen.returns = axis_.motion().state() == StrokeMotion::State::returning;
        seen.ends = axis_.motion().state() == StrokeMotion::State::stopping;
        seen.held = axis_.motion().oscillation().held();
        seen.hold_ordered = axis_.hold_ordered();
        seen.speed_zero = axis_.values().override_value == 0;
        seen.away = axis_.away();
        seen.stands_off = axis_.stands_off();
        seen.place_known = axis_.place_known();
        seen.on = inputs.on;
        seen.homed = inputs.homed;
        seen.permitted = inputs.orders.enable;
        seen.interlock = status.of_interlock();
        status = status_of(seen);
    }

    StrokingAxis axis_;
    double motor_ = 0;  // mu, the last good one
};

hal::Model hal::model() {
    return model_of<Chopping>();
}

}  // namespace plumb
