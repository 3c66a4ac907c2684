// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/compensation/chopping/chopping_status.hpp"
#include "components/compensation/chopping/stroking_axis.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/offset.hpp"
#include "hal/records.hpp"
#include "pages/chopping.page.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>

namespace plumb {

// A learned stroke as the walk shows and restores it.
struct LearnedRow final : hal::RecordRow<DeadPointLearning::Learned> {
    using RecordRow::RecordRow;

    Field<double> lower{this, record.stroke.lower, "lower", "mu", "Lower dead point."};
    Field<double> upper{this, record.stroke.upper, "upper", "mu", "Upper dead point."};
    Field<double> speed{this, record.stroke.speed, "speed", "mu/s", "Peak speed without override."};
    Field<double> acceleration{this, record.stroke.acceleration, "acceleration", "mu/s2",
                               "The max-acceleration."};
    Field<std::int32_t> sections{this, record.stroke.sections, "sections", "",
                                 "Number that stands for all sections, dwells, the lead and the exact stop."};
    Field<double> lower_offset{this, record.offset[0], "lower-offset", "mu",
                               "Correction of the lower dead point."};
    Field<double> upper_offset{this, record.offset[1], "upper-offset", "mu",
                               "Correction of the upper dead point."};
    Field<double> lower_first{this, record.first_offset[0], "lower-first", "mu",
                              "That correction when it was first learned."};
    Field<double> upper_first{this, record.first_offset[1], "upper-first", "mu",
                              "That correction when it was first learned."};
    Field<double> reversal{this, record.reversal, "reversal", "mu/s2", "Acceleration at the dead points."};
    Field<double> proven{this, record.proven, "proven", "mu/s2",
                         "Largest acceleration that the joint has followed."};
    Field<double> lower_slow{this, record.slow[0], "lower-slow", "mu",
                             "Distance that the axis turns beyond its command in the last cycle of a climb."};
    Field<double> upper_slow{this, record.slow[1], "upper-slow", "mu",
                             "Distance that the axis turns beyond its command in the last cycle of a climb."};
    Field<double> lower_shown{this, record.shown[0], "lower-shown", "mu/s2",
                              "Acceleration of the axis itself after the lower dead point in this cycle."};
    Field<double> upper_shown{this, record.shown[1], "upper-shown", "mu/s2",
                              "Acceleration of the axis itself after the upper dead point in this cycle."};
};

// The pins of the infeed, with infeed=1.
struct InfeedPins final : hal::Group {
    InfeedPins(hal::Owner owner, const hal::Out<bool>& limited)
        : Group(owner),
          moves{this, hal::MovingPin(offset)
                          .bound(settings.pin_of(settings.most))
                          .rate(settings.pin_of(settings.rate))
                          .acceleration(settings.pin_of(settings.acceleration))
                          .limited(limited)} {}

    Infeed::Settings settings{this};
    hal::In<bool> end{this, "infeed-end", false,
                      "True ends the infeed, as its total does: for a gauge at the work."};
    hal::In<double> position{this, "infeed-position", 0, "mu",
                             "Commanded position of the joint of the infeed: joint.N.pos-cmd."};
    hal::In<double> feedback{this, "infeed-feedback", 0, "mu",
                             "Measured position of this joint, without the offset: joint.N.pos-fb."};
    hal::In<double> applied{this, "infeed-applied", 0, "mu",
                            "Offset that this joint has: applied-offset of its stage."};
    hal::Out<double> offset{this, "infeed-offset", "mu", "For the stage of the joint of the infeed."};
    hal::Out<bool> done{this, "infeed-done",
                        "The infeed has ended: by its total, a soft limit, infeed-end or an abort."};
    hal::Offset moves;
};

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
                                hal::machine(StrokeSettings::places)};
    hal::In<bool> program_running{this, "program-running", false,
                                  "A part program runs, not an MDI command. Strokes that it began end when "
                                  "it becomes false, others when it becomes true."};
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
    hal::In<double> applied_offset{
        this, "applied-offset", 0, "mu",
        "Offset that joint-feedback lacks: offset, with joint_offset; 0 for an extra joint."};
    hal::In<bool> stage_limited{this, "stage-limited", false, "The stage does not apply the whole offset."};
    hal::In<std::int32_t> stage_released{this, "stage-released", -1,
                                         "Net released of joint_offset: with 1, machine off has made the "
                                         "offset part of position; -1 without such a stage."};
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
    StrokeSettings settings{this, sections};

    hal::Out<double> offset{this, "offset", "mu", "For the stage of the joint."};
    hal::Out<double> command{this, "command", "mu",
                             "Position with the offset: joint.N.posthome-cmd, or for other functions."};
    hal::Out<double> command_velocity{this, "command-velocity", "mu/s",
                                      "Velocity of joint and stroke together, for other functions."};
    hal::Out<bool> at_end{this, "at-end", "The axis rests at position, and the offset is 0."};
    hal::Out<bool> place_known{
        this, "place-known",
        "The command of an extra joint is where its axis stands; false must keep its drive off."};
    hal::Out<bool> stands_off{this, "stands-off",
                              "Machine off has ended strokes, and the axis has not been at their point R "
                              "since: position is where it stood."};
    hal::Out<double> stands_off_by{
        this, "stands-off-by", "mu",
        "Position minus the point R of those strokes while stands-off is true, or 0, for a display."};
    hal::Out<bool> program_refused{this, "program-refused",
                                   "The last word of the program is invalid, or the stroke that it checks."};
    hal::Out<std::int32_t> program_sections{this, "program-sections", "Sections that the program gave."};
    hal::Out<bool> feed_wait{this, "feed-wait",
                             "Moves of a program have to wait: strokes end that no program orders any more, "
                             "or a fault has stopped the axis away from position."};
    hal::Out<double> end_position{
        this, "end-position", "mu",
        "Point R, where strokes end, for a display: position at its last good value."};
    hal::Out<double> measured_position{this, "measured-position", "mu",
                                       "Measured position of the axis, with the offset."};
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
    hal::Out<double> measured_upper{this, "measured-upper", "mu", "Upper dead point of the last stroke."};
    hal::Out<double> measured_lower{this, "measured-lower", "mu", "Lower dead point of the last stroke."};
    hal::Out<double> upper_error{
        this, "upper-error", "mu",
        "Measured minus programmed upper dead point; positive is beyond the stroke."};
    hal::Out<double> lower_error{
        this, "lower-error", "mu",
        "Programmed minus measured lower dead point; positive is beyond the stroke."};
    hal::Out<double> upper_correction{this, "upper-correction", "mu",
                                      "Correction of the commanded upper dead point; positive is outward."};
    hal::Out<double> lower_correction{this, "lower-correction", "mu",
                                      "Correction of the commanded lower dead point; positive is outward."};
    hal::Out<double> speed_factor{this, "speed-factor", "1", "Part of the speed that learning permits."};
    hal::Out<bool> learns{this, "learns", "Learn is in force, for squareness: L-learns."};
    hal::Out<bool> learned{this, "learned", "Both dead points were within tolerance twice."};
    hal::Out<double> drift{this, "drift", "mu", "Change of a correction since it was first learned."};
    hal::Records records{this};
    LearnedRow row{this};
    hal::Codes<Bound> limited{this, "limited", "A bound is active; limited-code gives it."};
    hal::Count infeeds{this, "infeed", 0, 0, 1, "1 with an infeed by another axis, else 0."};
    const std::unique_ptr<InfeedPins> infeed = infeeds > 0
                                                   ? std::make_unique<InfeedPins>(this, limited.active())
                                                   : nullptr;
    hal::Codes<Fault> fault{this, "fault"};
    hal::Status<ChoppingStatus> status{this, permission};

    hal::Offset moves{
        this, hal::MovingPin(offset)
                  .bound(settings.pin_of(settings.max_offset))
                  .follows_while(active)
                  .rate(settings.pin_of(settings.max_rate))
                  .acceleration(settings.pin_of(settings.max_acceleration), StrokingAxis::guard_factor)
                  .undriven(motion_enabled, homed)
                  .limited(limited.active())};

    hal::Effects withholds{this, hal::Effect::withholds, go_to_end};
    hal::Effects at_once{this, hal::Effect::at_once, run};

    hal::Function update_function{this, "update", &Chopping::update, hal::Place::source};

    void prepare() override { axis_.begin(settings, 1 / unit.millimetres()); }

    void update(double dt) noexcept {
        permission.step();
        const StrokingAxis::Inputs inputs = judged();
        take_records();
        bool changed = settings.read();
        if (infeed) {
            changed |= infeed->settings.read();
            infeed->settings.taper = settings.taper;
        }
        axis_.step(inputs, {settings, infeed ? &infeed->settings : nullptr, changed}, dt);
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
        if (infeed) its.infeed = {infeed->end, infeed->position, infeed->feedback, infeed->applied};
        return its;
    }

    void take_records() noexcept {
        if (records.wants_forget()) axis_.forget();
        if (records.wants_restore()) records.restored(axis_.change_learning().restore(row.given()));
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
        show_stroke();
        if (infeed) {
            infeed->offset = axis_.infeed().value();
            infeed->done = axis_.infeed().done();
        }
        show_dead_points();
        limited = axis_.bound();
        fault = axis_.fault();
        show_status(inputs);
    }

    void show_stroke() noexcept {
        const StrokeMotion& motion = axis_.motion();
        const Oscillation& oscillation = motion.oscillation();
        const StrokeSupervision& supervision = axis_.supervision();
        const double its_phase = oscillation.phase(), seen_phase = supervision.phase().phase();
        velocity = motion.leading().velocity();
        acceleration = motion.leading().acceleration();
        phase = its_phase * (180 / pi);
        measured_phase = seen_phase * (180 / pi);
        const double late = its_phase - seen_phase;
        phase_lag = (late > pi ? late - 2 * pi : late < -pi ? late + 2 * pi : late) * (180 / pi);
        active = axis_.moves();
        stroking = motion.state() == StrokeMotion::State::stroking;
        withdrawing = motion.state() == StrokeMotion::State::returning;
        way_out_time = oscillation.longest_way_out();
        held = motion.moves() && oscillation.held();
        sparking_out = motion.moves() && oscillation.sparking_out();
        upper_pulse = supervision.clock().pulse(true);
        lower_pulse = supervision.clock().pulse(false);
        stroke_count = oscillation.strokes();
        planned_cycle_time = oscillation.stroke_time(true) + oscillation.stroke_time(false) +
                             axis_.values().lower_dwell + axis_.values().upper_dwell;
        actual_cycle_time = supervision.clock().time();
    }

    void show_dead_points() noexcept {
        const DeadPointWatch& watch = axis_.supervision().dead_points();
        const DeadPointLearning& learning = watch.learning();
        const bool learns_now = axis_.values().learn;
        measured_upper = watch.position(true);
        measured_lower = watch.position(false);
        upper_error = watch.error(true);
        lower_error = watch.error(false);
        upper_correction = learns_now ? watch.arrival(true).offset : 0;
        lower_correction = learns_now ? watch.arrival(false).offset : 0;
        speed_factor = axis_.supervision().part(axis_.values());
        learns = learns_now;
        learned = learns_now && learning.learned();
        drift = learns_now ? learning.drift() : 0;
        const LearnedStrokes& strokes = learning.strokes();
        records.show(strokes.size(), [&](std::int32_t i) noexcept { row.show(strokes[i]); });
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
        seen.speed_zero = axis_.values().override_ == 0;
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
