// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/oscillation_settings.hpp"
#include "components/math/oscillation/stroke_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// An oscillating axis: strokes between two dead points, with sections, dwell, a number of strokes, spark-out,
// start anywhere, stops and hold. Each stroke begins and ends at rest and is planned while the one before it
// runs. A change of region, speed or sections comes with the next stroke that is not planned yet: a new upper
// dead point with an upward stroke, a new lower one with a downward stroke, so that no position or speed
// steps. All positions are in mu.
class Oscillation {
public:
    using Settings = OscillationSettings;
    using Stop = Settings::Stop;
    using Arrival = OscillationLeg::Arrival;
    enum class State { rest, waiting, stroke, braking };

    // From rest at a position. Settings are valid: lower < upper, speeds and accelerations above 0.
    void start(const Settings& settings, double position) noexcept {
        settings_ = settings;
        changed_ = stops_ = held_ = settles_ = impatient_ = false;
        legs_[running_] = {};
        last_acceleration_ = 0;
        late_ = limited_[0] = limited_[1] = arrival_.happened = false;
        position_ = position;
        velocity_ = acceleration_ = 0;
        state_ = State::waiting;
        stop_ = Stop::none;
        strokes_ = sparks_ = 0;
        lower_ = settings.lower;
        upper_ = settings.upper;
        wait_ = 0;
        time_ = 0;
        restart_upward_ = settings.upward_first;
        begin_plan(Kind::first);
    }

    // For the next stroke that is not planned yet. Does nothing if nothing has changed.
    void set(const Settings& settings) noexcept {
        if (settings == settings_) return;
        settings_ = settings;
        changed_ = true;
    }

    // The learned ends have changed.
    void refresh() noexcept { changed_ = true; }

    // After a withdrawal has begun, only a stop at once changes it, and an order to leave.
    void stop(Stop kind) noexcept {
        if (state_ == State::rest || kind == stop_) return;
        if (withdraws() && kind != Stop::at_once && kind != Stop::leave) return;
        stop_ = kind;
        changed_ = stops_ = true;
        if (!withdraws()) return;
        wait_ = std::min(wait_, time_);  // no dwell
        settles_ = false;
    }

    // Whether the axis itself is where the command is, for an exact stop.
    void see_axis(bool there) noexcept { there_ = there; }
    // No stroke begins until an infeed has ended.
    void wait_for_infeed(bool waits) noexcept { infeeds_ = waits; }

    // To the end position from rest.
    void go_to_end(const Settings& settings, double position) noexcept {
        start(settings, position);
        stop_ = Stop::withdraw;
        begin_plan(Kind::closing);
    }

    // Out of the work from rest.
    void leave(const Settings& settings, double position) noexcept {
        start(settings, position);
        stop_ = Stop::leave;
    }

    // Rests at a position, at once: the drive is off.
    void freeze(double position) noexcept {
        state_ = State::rest;
        held_ = false;
        position_ = position;
        velocity_ = acceleration_ = 0;
    }

    // One period of dt s. `nodes` is the largest number of nodes to plan in it. `hold` holds: at_once, at the
    // next dead_point or at the end_position.
    template <class Learned>
    void step(double dt, Stop hold, std::size_t nodes, const Learned& learned) noexcept {
        arrival_.happened = false;
        if (state_ == State::rest) return;
        period_ = dt;
        take_hold(hold);
        replan(nodes, learned);
        planner_.step(pace_);
        time_ += dt;
        if (state_ == State::stroke) run_stroke(dt);
        if (state_ == State::braking) run_braking();
        if (state_ == State::waiting) wait();
        show();
    }

    State state() const noexcept { return state_; }
    double position() const noexcept { return position_; }
    double velocity() const noexcept { return velocity_; }          // mu/s
    double acceleration() const noexcept { return acceleration_; }  // mu/s2
    double phase() const noexcept { return phase_; }                // rad, 0 to 2 pi
    const Arrival& arrival() const noexcept { return arrival_; }    // in this period
    std::int32_t strokes() const noexcept { return strokes_; }
    bool sparking_out() const noexcept { return state_ != State::rest && leg().sparks; }
    bool held() const noexcept { return held_; }
    // Mu/s2, the largest of the leg that runs and of the last one, whatever the settings are now.
    double planned_acceleration() const noexcept { return std::max(leg().acceleration, last_acceleration_); }
    // On the way to the end position.
    bool closing() const noexcept { return state_ == State::stroke && leg().kind == Kind::closing; }
    // On this way, and not for a hold.
    bool ends() const noexcept { return closing() && !leg().pauses; }
    // It waits at a dead point, and the exact stop is over.
    bool settled() const noexcept { return state_ == State::waiting && !settles_; }
    // A section or the stroke does not reach its speed.
    bool limited() const noexcept { return limited_[0] || limited_[1]; }
    bool clipped() const noexcept { return leg().clipped; }                       // by the soft limits
    double stroke_time(bool upward) const noexcept { return duration_[upward]; }  // s, of the last plan
    // S, at most, until the axis is out of the work: both strokes, as the way back after a turn is a slower
    // one.
    double longest_way_out() const noexcept {
        const double crank = pi * (upper_ - lower_) / (2 * std::max(settings_.speed, nothing));
        return std::max(duration_[0], crank) + std::max(duration_[1], crank);
    }
    const StrokePlan& plan() const noexcept { return plans_[running_]; }  // that runs, or ran last
    bool upward() const noexcept { return plan().upward(); }
    double speed() const noexcept { return leg().arrival.speed; }  // mu/s, peak of the present stroke
    bool second_half() const noexcept { return state_ == State::stroke && time_ > plan().duration() / 2; }
    bool late() const noexcept { return late_; }  // a plan was not ready at a dead point
    // The axis was not at the last dead point within the time of the exact stop.
    bool impatient() const noexcept { return impatient_; }

private:
    using Kind = OscillationLeg::Kind;

    const OscillationLeg& leg() const noexcept { return legs_[running_]; }
    const OscillationLeg& next() const noexcept { return legs_[1 - running_]; }

    Stop ending() const noexcept { return stop_ == Stop::none ? settings_.ending : stop_; }

    // A hold at the end position, and its end, plan another way.
    void take_hold(Stop hold) noexcept {
        if (hold == hold_) return;
        if (hold == Stop::end_position || hold_ == Stop::end_position) changed_ = stops_ = true;
        hold_ = hold;
    }

    // Whether it goes to the end position for a hold, from there. An axis that has not left its start stays.
    bool pauses_from(double position) const noexcept {
        return hold_ == Stop::end_position && stop_ == Stop::none && leg().kind != Kind::none &&
               !is_end(position);
    }

    static bool is_chosen(Stop stop) noexcept { return stop == Stop::lower || stop == Stop::upper; }

    // Whether the strokes may end where the leg that runs ends, or that ran last.
    bool may_end() const noexcept {
        return !is_chosen(ending()) || leg().arrival.upper == (ending() == Stop::upper);
    }

    double end() const noexcept {
        return std::clamp(settings_.end_position, settings_.lowest, settings_.highest);
    }

    bool is_end(double position) const noexcept { return std::abs(end() - position) <= nothing; }

    bool withdraws() const noexcept { return stop_ == Stop::withdraw || stop_ == Stop::leave; }
    bool leaves() const noexcept { return stop_ == Stop::leave && settings_.clear != Stop::none; }

    // Whether a withdrawal goes by the upper dead point: it is clear of the work, or nearest the end.
    bool by_upper() const noexcept {
        return leaves() ? settings_.clear == Stop::upper
                        : std::abs(upper_ - end()) <= std::abs(lower_ - end());
    }
    // Whether it rests there, as the end is not clear of the work.
    bool rests_clear() const noexcept {
        return leaves() && (by_upper() ? end() < upper_ - nothing : end() > lower_ + nothing);
    }

    // Whether a withdrawal goes to the end next, or rests: from that dead point, or from beyond it.
    bool closes_from(double position) const noexcept {
        const bool upper = by_upper();
        if (next_ == Kind::regular) return leg().homeward || leg().arrival.upper == upper;
        const double near = nothing + (leaves() ? leg().margin() : 0);
        return (is_end(position) && !rests_clear()) ||
               (upper ? position >= upper_ - near : position <= lower_ + near);
    }

    // Whether the axis goes deeper into the work that it is to leave.
    bool turns_back() const noexcept {
        return leaves() && leg().kind != Kind::closing && plan().upward() != by_upper();
    }

    // Begins to plan the next leg, once for each, and again when something has changed while there is time.
    template <class Learned>
    void replan(std::size_t nodes, const Learned& learned) noexcept {
        if (!due_ && !changed_) return;
        if (!due_ && !stops_ && planner_.busy()) return;  // a change in each period makes no plan in each
        const bool waits = state_ == State::waiting;
        const double left = (waits                      ? wait_ - time_
                             : state_ == State::braking ? braking_.duration() - time_
                                                        : plan().duration() - time_ + wait_after()) /
                            period_;
        const auto work = static_cast<double>(StrokePlanner::most_work), most = static_cast<double>(nodes);
        const bool late = !due_ && left < work / most + 2;
        if ((state_ == State::braking && !braking_turns_) || (late && !(waits && (held_ || stops_)))) return;
        due_ = changed_ = stops_ = false;
        // Half of the time, so that a change comes with the next stroke.
        pace_ = static_cast<std::size_t>(std::clamp(std::ceil(2 * work / std::max(left, 1.0)), 1.0, most));
        plan_next(learned);
    }

    void begin_plan(Kind kind) noexcept {
        next_ = kind;
        due_ = true;
    }

    // As planned: an end beyond the dead point must not become one at which the axis dwells, and creeps.
    double wait_after() const noexcept { return withdraws() ? 0 : leg().dwell; }

    // Chooses the leg after the one that runs, or the one that is waited for.
    template <class Learned>
    void plan_next(const Learned& learned) noexcept {
        const bool runs = state_ == State::stroke;
        const double from = runs ? plan().to() : state_ == State::braking ? braking_.end() : position_;
        bool upward = !this->upward();
        OscillationLeg& leg = legs_[1 - running_];
        leg = {};
        leg.kind = next_;
        leg.settings = settings_;
        if (withdraws()) {
            leg.homeward = (leg.kind != Kind::closing || rests_clear()) && !closes_from(from);
            if (!leg.homeward)
                leg.kind = rests_clear() ? Kind::none : Kind::closing;
            else if (leg.kind == Kind::closing)
                leg.kind = Kind::first;
            upward = by_upper();
        } else if (leg.kind != Kind::closing && pauses_from(from)) {
            leg.kind = Kind::closing;
            leg.pauses = true;
        } else if (leg.kind == Kind::first) {
            upward =
                from <= settings_.lower + nothing || (from < settings_.upper - nothing && restart_upward_);
            if (is_chosen(stop_)) {
                upward = stop_ == Stop::upper;
                if (upward ? from >= upper_ - nothing : from <= lower_ + nothing) leg.kind = Kind::none;
            } else if (stop_ != Stop::none) {
                leg.kind = stop_ == Stop::end_position ? Kind::closing : Kind::none;
            }
        } else if (leg.kind == Kind::regular && stop_ != Stop::at_once) {
            const std::int32_t strokes = strokes_ + (runs && this->leg().kind == Kind::regular);
            const std::int32_t sparks = sparks_ + (runs && this->leg().sparks);
            if (stop_ != Stop::none || (settings_.strokes > 0 && strokes >= settings_.strokes)) {
                leg.sparks = sparks < settings_.spark_out || !may_end();
                if (!leg.sparks) leg.kind = ending() == Stop::end_position ? Kind::closing : Kind::none;
            }
        }
        if (leg.kind == Kind::closing && is_end(from)) leg.kind = Kind::none;
        if (leg.kind == Kind::none && runs && this->leg().ends_outside() && !can_stop_at_bound())
            leg.kind = rests_clear() ? Kind::closing : Kind::regular;
        if (leg.kind == Kind::none) return;
        const bool leaves_outside =
            next_ == Kind::regular && this->leg().kind == Kind::regular && this->leg().ends_outside();
        Settings now = leaves_outside ? this->leg().settings : settings_;
        if (leg.homeward) {  // to a dead point in force: a withdrawal takes over no other
            now.lower = lower_;
            now.upper = upper_;
        }
        leg.acceleration = now.acceleration * now.braking;
        leg.comes_in = leaves_outside && leg.kind == Kind::closing;
        StrokeRequest request;
        if (leg.kind != Kind::closing)
            request = leg.to_dead_point({from, lower_, upper_, upward}, now, settings_, learned);
        else if (leaves_outside && (rests_clear() || !this->leg().leads_to(end())))
            request = OscillationLeg::inward({from, lower_, upper_}, now);
        else
            request = OscillationLeg::to_position(from, end(), now);
        if (leg.near && leg.kind == Kind::first && stop_ == Stop::none)
            request = leg.to_dead_point({from, lower_, upper_, !upward}, now, settings_, learned);
        planner_.begin(request, plans_[1 - running_]);
    }

    // Takes up the planned leg. `late` is the time by which the dead point has passed already.
    void take_up(double late) noexcept {
        last_acceleration_ = leg().acceleration;
        running_ = 1 - running_;
        state_ = State::stroke;
        time_ = late;
        held_ = false;
        const bool upward = plan().upward();
        limited_[upward] = plan().limited() && leg().kind == Kind::regular;
        duration_[upward] = plan().duration();
        if (leg().kind != Kind::closing) (upward ? upper_ : lower_) = leg().arrival.bound;
        if (leg().kind == Kind::first && !leg().homeward)
            (upward ? lower_ : upper_) = upward ? settings_.lower : settings_.upper;
        begin_plan(leg().kind != Kind::closing ? Kind::regular : leg().pauses ? Kind::first : Kind::closing);
    }

    void run_stroke(double dt) noexcept {
        if (time_ < plan().duration()) {
            const StrokePlan::Moment now = plan().at(time_, node_);
            move_to(now);
            const bool ends = next().kind == Kind::none && !due_;
            if (hold_ == Stop::at_once || stop_ == Stop::at_once)
                brake(now, leg().acceleration, stop_ != Stop::at_once);
            else if (turns_back())
                brake(now, leg().acceleration, false);
            else if ((ends || hold_ == Stop::dead_point) && leg().ends_outside())
                brake_to_bound(now, dt, !ends);
            return;
        }
        time_ -= plan().duration();
        position_ = plan().to();
        state_ = State::waiting;
        wait_ = wait_after();
        settles_ = !withdraws() && leg().exact_stop > 0;
        if (leg().kind == Kind::closing) return;
        if (leg().kind == Kind::regular) ++strokes_;
        if (leg().sparks) ++sparks_;
        arrival_ = leg().arrival;
        arrival_.happened = true;
        arrival_.length = std::abs(plan().to() - plan().from());
        arrival_.infeed = !leg().sparks && !withdraws();
    }

    // Brakes, if it then rests in the region, where the axis may stand, or, before the first dead point, on
    // the way there.
    void brake(const StrokePlan::Moment& now, double acceleration, bool holds) noexcept {
        const Braking braking(now, acceleration);
        const double margin = 2 * leg().margin();  // it brakes harder than at a turn
        const double low = lower_ + margin, high = upper_ - margin;
        const double from = leg().kind == Kind::regular ? low : plan().from(), end = braking.end();
        // An axis turns where its end was learned only if its command then leaves it as planned.
        const bool left = leg().kind != Kind::regular ||
                          (plan().upward() ? now.position >= low - nothing : now.position <= high + nothing);
        const bool inside =
            left && end >= std::min(from, low) - nothing && end <= std::max(from, high) + nothing;
        const bool still_outside = leg().comes_in && (plan().upward() ? end < lower_ : end > upper_) &&
                                   plan().upward() == (plan().from() < lower_);
        if (leg().kind == Kind::closing ? !still_outside : inside) begin_braking(braking, holds);
    }

    // The deceleration that ends where the axis may stand.
    double needed(const StrokePlan::Moment& now) const noexcept {
        const double way = leg().arrival.bound - now.position;
        return Braking::needed((plan().upward() ? way : -way) - leg().margin(), std::abs(now.velocity));
    }

    // In this period, to which time_ has not advanced yet.
    bool can_stop_at_bound() const noexcept {
        std::size_t node = node_;
        return needed(plan().at(time_ + period_, node)) <= leg().acceleration;
    }

    // At the last moment at which it can stop at the dead point, where the stroke itself ends beyond.
    void brake_to_bound(const StrokePlan::Moment& now, double dt, bool holds) noexcept {
        const double deceleration = needed(now);
        if (deceleration > leg().acceleration || needed(plan().at(time_ + dt, node_)) <= leg().acceleration)
            return;
        begin_braking({now, deceleration}, holds);
        strokes_ += leg().kind == Kind::regular;
    }

    void begin_braking(const Braking& braking, bool holds) noexcept {
        state_ = State::braking;
        braking_ = braking;
        holding_ = holds;
        braking_turns_ = turns_back();
        if (braking_turns_) begin_plan(Kind::first);
        restart_upward_ = upward();
        time_ = 0;
    }

    void run_braking() noexcept {
        move_to(braking_.at(time_));
        if (time_ < braking_.duration()) return;
        if (stop_ == Stop::at_once || (!holding_ && !withdraws())) {
            state_ = State::rest;
            return;
        }
        state_ = State::waiting;
        wait_ = 0;
        time_ = 0;
        if (!braking_turns_)
            begin_plan(leg().kind == Kind::closing && !leg().pauses ? Kind::closing : Kind::first);
    }

    void wait() noexcept {
        velocity_ = acceleration_ = 0;
        const bool stands = next_ != Kind::regular || !leg().ends_outside();
        const bool inside = stands && position_ >= lower_ - nothing && position_ <= upper_ + nothing;
        due_ |= withdraws() && !next_withdraws();
        if ((stop_ == Stop::at_once && inside) || (next().kind == Kind::none && !due_)) {
            state_ = State::rest;
            return;
        }
        settle();
        held_ = holds(inside);
        if (held_) {
            time_ = std::min(time_, wait_);
            return;
        }
        late_ = !settles_ && time_ >= wait_ && next_ == Kind::regular && !pauses_from(position_) &&
                (due_ || planner_.busy());
        const bool infeeds = infeeds_ && !withdraws();
        if (infeeds || due_ || planner_.busy()) wait_ = std::max(wait_, time_);
        if (settles_ || infeeds || due_ || planner_.busy() || time_ < wait_) return;
        take_up(time_ - wait_);
        move_to(plan().at(time_, node_));
    }

    // Whether the axis stands for a hold where it waits.
    bool holds(bool inside) const noexcept {
        if (hold_ == Stop::none) return false;
        if (hold_ == Stop::end_position)
            return is_end(position_) || (stop_ == Stop::none && leg().kind == Kind::none);
        return inside || next_ != Kind::regular;
    }

    // The dwell begins when the axis is there, or when the time of the exact stop has passed.
    void settle() noexcept {
        if (!settles_) return;
        settles_ = !there_ && time_ < leg().exact_stop;
        if (!settles_) impatient_ = !there_;
        wait_ = time_ + leg().dwell;
    }

    // Whether the next leg is one of a withdrawal, which may have come too late for it. At an end that lies
    // outside, and from which the end is inward, the axis must not wait for another: a cycle more, then.
    bool next_withdraws() const noexcept {
        if (next().kind == Kind::closing) return true;
        if (next().kind == Kind::none) return rests_clear() ? closes_from(position_) : is_end(position_);
        return !closes_from(position_) || (leg().ends_outside() && !leg().leads_to(end()));
    }

    void move_to(const StrokePlan::Moment& now) noexcept {
        position_ = now.position;
        velocity_ = now.velocity;
        acceleration_ = now.acceleration;
    }

    void show() noexcept {
        if (state_ == State::stroke || state_ == State::braking)
            phase_ = plan().shape().phase(position_, plan().upward());
        else if (state_ == State::waiting && arrival_.happened)
            phase_ = arrival_.upper ? pi : 0;
    }

    static constexpr double nothing = OscillationLeg::nothing;

    Settings settings_;
    State state_ = State::rest;
    Stop stop_ = Stop::none, hold_ = Stop::none;
    StrokePlan plans_[2];     // of the leg that runs, and of the next one
    OscillationLeg legs_[2];  // in the same order
    int running_ = 0;
    std::size_t node_ = 0;  // of the plan that runs, at this moment
    StrokePlanner planner_;
    std::size_t pace_ = 1;                                // nodes to plan in a period
    Kind next_ = Kind::none;                              // after the leg that runs, without a stop
    bool due_ = false, changed_ = false, stops_ = false;  // the next leg is not planned; by old settings
    Arrival arrival_;
    Braking braking_;
    double period_ = 0.001, time_ = 0, wait_ = 0;  // s; time_ since the leg or the wait began
    double position_ = 0, velocity_ = 0, acceleration_ = 0, phase_ = 0;
    double lower_ = 0, upper_ = 0;  // dead points in force
    double duration_[2] = {0, 0};
    double last_acceleration_ = 0;
    bool limited_[2] = {false, false};  // downward, upward
    std::int32_t strokes_ = 0, sparks_ = 0;
    bool restart_upward_ = false, holding_ = false, held_ = false, late_ = false;
    bool braking_turns_ = false;  // back, and the leg after it is planned meanwhile
    bool there_ = true, settles_ = false, impatient_ = false;  // the axis, at an exact stop
    bool infeeds_ = false;
};

}  // namespace plumb
