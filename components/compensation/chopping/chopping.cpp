// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/compensation/chopping/chopping_settings.hpp"
#include "components/compensation/chopping/crossing.hpp"
#include "components/compensation/chopping/cycle_clock.hpp"
#include "components/compensation/chopping/dead_point_watch.hpp"
#include "components/compensation/chopping/ending.hpp"
#include "components/compensation/chopping/guarded_offset.hpp"
#include "components/compensation/chopping/leading_command.hpp"
#include "components/compensation/chopping/learned_row.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/oscillation/measured_phase.hpp"
#include "components/math/oscillation/oscillation.hpp"
#include "hal/component.hpp"
#include "hal/offset.hpp"
#include "hal/records.hpp"

#include <algorithm>
#include <cmath>
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

  net motion-enabled motion.motion-enabled  => chop.motion-enabled
  net z-homed        joint.2.homed          => chop.homed
  net z-position     joint.2.pos-cmd        => chop.position
  net z-fb           joint.2.pos-fb         => chop.joint-feedback
  net z-limited      z-stage.limited        => chop.stage-limited
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
- Abort of a program: Let it set run false. The axis returns to R.
- Machine off, emergency stop: The offset holds. Turning on moves nothing; the next rising edge of run starts where the
axis is.
- Speed, override, dwell, sections: Changes come with the next stroke or the one after it.
- Frequency, cycle-time: Kept in the mean where learned ends make the stroke longer, if max-acceleration permits it.
- Lead, jerk-time: Changes come with the next start.
- Dead points: Taken over at the start, by each change of shift, or when crossing-position crosses crossing-at. A new
upper dead point comes with an upward stroke, a new lower one with a downward stroke, so that nothing steps. With a
correction in force they come one stroke later.
- Joint moves (another position): The stroke stays where it is. The end is at the new position.
- Learning: Holds while speed, sections or region change, and for the first stroke. Eight strokes are remembered. After a restart retain(1) restores them with their first corrections: the stroke begins slow,
and takes them up as far as the slow strokes confirm them.
- Dead points that a scale cannot have measured: Not learned; the second one in a row stops the stroke.
- Near a dead point with a correction: No stop and no hold ends outside the region.
- max-offset below the present offset: It is refused, and nothing moves. It comes into force when the offset can stop
within it. At max-offset the offset brakes in time.
- Invalid settings: The last good set stays in force, as a whole. Before the start, the stroke is refused; the fault lasts until run is false.
- Invalid position, feedback: The last good position stays; dead points are not learned, and measured-phase stands.
- Not homed: The stroke stops at once. An extra joint stays where it is; its command returns to R only when homing moves
the joint. With a stage, which releases the offset, it returns to 0 after 1 s. A homed that returns moves nothing.)"},
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
    hal::In<double> position{this, "position", 0, "mu",
                             "Commanded position of the joint, point R: joint.N.pos-cmd."};
    hal::In<double> joint_feedback{this, "joint-feedback", 0, "mu",
                                   "Measured position of the joint, without the offset: joint.N.pos-fb."};
    hal::In<double> applied_offset{this, "applied-offset", 0, "mu",
                                   "Offset that joint-feedback lacks: offset, with joint_offset; 0 for an "
                                   "extra joint."};
    hal::In<bool> stage_limited{this, "stage-limited", false, "The stage does not apply the whole offset."};
    hal::In<double> pulse_time{this, "pulse-time", 0.02, "s", "Length of the infeed pulses."};
    ChoppingSettings settings{this};

    hal::Out<double> offset{this, "offset", "mu", "For the stage of the joint."};
    hal::Out<double> command{this, "command", "mu", "Position with the offset: joint.N.posthome-cmd."};
    hal::Out<double> velocity{this, "velocity", "mu/s", "Velocity of the stroke, for a feed-forward."};
    hal::Out<double> acceleration{this, "acceleration", "mu/s2", "Acceleration of the stroke."};
    hal::Out<double> phase{this, "phase", "deg", "Phase: 0 at the lower, 180 at the upper dead point."};
    hal::Out<double> measured_phase{
        this, "measured-phase", "deg",
        "Phase by the measured position: 0 and 180 where the axis itself turns, or is expected to."};
    hal::Out<double> phase_lag{this, "phase-lag", "deg",
                               "Phase minus measured-phase, -180 to 180: how late the axis is."};
    hal::Out<bool> active{this, "active", "The axis strokes, or is on its way to the end."};
    hal::Out<bool> at_end{this, "at-end", "The axis rests at position, and the offset is 0."};
    hal::Out<bool> withdrawing{this, "withdrawing",
                               "The axis is on its way to position, by enable or go-to-end."};
    hal::Out<bool> held{this, "held", "The axis stands for a hold."};
    hal::Out<bool> sparking_out{this, "sparking-out", "Spark-out strokes are under way."};
    hal::Out<bool> upper_pulse{this, "upper-pulse", "Infeed pulse at the upper dead point."};
    hal::Out<bool> lower_pulse{this, "lower-pulse", "Infeed pulse at the lower dead point."};
    hal::Out<std::int32_t> stroke_count{this, "stroke-count", "Strokes since the start; two are a cycle."};
    hal::Out<double> planned_cycle_time{this, "planned-cycle-time", "s", "Both strokes with their dwells."};
    hal::Out<double> actual_cycle_time{this, "actual-cycle-time", "s", "Time of the last cycle."};
    hal::Out<double> measured_upper{this, "measured-upper", "mu", "Upper dead point of the last stroke."};
    hal::Out<double> measured_lower{this, "measured-lower", "mu", "Lower dead point of the last stroke."};
    hal::Out<double> upper_error{this, "upper-error", "mu", "Of it, positive outside the stroke."};
    hal::Out<double> lower_error{this, "lower-error", "mu", "Of it, positive outside the stroke."};
    hal::Out<double> upper_correction{this, "upper-correction", "mu", "Of the command, positive outside."};
    hal::Out<double> lower_correction{this, "lower-correction", "mu", "Of the command, positive outside."};
    hal::Out<double> speed_factor{this, "speed-factor", "1", "Part of the speed that learning permits."};
    hal::Out<bool> learned{this, "learned", "Both dead points were within tolerance twice."};
    hal::Out<double> drift{this, "drift", "mu", "Change of a correction since it was first learned."};
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
        values_ = settings.read();
        guard(values_, 1);
    }

    void update(double dt) noexcept {
        const Values given = settings.read();
        const bool on = motion_enabled, is_homed = homed;
        read_position();
        obey(given, on && is_homed, dt);
        judge(given, dt);
        guard(given, dt);
        generate(on, is_homed, dt);
        learn(dt);
        show();
    }

private:
    using Values = ChoppingSettings::Values;
    using State = Oscillation::State;

    static constexpr double farthest = ChoppingSettings::farthest;  // mu
    static constexpr double nothing = 1e-9;                         // mu
    static constexpr std::size_t nodes = 64;                        // to plan in a period
    static constexpr int most_cycles = 30;                          // of learning
    static constexpr double patience = 1;                           // s, with a joint that is not homed
    static constexpr double standing = 0.01;                        // mu, of an axis that nothing moves

    // The inputs of judge(). It takes longer than all else, so it runs only when one of them changes.
    struct Judged {
        Values given;
        double lower = 0, upper = 0, position = 0;
        bool running = false;

        bool operator==(const Judged& other) const noexcept {
            return lower == other.lower && upper == other.upper && position == other.position &&
                   running == other.running && given == other.given;
        }
    };

    void read_position() noexcept {
        const double place = position, joint = joint_feedback, applied = applied_offset;
        known_ = std::abs(place) <= farthest;
        position_ = usable(place, farthest, position_);
        measurable_ = std::abs(joint) <= farthest && std::abs(applied) <= farthest;
        measured_ = joint + applied;
        applied_ = applied;
    }

    // The commands of this period.
    void obey(const Values& given, bool ready, double dt) noexcept {
        const bool runs = run, stops = stop, permitted = enable, withdraws = end_edge_.rises(go_to_end);
        const bool starts = run_edge_.rises(runs) && !withdraws;
        if (!runs && was_refused_) event_ = Fault::none;
        was_refused_ = was_refused_ && runs;
        const bool shifts = shift_edge_.changes(shift) | crosses();
        if (running_ && !ready) freeze();
        if (records.wants_forget()) watch_.learning().forget();
        if (records.wants_restore()) records.restored(watch_.learning().restore(row.given()));
        if (starts && running_ && ending_.withdraws()) refuse(Fault::withdrawing);
        if (starts && !running_) start(given, ready && permitted && !stops, dt);
        if (withdraws && !running_ && ready) return_to_end(given, dt);
        if (shifts && running_) take_over(given, dt);
        if (running_) end({runs && !stops, permitted, withdraws, values_.stop()});
    }

    void end(const Ending::Orders& orders) noexcept {
        const Oscillation::Stop kind = ending_.step(orders);
        const double place = oscillation_.position();
        const bool stands = oscillation_.state() == State::rest;  // the command has yet to follow
        if (kind == Oscillation::Stop::withdraw && stands && std::abs(place - position_) > nothing)
            oscillation_.go_to_end(wanted(), place);
        else if (kind != Oscillation::Stop::none)
            oscillation_.stop(kind);
    }

    bool crosses() noexcept {
        const double place = crossing_position, at = crossing_at;
        return crossing_.step(place, at, farthest) && shift_at_crossing;
    }

    void start(const Values& given, bool ready, double dt) noexcept {
        const double place = position_ + rest_;
        refuse(!ready    ? Fault::not_ready
               : !known_ ? Fault::position
                         : ChoppingSettings::refusal(given, given.lower, given.upper, position_, dt));
        if (was_refused_) return;
        values_ = given;
        lower_ = given.lower;
        upper_ = given.upper;
        stretch_ = 1;
        select();
        prepare_to_move(place, dt);
        oscillation_.start(wanted(), place);
    }

    // A start, unless it is Fault::none.
    void refuse(Fault reason) noexcept {
        event_ = reason;
        was_refused_ = reason != Fault::none;
    }

    void return_to_end(const Values& given, double dt) noexcept {
        if (given.possible(dt) && ChoppingSettings::leads(given)) values_ = given;
        if (!values_.possible(dt) || !ChoppingSettings::leads(values_) || !known_) return;
        lower_ = upper_ = position_;
        prepare_to_move(position_ + rest_, dt);
        oscillation_.go_to_end(wanted(), position_ + rest_);
    }

    void prepare_to_move(double place, double dt) noexcept {
        running_ = true;
        ending_.begin();
        watch_.begin();
        clock_.begin();
        if (measurable_) measured_phase_.begin(measured_);
        command_.begin(place, values_.jerk_samples(dt));
        lead_ = values_.lead;
        jerk_time_ = values_.jerk_time;
    }

    void take_over(const Values& given, double dt) noexcept {
        const Fault reason = ChoppingSettings::refusal(given, given.lower, given.upper, position_, dt);
        if (reason != Fault::none) {
            event_ = reason;
            return;
        }
        lower_ = given.lower;
        upper_ = given.upper;
        values_ = given;
        select();
        watch_.pause();
    }

    // The drive is off: nothing moves, and nothing will by itself.
    void freeze() noexcept {
        running_ = false;
        rest_ = offset_.value();
        oscillation_.freeze(position_ + rest_);
    }

    void guard(const Values& given, double dt) noexcept {
        const double planned = running_ ? oscillation_.planned_acceleration() : 0;
        const double acceleration = std::max(values_.stroke.acceleration, planned);
        offset_.allow({given.max_offset, given.max_rate, guard_factor * acceleration}, farthest, dt);
    }

    // The settings for the present region; the last good ones, as a whole, if these are not.
    void judge(const Values& given, double dt) noexcept {
        const Judged now{given, lower_, upper_, position_, running_};
        if (now == judged_) return;
        judged_ = now;
        const bool possible = given.possible(dt);
        refused_ = possible ? Fault::none : Fault::settings;
        if (!running_) {
            if (possible && !ChoppingSettings::leads(given)) refused_ = Fault::lead;
            if (refused_ == Fault::none) values_ = given;
        } else if (upper_ > lower_) {
            refused_ = ChoppingSettings::refusal(given, lower_, upper_, position_, dt);
            if (refused_ == Fault::none && !ChoppingSettings::leads(given, lead_, jerk_time_))
                refused_ = Fault::lead;
            if (refused_ != Fault::none) return;
            values_ = given;
            select();
        }
    }

    // The stroke that learning learns.
    void select() noexcept {
        values_.learning.inset = values_.inset_of(upper_ - lower_);
        if (values_.learn) watch_.learning().select(values_.learned_stroke(lower_, upper_), values_.learning);
    }

    // Of the next stroke, mu/s.
    double next_speed() const noexcept {
        const double whole =
            upper_ > lower_ ? values_.peak_speed(upper_ - lower_) : values_.stroke.largest_speed;
        return whole * stretch_ * (values_.override_value > 0 ? values_.override_value : 1) *
               (values_.learn ? watch_.learning().speed_factor() : 1);
    }

    // What the oscillation is to do now.
    Oscillation::Settings wanted() const noexcept {
        Oscillation::Settings its = values_.stroke;
        its.lower = lower_;
        its.upper = upper_;
        its.end_position = position_;
        its.speed = next_speed();
        return its;
    }

    void generate(bool on, bool is_homed, double dt) noexcept {
        if (running_) {
            oscillation_.set(wanted());
            const bool hold = ending_.holds(feed_hold || values_.override_value == 0);
            oscillation_.step(dt, hold, nodes, [this](bool upper, double reversal, double speed) {
                return values_.learn ? watch_.learning().offset(upper, reversal, speed) : 0;
            });
            command_.step(oscillation_.position(), lead_, dt);
            if (oscillation_.state() == State::rest && command_.settled()) {
                running_ = false;
                rest_ = command_.mean() - position_;
                if (std::abs(rest_) <= nothing) rest_ = 0;
            }
        } else {
            command_.rest();
        }
        watch_homed(is_homed, dt);
        const double target = running_ ? command_.position() - position_ : rest_;
        offset_.step(target, !on && is_homed, dt);
    }

    // A joint that is not homed for a moment stays where it is. A stage releases the offset meanwhile; an
    // extra joint stands, unless it is moved: homed. Then nothing is to be there when it is homed again.
    void watch_homed(bool is_homed, double dt) noexcept {
        const double lag = std::abs(measured_ - (position_ + offset_.value()));
        if (is_homed) {
            if (unhomed_ > 0) rest_ = offset_.value();
            unhomed_ = 0;
            return;
        }
        if (unhomed_ == 0) lag_ = lag;
        unhomed_ = std::min(unhomed_ + dt, 2 * patience);
        const bool stage = std::abs(applied_) > nothing;
        if (stage ? unhomed_ > patience : measurable_ && lag > lag_ + standing) rest_ = 0;
    }

    // Looks at the measured motion: following, dead points, learning.
    void learn(double dt) noexcept {
        if (running_ && measurable_ && values_.max_following_error > 0 &&
            std::abs(measured_ - last_commanded_) > values_.max_following_error)
            stop_for(Fault::following);
        last_commanded_ = position_ + offset_.value();
        if (measurable_) measured_phase_.step(measured_, oscillation_.plan());

        clock_.step(dt);
        const Oscillation::Arrival& arrival = oscillation_.arrival();
        if (running_ && arrival.happened) {
            watch_.arrive(arrival);
            clock_.arrive(arrival.upper, arrival.infeed ? usable(pulse_time, 3600, 0) : 0);
            if (!arrival.upper) fit_cycle_time();
        }
        if (!running_ || !measurable_ || oscillation_.state() == State::braking || oscillation_.held() ||
            oscillation_.closing()) {  // which leaves the dead point with more acceleration than a stroke
            watch_.pause();
            return;
        }
        switch (watch_.step(measured_, oscillation_.second_half(), oscillation_.upward(),
                            {values_.learn, values_.override_value == 1, next_speed()})) {
            case DeadPointWatch::Event::wrong_scale: stop_for(Fault::scale); break;
            case DeadPointWatch::Event::beyond: event_ = Fault::beyond; [[fallthrough]];
            case DeadPointWatch::Event::corrected: oscillation_.refresh(); break;
            case DeadPointWatch::Event::none: break;
        }
    }

    // Changes the speed so that a cycle with its sections and dwells takes the set time: in proportion, as
    // far as the acceleration permits, once both strokes have had the present speed.
    void fit_cycle_time() noexcept {
        const double speed = next_speed(), dwells = values_.stroke.lower_dwell + values_.stroke.upper_dwell;
        const double target = values_.speed_value - dwells;
        if (values_.speed_kind != ChoppingSettings::with_sections || values_.override_value != 1 ||
            (values_.learn && watch_.learning().speed_factor() != 1) ||
            watch_.arrival(false).speed != speed || watch_.arrival(true).speed != speed || !(target > 0))
            return;
        const double ratio = (oscillation_.stroke_time(true) + oscillation_.stroke_time(false)) / target;
        if (std::abs(ratio - 1) > 1e-3) stretch_ = std::clamp(stretch_ * ratio, 0.1, 10.0);
    }

    void stop_for(Fault reason) noexcept {
        event_ = reason;
        ending_.fail();
    }

    void show() noexcept {
        offset = offset_.value();
        command = position_ + offset_.value();
        velocity = command_.velocity();
        acceleration = command_.acceleration();
        phase = oscillation_.phase() * (180 / pi);
        measured_phase = measured_phase_.phase() * (180 / pi);
        phase_lag = std::remainder(oscillation_.phase() - measured_phase_.phase(), 2 * pi) * (180 / pi);
        active = running_;
        at_end = !running_ && offset_.value() == 0;
        withdrawing = running_ && ending_.withdraws();
        held = running_ && oscillation_.held();
        sparking_out = running_ && oscillation_.sparking_out();
        upper_pulse = clock_.pulse(true);
        lower_pulse = clock_.pulse(false);
        stroke_count = oscillation_.strokes();
        planned_cycle_time = oscillation_.stroke_time(true) + oscillation_.stroke_time(false) +
                             values_.stroke.lower_dwell + values_.stroke.upper_dwell;
        actual_cycle_time = clock_.time();
        measured_upper = watch_.position(true);
        measured_lower = watch_.position(false);
        upper_error = watch_.error(true);
        lower_error = watch_.error(false);
        const DeadPointLearning& learning = watch_.learning();
        const bool learns = values_.learn;
        upper_correction = learns ? watch_.arrival(true).offset : 0;
        lower_correction = learns ? watch_.arrival(false).offset : 0;
        speed_factor = learns ? learning.speed_factor() : 1;
        learned = learns && learning.learned();
        drift = learns ? learning.drift() : 0;
        const LearnedStrokes& strokes = learning.strokes();
        records.show(strokes.size(), [&](std::int32_t i) noexcept { row.show(strokes[i]); });
        report(learns);
    }

    void report(bool learns) noexcept {
        const DeadPointLearning& learning = watch_.learning();
        late_ = running_ && (late_ || oscillation_.late());
        limited = hal::first<Bound>({{offset_.kept_back(), Bound::offset},
                                     {running_ && stage_limited, Bound::stage},
                                     {running_ && oscillation_.clipped(), Bound::soft_limit},
                                     {running_ && learns && learning.speed_factor() < 1, Bound::learning},
                                     {running_ && oscillation_.limited(), Bound::speed},
                                     {late_, Bound::plan}});
        fault = hal::first<Fault>(
            {{event_ != Fault::none, event_},
             {!known_, Fault::position},
             {refused_ != Fault::none, refused_},
             {offset_.refused(), Fault::bound},
             {learns && running_ && !measurable_, Fault::feedback},
             {learns && learning.weak(), Fault::weak},
             {learns && !learning.learned() && learning.cycles() >= most_cycles, Fault::not_learned},
             {learns && learning.drift() > values_.max_drift, Fault::drift}});
    }

    Values values_{};  // the last good ones
    Judged judged_;
    Oscillation oscillation_;
    Ending ending_;
    LeadingCommand command_;
    GuardedOffset offset_;
    DeadPointWatch watch_;
    MeasuredPhase measured_phase_;
    CycleClock clock_;
    Crossing crossing_;
    Edge run_edge_, end_edge_, shift_edge_;
    double position_ = 0, measured_ = 0, applied_ = 0;
    double lower_ = 0, upper_ = 0;  // the region in force
    double stretch_ = 1;            // of the speed, for a cycle time with sections
    double rest_ = 0;               // offset at rest
    double last_commanded_ = 0;
    double lead_ = 0, jerk_time_ = 0;  // s, of the command since its start
    double unhomed_ = 0, lag_ = 0;     // s since homed was lost; mu, of the axis then
    Fault event_ = Fault::none, refused_ = Fault::none;
    bool known_ = true, measurable_ = true, running_ = false, was_refused_ = false, late_ = false;
};

hal::Model hal::model() {
    return model_of<Chopping>();
}

}  // namespace plumb
