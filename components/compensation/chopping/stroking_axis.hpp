// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/compensation/chopping/infeed.hpp"
#include "components/compensation/chopping/stroke_motion.hpp"
#include "components/compensation/chopping/stroke_offset.hpp"
#include "components/compensation/chopping/stroke_orders.hpp"
#include "components/compensation/chopping/stroke_settings.hpp"
#include "components/compensation/chopping/stroke_supervision.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/oscillation/oscillation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace plumb {

// An axis that strokes by the orders of a program and an operator. Outside of a stroke, and where the machine
// is off, it moves nothing by itself. All positions are in mu.
class StrokingAxis {
public:
    static constexpr double farthest = StrokeSettings::farthest;
    static constexpr double guard_factor = 10;  // of the largest acceleration, for the offset

    // Of a period: of the axis that feeds in.
    struct InfeedInputs {
        bool ends = false;
        double position = 0, measured = 0, applied = 0;
    };

    // Of a period.
    struct Inputs {
        StrokeOrders::Given orders;
        bool feed_hold = false, emergency_hold = false;
        bool trial_over = false;         // of plumb commission
        bool on = false, homed = false;  // the machine, the joint
        bool spindle_on = true, at_speed = true;
        bool stage_limited = false;
        bool releasable = false;          // the offset, by its stage
        bool released = false;            // it has become part of the position
        double position = 0;              // point R
        double joint = 0, applied = 0;    // measured, and the offset that this lacks
        double motor = 0;                 // by the encoder of the motor
        double word = 0, word_value = 0;  // of the program
        InfeedInputs infeed;
    };

    // A millimetre in mu.
    void begin(const StrokeSettings& settings, double millimetre = 1) noexcept {
        place_.begin(millimetre);
        in_force_.begin(settings);
        guard(1);
    }

    // The settings of a period.
    struct Given {
        const StrokeSettings& stroke;
        const Infeed::Settings* infeed = nullptr;  // none without the option
        bool changed = true;                       // one of them, since the last period
    };

    // One period of dt s.
    void step(const Inputs& inputs, const Given& settings, double dt) noexcept {
        below_speed_ = inputs.at_speed ? 0 : std::min(below_speed_ + dt, 1e9);
        const Now now = judged(inputs, dt);
        take_words(settings);
        stand(now, dt);
        obey(now, dt);
        take_settings(dt);
        hold_ = hold(inputs);
        feed(now, dt);
        generate(now, dt);
        supervise(now, dt);
        report(now);
    }

    DeadPointLearning& change_learning() noexcept { return supervision_.change_learning(); }
    void forget() noexcept { supervision_.forget(); }
    const StrokeMotion& motion() const noexcept { return motion_; }
    const StrokeSupervision& supervision() const noexcept { return supervision_; }
    const StrokeWords& words() const noexcept { return words_; }
    const StrokeSettings& values() const noexcept { return in_force_.values(); }  // in force

    double position() const noexcept { return position_; }  // point R: the last good one
    double offset() const noexcept { return offset_.value(); }
    double command() const noexcept { return position_ + offset_.value(); }
    double measured() const noexcept { return measured_; }  // the last good one
    // From point R, or with an infeed. Where nothing drives an extra joint it stands within max-beyond of its
    // command.
    bool away() const noexcept {
        const double within = by_stage_ ? 0 : values().max_beyond;
        return std::abs(offset_.value()) > std::max(within, StrokeOffset::nothing) || infeed_.value() != 0;
    }
    const Infeed& infeed() const noexcept { return infeed_; }
    bool at_end() const noexcept { return !motion_.moves() && !away(); }
    bool moves() const noexcept { return motion_.moves() || infeed_.moves(); }
    bool place_known() const noexcept { return place_.known(); }  // of an extra joint
    bool stands_off() const noexcept { return standing_off_.stands(); }
    double stands_off_by() const noexcept { return standing_off_.distance(); }
    // Moves of a program have to wait.
    bool busy() const noexcept { return busy_; }
    bool hold_ordered() const noexcept { return hold_ordered_; }
    bool refused() const noexcept { return words_.refused() || faults_.checked() != Fault::none; }
    Bound bound() const noexcept { return bounds_.bound(); }
    Fault fault() const noexcept { return fault_; }

private:
    static constexpr std::size_t nodes = 64;  // to plan in a period
    static constexpr double answer_time = 2;  // s, in which the end of a program is seen

    // All that the next stroke depends on.
    struct Planned {
        std::uint32_t settings = 0, learning = 0;  // changes
        double end = 0;

        bool operator==(const Planned& other) const noexcept {
            return settings == other.settings && learning == other.learning && end == other.end;
        }
    };

    // The inputs of a period, judged.
    struct Now {
        const Inputs& given;
        StrokeOrders::Now orders;
        bool known;       // the position
        bool measurable;  // the axis
        double measured, applied;
    };

    Now judged(const Inputs& given, double dt) noexcept {
        words_.watch_program(given.orders.program_running, dt);
        words_.step(given.word, given.word_value, motion_.moves());
        const double applied = given.released ? 0.0 : given.applied;
        position_ = usable(given.position, farthest, position_);
        StrokeOrders::Now orders = orders_.step(given.orders, dt);
        orders.returns |= words_.returns();
        orders.shifts |= words_.shifts();
        return {given,
                orders,
                std::abs(given.position) <= farthest,
                std::abs(given.joint) <= farthest && std::abs(applied) <= farthest,
                given.joint + applied,
                applied};
    }

    // The words of a program go before the settings. The stroking axis stands where the other one feeds in.
    void take_words(const Given& settings) noexcept {
        changed_ = std::exchange(first_, false) || settings.changed || words_.changes();
        if (!changed_) return;
        given_ = settings.stroke;
        words_.replace(given_);
        has_infeed_ = settings.infeed != nullptr;
        if (!has_infeed_) return;
        infeed_given_ = *settings.infeed;
        words_.replace(infeed_given_);
        if (infeed_given_.wanted() && given_.exact_stop == 0) given_.exact_stop = given_.max_beyond;
    }

    bool ready(const Now& now) const noexcept { return now.given.on && now.given.homed && place_.known(); }

    // An extra joint is where its axis is while its drive is off. LinuxCNC knows the place of a joint with a
    // stage.
    void stand(const Now& now, double dt) noexcept {
        const Inputs& given = now.given;
        const bool moved = std::exchange(last_position_, position_) != position_;
        by_stage_ |= given.releasable || std::abs(now.applied) > StrokeOffset::nothing ||
                     (!given.on && moved && std::abs(position_ - given.joint) <= StrokeOffset::nothing);
        if (by_stage_) return;
        if (!place_.step({given.on, given.homed, motion_.moves(), now.measurable, now.measured, command(),
                          values().max_following_error, motion_.oscillation().speed()},
                         dt))
            return;
        if (motion_.moves()) freeze();
        offset_.put(place_.place() - position_);
    }

    void obey(const Now& now, double dt) noexcept {
        const StrokeOrders::Now& orders = now.orders;
        if (!now.given.homed) supervision_.accept();
        const bool asked = words_.checks();
        faults_.check(asked, asked ? refusal(now, words_.checked(), dt) : Fault::none, place_.known());
        if (motion_.moves() && !now.given.on) freeze();
        if (motion_.moves() && !ready(now)) {
            if (!now.given.homed) faults_.happen(Fault::unhomed);
            motion_.fail();
        }
        if (now.given.released) release();
        const bool late = orders.starts && (motion_.moves() || orders.returns);
        if (late && !motion_.failed()) faults_.happen(Fault::withdrawing);
        leaves_ = values().clear() != Oscillation::Stop::none && (orders.ended || words_.aborts());
        watch_wheel(now, dt);
        if (orders.starts && !late) start(now, dt);
        if (orders.returns && !motion_.moves() && ready(now) && now.known) return_to_end(now, dt);
        if (orders.shifts && motion_.moves()) take_over(dt);
    }

    // The axis leaves the work when its spindle stops or loses its speed, also in spark-out strokes. A lost
    // speed is a fault at once. An abort and the end of a program stop the spindle, too: a stopped spindle is
    // a fault when the program still orders strokes some time later.
    void watch_wheel(const Now& now, double dt) noexcept {
        using State = StrokeMotion::State;
        const bool strokes = motion_.state() == State::stroking || motion_.state() == State::stopping;
        const bool slow = now.given.spindle_on && below_speed_ > values().at_speed_time;
        if (strokes && !motion_.failed() && !values().without_wheel && (slow || !now.given.spindle_on)) {
            leaves_ = wheel_lost_ = true;
            lost_for_ = 0;
            if (slow) faults_.happen(Fault::wheel_lost);
        }
        if (!wheel_lost_ || !now.orders.ordered) return;
        lost_for_ += dt;
        if (lost_for_ >= answer_time) faults_.happen(Fault::wheel_lost);
    }

    void start(const Now& now, double dt) noexcept {
        Fault reason = !now.orders.runs ? Fault::not_ready : refusal(now, position_, dt);
        if (reason == Fault::none)
            reason = now.known ? in_force_.take(given_, position_, dt) : Fault::position;
        faults_.happen(reason);
        wheel_lost_ = false;
        if (reason != Fault::none) return;
        standing_off_.end();
        in_force_.begin_strokes();
        supervision_.select(in_force_);
        supervision_.begin(seen(now));
        motion_.start(wanted(), position_ + offset_.rest(), command_in_force(dt));
        started_ = true;
    }

    // Of a stroke that is to begin at an end.
    Fault refusal(const Now& now, double end, double dt) const noexcept {
        if (!ready(now) || !now.orders.permitted) return Fault::not_ready;
        // It is asked whether the scale is right before its dead points are learned.
        if (given_.learn && supervision_.slipped()) return Fault::slips;
        Fault reason = given_.refusal(given_.low(), given_.high(), end, dt);
        if (reason == Fault::none && has_infeed_ && !infeed_given_.possible(now.given.infeed.position))
            reason = Fault::infeed;
        const bool turns = given_.without_wheel || (now.given.spindle_on && now.given.at_speed);
        return reason == Fault::none && !turns ? Fault::wheel_stands : reason;
    }

    void return_to_end(const Now& now, double dt) noexcept {
        if (!in_force_.take_end(given_, position_, dt)) return;
        supervision_.begin(seen(now));
        motion_.return_to_end(wanted(), position_ + offset_.rest(), command_in_force(dt));
    }

    void take_over(double dt) noexcept {
        const Fault reason = in_force_.take(given_, position_, dt);
        if (reason != Fault::none) return faults_.happen(reason);
        supervision_.select(in_force_);
        supervision_.pause();
    }

    // The drive is off: nothing moves, and nothing will by itself.
    // A machine that is switched off stops its spindle, too.
    void freeze() noexcept {
        offset_.freeze();
        motion_.freeze(command());
        wheel_lost_ = false;
    }

    // Motion has taken over the place of the axis.
    void release() noexcept {
        standing_off_.begin(offset_.value());
        offset_.release();
        motion_.freeze(position_);
    }

    void take_settings(double dt) noexcept {
        const StrokeMotion::Command& its = motion_.command();
        if (in_force_.judge(given_, changed_, {position_, motion_.moves(), its.lead, its.jerk_time}, dt))
            supervision_.select(in_force_);
        guard(dt);
    }

    void guard(double dt) noexcept {
        const StrokeSettings& values = in_force_.values();
        const double planned = motion_.moves() ? motion_.oscillation().planned_acceleration() : 0;
        const double hardest = std::max(values.max_acceleration, planned);
        offset_.allow({values.max_offset, values.max_rate, guard_factor * hardest}, motion_.moves(), farthest,
                      dt);
    }

    StrokeMotion::Command command_in_force(double dt) const noexcept {
        const StrokeSettings& values = in_force_.values();
        return {values.lead, values.jerk_time, values.jerk_samples(dt)};
    }

    // Makes the settings of the next stroke again, where those in force, point R or learning have changed.
    // True if it did.
    bool plan() noexcept {
        const Planned now{in_force_.changes(), supervision_.changes(), position_};
        if (now == planned_) return false;
        planned_ = now;
        wanted_ = in_force_.stroke(supervision_.part(in_force_.values()), position_);
        if (in_force_.values().learn) supervision_.learning().restrain(wanted_);
        return true;
    }
    const Oscillation::Settings& wanted() noexcept {
        plan();
        return wanted_;
    }

    StrokeSupervision::Seen seen(const Now& now) const noexcept {
        return {now.measurable, now.measured, command(), now.given.motor};
    }

    // Nothing feeds in while the ends of the strokes are not known, or anything is wrong with them.
    void feed(const Now& now, double dt) noexcept {
        using State = StrokeMotion::State;
        const bool starts = std::exchange(started_, false);
        if (!has_infeed_ || (!infeed_given_.in_range && infeed_.idle())) return;
        const Oscillation& oscillation = motion_.oscillation();
        const StrokeSettings& values = in_force_.values();
        const bool turns = values.without_wheel || (now.given.spindle_on && now.given.at_speed);
        Infeed::Now its;
        its.on = now.given.on;
        its.starts = starts;
        its.returns = now.orders.returns;
        its.aborts = words_.aborts();
        its.strokes = (motion_.state() == State::stroking || motion_.state() == State::stopping) &&
                      !motion_.failed() && !leaves_ && now.orders.permitted && !oscillation.ends();
        its.permitted = motion_.state() == State::stroking && now.orders.runs &&
                        hold_ == Oscillation::Stop::none && turns && now.known && now.measurable &&
                        !oscillation.sparking_out() && (!values.learn || supervision_.learning().learned()) &&
                        !bounds_.hinders_infeed();
        its.runs = oscillation.state() == Oscillation::State::stroke;
        its.upward = oscillation.upward();
        its.arrived = oscillation.arrival().happened && oscillation.arrival().infeed;
        its.stands = oscillation.settled();
        its.ends = now.given.infeed.ends;
        its.position = now.given.infeed.position;
        its.measured = now.given.infeed.measured;
        its.applied = now.given.infeed.applied;
        infeed_.step(its, infeed_given_, dt);
        motion_.oscillation().wait_for_infeed(infeed_.waits());
    }

    void generate(const Now& now, double dt) noexcept {
        const StrokeSettings& values = in_force_.values();
        const bool moved = motion_.moves(), changed = plan();
        motion_.oscillation().see_axis(
            !(values.exact_stop > 0) ||
            (now.measurable &&
             std::abs(now.measured - motion_.oscillation().position()) <= values.exact_stop));
        motion_.step(
            {now.orders.runs && !infeed_.done(), now.orders.permitted, leaves_, now.orders.returns, hold_,
             now.orders.runs ? values.ending() : values.stop(), now.given.trial_over, changed},
            wanted_, dt, nodes, [&](bool upper, double reversal, double speed, double way) {
                return values.learn ? supervision_.learning().offset(upper, reversal, speed, way) : 0;
            });
        StrokeOffset::Period period;
        period.moves = motion_.moves();
        period.ends = moved && !period.moves;
        period.command = motion_.leading().position() - position_;
        period.mean = motion_.leading().mean() - position_;
        period.on = now.given.on;
        period.homed = now.given.homed;
        period.ramps = by_stage_ && !now.given.releasable;
        offset_.step(period, dt);
    }

    Oscillation::Stop hold(const Inputs& given) noexcept {
        const StrokeSettings& values = in_force_.values();
        hold_ordered_ = given.emergency_hold || given.feed_hold;
        if (given.emergency_hold || supervision_.recovers()) return Oscillation::Stop::at_once;
        return given.feed_hold || values.override_ == 0 ? values.hold() : Oscillation::Stop::none;
    }

    void supervise(const Now& now, double dt) noexcept {
        const StrokeSupervision::Findings found = supervision_.step(seen(now), motion_, in_force_, dt);
        if (found.fault != Fault::none && !motion_.failed()) faults_.happen(found.fault);
        if (found.stops) motion_.fail();
        if (found.corrected) motion_.oscillation().refresh();
    }

    void report(const Now& now) noexcept {
        const bool runs = motion_.moves();
        const Oscillation& oscillation = motion_.oscillation();
        busy_ =
            (runs ? !now.orders.ordered : motion_.failed() && away()) || (now.orders.ordered && wheel_lost_);
        if (now.measurable) measured_ = now.measured;
        if (!now.given.homed) standing_off_.end();
        standing_off_.step(position_, now.given.on);
        StrokeBounds::Active active;
        active.offset = offset_.kept_back();
        active.stage = now.given.stage_limited;
        active.soft_limit = oscillation.clipped();
        active.learning = supervision_.part(in_force_.values()) < 1;
        active.speed = oscillation.limited();
        active.arrival = oscillation.impatient();
        active.late = oscillation.late();
        active.infeed_cut = infeed_.cut();
        active.infeed_late = infeed_.late();
        bounds_.step(active, runs);
        fault_ = !place_.known()
                     ? Fault::place_lost
                     : faults_.first({!now.known, in_force_.refused(), offset_.refused(),
                                      supervision_.fault(in_force_.values(), runs && !now.measurable)});
    }

    StrokeOrders orders_;
    StrokeWords words_;
    StrokeInForce in_force_;
    StrokeMotion motion_;
    StrokeSupervision supervision_;
    StrokeFaults faults_;
    StrokeBounds bounds_;
    StrokeOffset offset_;
    StandingOff standing_off_;
    AxisPlace place_;
    Infeed infeed_;
    bool by_stage_ = false;  // the joint has the offset by a stage
    double last_position_ = 0;
    double position_ = 0, measured_ = 0;
    Oscillation::Stop hold_ = Oscillation::Stop::none;
    StrokeSettings given_;  // with the words of the program
    Infeed::Settings infeed_given_;
    Planned planned_;
    Oscillation::Settings wanted_;
    bool first_ = true, changed_ = false, has_infeed_ = false;
    bool started_ = false;  // in this period
    bool busy_ = false, hold_ordered_ = false;
    bool leaves_ = false;      // the work, ordered in this period
    bool wheel_lost_ = false;  // since the start
    double lost_for_ = 0;      // s, while the program goes on
    double below_speed_ = 0;   // s, of the spindle
    Fault fault_ = Fault::none;
};

}  // namespace plumb
