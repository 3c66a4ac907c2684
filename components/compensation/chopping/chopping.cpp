// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/compensation/chopping/chopping_settings.hpp"
#include "components/compensation/chopping/dead_point_pins.hpp"
#include "components/compensation/chopping/guarded_offset.hpp"
#include "components/compensation/chopping/homed_watch.hpp"
#include "components/compensation/chopping/learned_row.hpp"
#include "components/compensation/chopping/stroke_faults.hpp"
#include "components/compensation/chopping/stroke_in_force.hpp"
#include "components/compensation/chopping/stroke_motion.hpp"
#include "components/compensation/chopping/stroke_orders.hpp"
#include "components/compensation/chopping/stroke_pins.hpp"
#include "components/compensation/chopping/stroke_supervision.hpp"
#include "components/compensation/chopping/stroke_words.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/oscillation/oscillation.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"
#include "hal/records.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

struct Chopping final : hal::Component {
    static constexpr hal::About about{
        "chopping",
        "strokes an axis between two dead points, while others follow a contour",
        R"(
chopping moves a linear axis to and fro between two dead points: the wheel of a grinder, the ram of a planer, a saw. The
other axes follow their program meanwhile. The speed is that of a crank. Sections of the stroke get speeds of their
own, such as slow in contact and fast in air, within one limit for the whole acceleration.

The output is an offset for joint_offset(9) that starts and ends at 0, where the program left the axis, point R. An
extra joint takes command instead. chopping measures both dead points and corrects them, so that the axis reaches them
and does not pass them.

The theory and the figures are in components/compensation/chopping/README.md of the sources.)",
        hal::Wiring{R"(
For Z. joint_offset(9) has the other lines of the stage.

  loadrt chopping     names=chop    unit=[TRAJ]LINEAR_UNITS
  loadrt joint_offset names=z-stage unit=[TRAJ]LINEAR_UNITS

  setp chop.min-limit [JOINT_2]MIN_LIMIT
  setp chop.max-limit [JOINT_2]MAX_LIMIT
  setp chop.upper     -5
  setp chop.lower    -45
  setp chop.feed     200
  setp z-stage.max-offset 500
  setp z-stage.max-rate   500
  setp z-stage.release-at-off-0 true

  net motion-enabled motion.motion-enabled  => chop.motion-enabled
  net z-homed        joint.2.homed          => chop.homed
  net z-position     joint.2.pos-cmd        => chop.position
  net z-fb           joint.2.pos-fb         => chop.joint-feedback
  net z-limited      z-stage.limited        => chop.stage-limited
  net z-released     z-stage.released       => chop.stage-released
  net chop-run       motion.digital-out-01  => chop.run
  net z-chop         chop.offset            => z-stage.offset-0
  net z-chop                                => chop.applied-offset

  addf motion-command-handler  servo-thread
  addf z-stage.update-feedback servo-thread
  addf motion-controller       servo-thread
  addf chop.update             servo-thread
  addf z-stage.update          servo-thread

An extra joint, such as joint 3, needs no stage. LinuxCNC homes it, and then leaves it to HAL. Net joint.3.homed to
chop.homed, joint.3.pos-fb to chop.joint-feedback, and chop.command to joint.3.posthome-cmd. Set chop.position to point
R. configs/grinder/extra.hal has all lines.

LinuxCNC watches neither the soft limits nor the following error of an extra joint. chopping does: set min-limit,
max-limit and max-following-error.)"},
        hal::SettingUp{R"(
1. Set min-limit and max-limit of the joint, and max-feed, max-acceleration and jerk-time for its drive. With joint_offset
set its max-offset and max-rate at least to those here, its offset-acceleration to eight times max-acceleration and twice
its joint-acceleration, at least, and taper to 3: over three times its length it takes an offset away before a limit.
2. Set the dead points and the feed. Set run true: the axis strokes. Set it false: the axis returns to R.
3. Watch upper-error and lower-error. They show how far the measured dead points lie beyond the set ones. phase-lag shows
how late the axis is.
4. Set learn true, on a scale at the load. The first cycles are slow and end 5 % of the stroke inside, at most inset.
Set max-correction above the lag at a dead point, about the acceleration there / (2 Kv^2).
5. Set sections: kind 2, from, to and ratio for a window of heights.
6. With a lead, set jerk-time to at least 2 lead max-acceleration / (max-output-accel - max-acceleration).)"},
        hal::Behaviour{R"(
- Start: A rising edge of run, from anywhere. Outside the dead points the axis moves to the far one first.
- run false, stop true: The stop that stop-kind selects, after spark-out strokes.
- enable false: A withdrawal, whatever stop-kind is. The stroke goes on to the dead point nearest R, if need be by way of
the other one, and then to R: without dwell, spark-out, infeed or a new region. feed-hold does not stop it. The
override multiplies its speed, and 0 counts as 1. An axis at rest stays where it is.
- go-to-end: A rising edge while the axis strokes withdraws it. At rest it returns the axis to position at once, also
where enable is false. It goes before run and before a hold that is there; a later hold stops it while enable is true.
- Withdrawal: It lasts until the axis rests, also where enable returns or stop-kind changes. Then a rising edge of run
starts the next strokes; one before that is refused. Only these end it before R: machine off, not homed, a following
error (fault 10) and a wrong scale (fault 12).
- feed-hold, override 0: The axis brakes within its region, and stands. It goes on in its direction.
- Abort of a program: Let it set run false. The axis returns to R. Net feed-wait to a function-settling of interlock(9):
moves wait until then. HAL cannot hold a jog: jog another axis out of the work.
- End of a program: It ends the strokes that the program began, unless outlast is true. Those of MDI go on.
- Machine off, emergency stop: The axis stands, and turning on moves nothing. With stage-released the offset becomes part
of position in that period: LinuxCNC shows and limits the true place of the axis, offset is 0, and point R is there. An
extra joint keeps its offset. The next rising edge of run starts where the axis is.
- Speed, override, dwell, sections: Changes come with the next stroke or the one after it.
- exact-stop: The dwell begins when the measured axis is as near to its dead point, at the latest after exact-stop-time.
- program-word: A word of a program goes before its setting until the axis rests. An invalid word is refused and changes
nothing. Word 12 asks whether a stroke from program-value is possible: program-refused and the fault answer, and nothing
moves.
- Frequency, cycle-time: Kept in the mean where learned ends make the stroke longer, if max-acceleration permits it.
- Lead, jerk-time: Changes come with the next start.
- Dead points: Taken over at the start, by each change of shift, or when crossing-position crosses crossing-at. A new
upper dead point comes with an upward stroke, a new lower one with a downward stroke, so that nothing steps. With a
correction in force they come one stroke later.
- Joint moves (another position): The stroke stays where it is. The end is at the new position.
- Learning: Holds while speed, sections or region change, and for the first stroke. The speed rises as the axis shows
the force for it: a stroke accelerates by a new value and brakes by one that was shown. A drive that is too weak keeps
the speed that it has followed, fault 22. Eight strokes are remembered.
- Proven acceleration: Regions and speeds below the largest acceleration that this joint has followed begin at full
speed. After a restart retain(1) restores the strokes: one cycle at four fifths of the speed confirms them.
- Passing a dead point by more than max-beyond: Learning begins again, fault 13. After the second time the last good
speed stays, fault 23, until learn is set false and true, or forget rises.
- Jam, loss of force, a scale that does not follow: Fault 21 in the same stroke, which is stopped.
- A scale that slips: Both dead points move the same way. Two such cycles stop the stroke, fault 19.
- Dead points that a scale cannot have measured: Not learned; the second one in a row stops the stroke.
- Near a dead point with a correction: No stop and no hold ends outside the region.
- max-offset, max-rate: A smaller one waits until the axis rests. A max-offset that the stroke does not fit into is refused
with all other changes. At rest it is refused below the present offset, and nothing moves. Where the joint moves so that
max-offset would be passed, the offset brakes in time.
- Invalid settings: The last good set stays in force, as a whole. Before the start, the stroke is refused; the fault lasts until run is false.
- Invalid position, feedback: The last good position stays; dead points are not learned, and measured-phase stands.
- Not homed: The stroke stops at once. With stage-released the offset holds until the machine is off. A stage without
release-at-off ramps it down, and offset returns to 0 after 1 s. An extra joint stays where it is; its command returns to
R only when homing moves the joint. A homed that returns moves nothing.)"},
        hal::Limits{R"(
A correction needs a scale at the load. On a scale at the motor backlash and windup remain.

Measured dead points are those of the scale. What the wheel bends is not in them.

A stroke must last at least 16 periods.

With jerk-time and without learning each stroke ends max-acceleration jerk-time^2 / 24 short, at most.)"},
        hal::SeeAlso{"joint_offset(9), interlock(9), retain(1), sim_grinder(9), motion(9)"}};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::In<bool> run{this, "run", false, "A rising edge starts strokes; false stops them."};
    hal::In<bool> stop{this, "stop", false,
                       "True ends strokes as run false does, and refuses a start: for a button."};
    hal::In<bool> enable{this, "enable", true,
                         "Strokes are permitted; false withdraws the axis to position."};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> homed{this, "homed", false, "The joint is homed."};
    hal::In<bool> feed_hold{this, "feed-hold", false, "Brake and stand within the region."};
    hal::In<bool> go_to_end{this, "go-to-end", false,
                            "A rising edge moves the axis to position, and ends strokes."};
    hal::In<bool> shift{this, "shift", false, "Each change takes over the dead points while stroking."};
    hal::In<bool> shift_at_crossing{this, "shift-at-crossing", false,
                                    "A crossing of crossing-at takes over the dead points, too."};
    hal::In<double> crossing_position{this, "crossing-position", 0, "mu", "Position of the crossing axis."};
    hal::In<double> crossing_at{this, "crossing-at", 0, "mu", "Coordinate that it crosses, either way."};
    hal::In<bool> program_running{this, "program-running", false,
                                  "A part program runs, not an MDI command. Strokes that it began end "
                                  "when it becomes false."};
    hal::In<bool> outlast{this, "outlast", false, "Strokes go on when the program that began them ends."};
    hal::In<double> position{this, "position", 0, "mu",
                             "Commanded position of the joint, point R: joint.N.pos-cmd."};
    hal::In<double> joint_feedback{this, "joint-feedback", 0, "mu",
                                   "Measured position of the joint, without the offset: joint.N.pos-fb."};
    hal::In<double> applied_offset{this, "applied-offset", 0, "mu",
                                   "Offset that joint-feedback lacks: offset, with joint_offset; 0 for an "
                                   "extra joint."};
    hal::In<bool> stage_limited{this, "stage-limited", false, "The stage does not apply the whole offset."};
    hal::In<std::int32_t> stage_released{
        this, "stage-released", -1,
        "Net released of joint_offset: with 1, machine off has made the offset "
        "part of position; -1 without such a stage."};
    hal::In<double> pulse_time{this, "pulse-time", 0.02, "s", "Length of the infeed pulses."};
    hal::In<double> program_word{this, "program-word", 0, "1",
                                 "Number of a word of the program, whose value is program-value; each change "
                                 "takes it. chop_word.ngc has the numbers."};
    hal::In<double> program_value{this, "program-value", 0, "1",
                                  "Value of this word, in machine units or s."};
    ChoppingSettings settings{this};

    hal::Out<double> offset{this, "offset", "mu", "For the stage of the joint."};
    hal::Out<double> command{this, "command", "mu", "Position with the offset: joint.N.posthome-cmd."};
    hal::Out<bool> at_end{this, "at-end", "The axis rests at position, and the offset is 0."};
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
                                       "Measured position of the axis, with the offset, for a display."};
    StrokePins stroke{this};
    DeadPointPins dead_points{this};
    hal::Records records{this};
    LearnedRow row{this};
    hal::Codes<Bound> limited{this, "limited", "A bound is active; limited-code gives it."};
    hal::Codes<Fault> fault{this, "fault"};

    static constexpr double guard_factor = 10;  // of max-acceleration
    hal::Offset moves{this, hal::MovingPin(offset)
                                .bound(settings.max_offset)
                                .rate(settings.max_rate)
                                .acceleration(settings.max_acceleration, guard_factor)
                                .limited(limited.active())};

    hal::Function update_function{this, "update", &Chopping::update, hal::Place::source};

    void prepare() override {
        in_force_.begin(settings.read());
        guard(1);
    }

    void update(double dt) noexcept {
        const Now now = read(dt);
        const StrokeValues given = words_.over(settings.read());
        obey(now, given, dt);
        judge(given, dt);
        generate(now, dt);
        supervise(now, dt);
        show(now);
    }

private:
    static constexpr double farthest = StrokeValues::farthest;  // mu
    static constexpr double nothing = 1e-9;                     // mu
    static constexpr std::size_t nodes = 64;                    // to plan in a period

    // The inputs of a period.
    struct Now {
        StrokeOrders::Now orders;
        bool on, homed;
        bool releasable;           // the offset, by its stage
        bool released;             // it has become part of the position
        bool known;                // the position
        bool measurable;           // the joint-feedback and the applied-offset
        double measured, applied;  // mu
        double pulse;              // s

        bool ready() const noexcept { return on && homed; }
    };

    Now read(double dt) noexcept {
        const bool program = program_running;
        words_.watch_program(program, dt);
        words_.step(program_word, program_value, motion_.moves());
        const std::int32_t stage = stage_released;
        const bool is_on = motion_enabled, released = stage == 1 && !is_on;
        const double place = position, joint = joint_feedback, applied = released ? 0.0 : applied_offset;
        position_ = usable(place, farthest, position_);
        const StrokeOrders::Given given{run,         stop,    enable,
                                        go_to_end,   shift,   shift_at_crossing,
                                        program,     outlast, crossing_position,
                                        crossing_at, farthest};
        StrokeOrders::Now orders = orders_.step(given, dt);
        orders.returns |= words_.returns();
        return {orders,
                is_on,
                homed,
                stage >= 0,
                released,
                std::abs(place) <= farthest,
                std::abs(joint) <= farthest && std::abs(applied) <= farthest,
                joint + applied,
                applied,
                usable(pulse_time, 3600, 0)};
    }

    void obey(const Now& now, const StrokeValues& given, double dt) noexcept {
        const StrokeOrders::Now& orders = now.orders;
        faults_.step(orders.run);
        faults_.check(words_.checks() ? refusal(now, given, words_.checked(), dt) : Fault::none);
        if (motion_.moves() && !now.ready()) freeze();
        if (now.released) release();
        if (records.wants_forget()) supervision_.learning().forget();
        if (records.wants_restore()) records.restored(supervision_.learning().restore(row.given()));
        if (orders.starts && motion_.state() == StrokeMotion::State::returning)
            faults_.start(Fault::withdrawing);
        if (orders.starts && !motion_.moves()) start(now, given, dt);
        if (orders.returns && !motion_.moves() && now.ready() && now.known) return_to_end(now, given, dt);
        if (orders.shifts && motion_.moves()) take_over(given, dt);
    }

    void start(const Now& now, const StrokeValues& given, double dt) noexcept {
        const bool ready = now.ready() && now.orders.permitted && now.orders.runs;
        faults_.start(!ready       ? Fault::not_ready
                      : !now.known ? Fault::position
                                   : in_force_.take(given, position_, dt));
        if (faults_.refused()) return;
        in_force_.begin_cycles();
        supervision_.select(in_force_);
        supervision_.begin(seen(now));
        motion_.start(wanted(), position_ + rest_, command_in_force(dt));
    }

    // Of a stroke that is to begin at an end, mu.
    static Fault refusal(const Now& now, const StrokeValues& given, double end, double dt) noexcept {
        if (!now.ready() || !now.orders.permitted) return Fault::not_ready;
        return given.refusal(given.lower, given.upper, end, dt);
    }

    void return_to_end(const Now& now, const StrokeValues& given, double dt) noexcept {
        if (!in_force_.take_end(given, position_, dt)) return;
        supervision_.begin(seen(now));
        motion_.return_to_end(wanted(), position_ + rest_, command_in_force(dt));
    }

    void take_over(const StrokeValues& given, double dt) noexcept {
        const Fault reason = in_force_.take(given, position_, dt);
        if (reason != Fault::none) return faults_.happen(reason);
        supervision_.select(in_force_);
        supervision_.pause();
    }

    // The drive is off: nothing moves, and nothing will by itself.
    void freeze() noexcept {
        rest_ = offset_.value();
        motion_.freeze(position_ + rest_);
    }

    // Motion has taken over the place of the axis.
    void release() noexcept {
        rest_ = 0;
        offset_.release();
        motion_.freeze(position_);
    }

    void judge(const StrokeValues& given, double dt) noexcept {
        const StrokeMotion::Command& its = motion_.command();
        if (in_force_.judge(given, {position_, motion_.moves(), its.lead, its.jerk_time}, dt))
            supervision_.select(in_force_);
        guard(dt);
    }

    void guard(double dt) noexcept {
        const StrokeValues& values = in_force_.values();
        const double planned = motion_.moves() ? motion_.oscillation().planned_acceleration() : 0;
        const double hardest = std::max(values.stroke.acceleration, planned);
        offset_.allow({values.max_offset, values.max_rate, guard_factor * hardest}, motion_.moves(), farthest,
                      dt);
    }

    StrokeMotion::Command command_in_force(double dt) const noexcept {
        const StrokeValues& values = in_force_.values();
        return {values.lead, values.jerk_time, values.jerk_samples(dt)};
    }

    Oscillation::Settings wanted() const noexcept {
        Oscillation::Settings its = in_force_.stroke(supervision_.part(in_force_.values()), position_);
        if (in_force_.values().learn) supervision_.learning().restrain(its);
        return its;
    }

    StrokeSupervision::Seen seen(const Now& now) noexcept {
        return {now.measurable, now.measured, position_ + offset_.value(), now.pulse};
    }

    void generate(const Now& now, double dt) noexcept {
        const StrokeValues& values = in_force_.values();
        const bool moved = motion_.moves();
        motion_.oscillation().see_axis(
            now.measurable && std::abs(now.measured - motion_.oscillation().position()) <= values.exact_stop);
        motion_.step({now.orders.runs, now.orders.permitted, now.orders.returns,
                      feed_hold || values.override_value == 0 || supervision_.recovers(), values.stop()},
                     wanted(), dt, nodes, [&](bool upper, double reversal, double speed) {
                         return values.learn ? supervision_.learning().offset(upper, reversal, speed) : 0;
                     });
        if (moved && !motion_.moves()) rest_at(motion_.leading().mean() - position_);
        watch_homed(now, dt);
        // Where a bound has stopped it, a larger one must not move it later.
        if (!motion_.moves() && offset_.kept_back() && offset_.stands()) rest_ = offset_.value();
        const double target = motion_.moves() ? motion_.leading().position() - position_ : rest_;
        offset_.step(target, !now.on && now.homed, dt);
    }

    void rest_at(double place) noexcept { rest_ = std::abs(place) <= nothing ? 0 : place; }

    void watch_homed(const Now& now, double dt) noexcept {
        const double lag = std::abs(now.measured - (position_ + offset_.value()));
        switch (homed_watch_.step(
            {now.homed, now.releasable, std::abs(now.applied) > nothing, now.measurable, lag}, dt)) {
            case HomedWatch::Offset::as_applied: rest_ = offset_.value(); break;
            case HomedWatch::Offset::none: rest_ = 0; break;
            case HomedWatch::Offset::stays: break;
        }
    }

    void supervise(const Now& now, double dt) noexcept {
        const StrokeSupervision::Findings found = supervision_.step(seen(now), motion_, in_force_, dt);
        if (found.fault != Fault::none) faults_.happen(found.fault);
        if (found.stops) motion_.fail();
        if (found.corrected) motion_.oscillation().refresh();
    }

    void show(const Now& now) noexcept {
        offset = offset_.value();
        command = position_ + offset_.value();
        feed_wait = motion_.moves() ? !now.orders.ordered : motion_.failed() && offset_.value() != 0;
        end_position = position_;
        if (now.measurable) measured_position = now.measured;
        stroke.show(motion_, supervision_, in_force_.values());
        at_end = !motion_.moves() && offset_.value() == 0;
        program_refused = words_.refused() || faults_.checked() != Fault::none;
        program_sections = static_cast<std::int32_t>(words_.sections());
        dead_points.show(supervision_, in_force_.values());
        const LearnedStrokes& strokes = supervision_.learning().strokes();
        records.show(strokes.size(), [&](std::int32_t i) noexcept { row.show(strokes[i]); });
        report(now);
    }

    void report(const Now& now) noexcept {
        const Oscillation& oscillation = motion_.oscillation();
        const bool runs = motion_.moves();
        const Fault checked = faults_.checked(), happened = faults_.happened(),
                    settings_fault = in_force_.refused(),
                    supervised = supervision_.fault(in_force_.values(), runs && !now.measurable);
        late_ = runs && (late_ || oscillation.late());
        limited = hal::first<Bound>({{offset_.kept_back(), Bound::offset},
                                     {runs && stage_limited, Bound::stage},
                                     {runs && oscillation.clipped(), Bound::soft_limit},
                                     {runs && supervision_.part(in_force_.values()) < 1, Bound::learning},
                                     {runs && oscillation.limited(), Bound::speed},
                                     {late_, Bound::plan},
                                     {runs && oscillation.impatient(), Bound::arrival}});
        fault = hal::first<Fault>({{checked != Fault::none, checked},
                                   {happened != Fault::none, happened},
                                   {!now.known, Fault::position},
                                   {settings_fault != Fault::none, settings_fault},
                                   {offset_.refused(), Fault::bound},
                                   {supervised != Fault::none, supervised}});
    }

    StrokeOrders orders_;
    StrokeWords words_;
    StrokeInForce in_force_;
    StrokeMotion motion_;
    StrokeSupervision supervision_;
    StrokeFaults faults_;
    HomedWatch homed_watch_;
    GuardedOffset offset_;
    double position_ = 0;  // mu, point R: the last good one
    double rest_ = 0;      // mu, the offset at rest
    bool late_ = false;
};

hal::Model hal::model() {
    return model_of<Chopping>();
}

}  // namespace plumb
