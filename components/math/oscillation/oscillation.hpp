// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/reciprocation.hpp"
#include "components/math/oscillation/speed_sections.hpp"
#include "components/math/oscillation/stroke_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace plumb {

// An oscillating axis: strokes between two dead points, with sections, dwell, a number of strokes, spark-out,
// start anywhere, stops and hold. Each stroke begins and ends at rest and is planned while the one before it
// runs. A change of region, speed or sections comes with the next stroke that is not planned yet: a new upper
// dead point with an upward stroke, a new lower one with a downward stroke, so that no position or speed
// steps. All positions are in mu.
class Oscillation {
public:
    enum class Stop { none, dead_point, end_position, at_once };
    enum class State { rest, waiting, stroke, braking };

    struct Settings {
        double lower = 0, upper = 0;              // dead points, lower < upper
        double speed = 0;                         // mu/s, peak, with the override
        double acceleration = 0;                  // mu/s2, the largest
        double largest_speed = 0;                 // mu/s
        double lower_dwell = 0, upper_dwell = 0;  // s
        double lowest = 0, highest = 0;           // soft limits
        double end_position = 0;
        std::int32_t strokes = 0;    // 0: until stopped
        std::int32_t spark_out = 0;  // strokes after that
        bool upward_first = false;
        Stop ending = Stop::end_position;  // after the last stroke; dead_point or end_position
        SpeedSections::Table sections{};

        bool operator==(const Settings& other) const noexcept {
            return lower == other.lower && upper == other.upper && speed == other.speed &&
                   acceleration == other.acceleration && largest_speed == other.largest_speed &&
                   lower_dwell == other.lower_dwell && upper_dwell == other.upper_dwell &&
                   lowest == other.lowest && highest == other.highest && end_position == other.end_position &&
                   strokes == other.strokes && spark_out == other.spark_out && ending == other.ending &&
                   upward_first == other.upward_first && sections == other.sections;
        }
    };

    // A dead point that was reached, and how.
    struct Arrival {
        bool happened = false, upper = false;
        bool infeed = false;      // no spark-out
        bool regular = false;     // it ends a stroke from one dead point to the other of the same region
        double bound = 0;         // the dead point
        double offset = 0;        // outward, of the commanded end
        double acceleration = 0;  // of the reversal
        double speed = 0;         // mu/s, peak
    };

    // From rest at a position. Settings are valid: lower < upper, speeds and accelerations above 0.
    void start(const Settings& settings, double position) noexcept {
        settings_ = settings;
        changed_ = stops_ = held_ = false;
        leg_ = Leg::none;
        sparking_ = late_ = limited_[0] = limited_[1] = false;
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
        begin_plan(Leg::first);
    }

    // For the next stroke that is not planned yet. Does nothing if nothing has changed.
    void set(const Settings& settings) noexcept {
        if (settings == settings_) return;
        settings_ = settings;
        changed_ = true;
    }

    // The learned ends have changed.
    void refresh() noexcept { changed_ = true; }

    void stop(Stop kind) noexcept {
        if (state_ == State::rest || kind == stop_) return;
        stop_ = kind;
        changed_ = stops_ = true;
    }

    // To the end position from rest.
    void go_to_end(const Settings& settings, double position) noexcept {
        start(settings, position);
        stop_ = Stop::end_position;
        begin_plan(Leg::closing);
    }

    // Rests at a position, at once: the drive is off.
    void freeze(double position) noexcept {
        state_ = State::rest;
        held_ = false;
        position_ = position;
        velocity_ = acceleration_ = 0;
    }

    // One period of dt s. `nodes` is the largest number of nodes to plan in it; `hold` brakes, and holds.
    template <class Learned>
    void step(double dt, bool hold, std::size_t nodes, const Learned& learned) noexcept {
        arrival_.happened = false;
        if (state_ == State::rest) return;
        period_ = dt;
        replan(nodes, learned);
        planner_.step(pace_);
        time_ += dt;
        if (state_ == State::stroke) run_stroke(hold, dt);
        if (state_ == State::braking) run_braking();
        if (state_ == State::waiting) wait(hold);
        show();
    }

    State state() const noexcept { return state_; }
    double position() const noexcept { return position_; }
    double velocity() const noexcept { return velocity_; }          // mu/s
    double acceleration() const noexcept { return acceleration_; }  // mu/s2
    double phase() const noexcept { return phase_; }                // rad, 0 to 2 pi
    const Arrival& arrival() const noexcept { return arrival_; }    // in this period
    std::int32_t strokes() const noexcept { return strokes_; }
    bool sparking_out() const noexcept { return state_ != State::rest && sparking_; }
    bool held() const noexcept { return held_; }
    bool limited() const noexcept {
        return limited_[0] || limited_[1];
    }                                                   // a section or the stroke does not reach its speed
    bool clipped() const noexcept { return clipped_; }  // by the soft limits
    double stroke_time(bool upward) const noexcept { return duration_[upward]; }  // s, of the last plan
    bool upward() const noexcept { return plan().upward(); }
    bool second_half() const noexcept { return state_ == State::stroke && time_ > plan().duration() / 2; }
    bool late() const noexcept { return late_; }  // a plan was not ready at a dead point

private:
    enum class Leg { none, first, regular, closing };

    const StrokePlan& plan() const noexcept { return plans_[running_]; }

    Stop ending() const noexcept { return stop_ == Stop::none ? settings_.ending : stop_; }

    // Begins to plan the next leg, once for each, and again when something has changed while there is time.
    template <class Learned>
    void replan(std::size_t nodes, const Learned& learned) noexcept {
        if (!due_ && !changed_) return;
        const bool waits = state_ == State::waiting;
        const double left = (waits ? wait_ - time_ : plan().duration() - time_ + wait_after()) / period_;
        const auto work = static_cast<double>(StrokePlanner::most_work), most = static_cast<double>(nodes);
        const bool late = !due_ && left < work / most + 2;
        if (state_ == State::braking || (late && !(waits && (held_ || stops_)))) return;
        due_ = changed_ = stops_ = false;
        // Half of the time, so that a change comes with the next stroke.
        pace_ = static_cast<std::size_t>(std::clamp(std::ceil(2 * work / std::max(left, 1.0)), 1.0, most));
        plan_next(learned);
    }

    void begin_plan(Leg leg) noexcept {
        next_ = leg;
        due_ = true;
    }

    // As planned: an end beyond the dead point must not become one at which the axis dwells, and creeps.
    double wait_after() const noexcept { return leg_ == Leg::closing ? 0 : dwell_; }

    // Chooses the leg after the one that runs, or the one that is waited for.
    template <class Learned>
    void plan_next(const Learned& learned) noexcept {
        const bool runs = state_ == State::stroke;
        const double from = runs ? plan().to() : position_;
        bool upward = !this->upward();
        wanted_ = next_;
        next_sparks_ = false;
        if (wanted_ == Leg::first) {
            upward = from <= settings_.lower || (from < settings_.upper && restart_upward_);
            if (stop_ != Stop::none) wanted_ = stop_ == Stop::end_position ? Leg::closing : Leg::none;
        } else if (wanted_ == Leg::regular && stop_ != Stop::at_once) {
            const std::int32_t strokes = strokes_ + (runs && leg_ == Leg::regular);
            const std::int32_t sparks = sparks_ + (runs && sparking_);
            if (stop_ != Stop::none || (settings_.strokes > 0 && strokes >= settings_.strokes)) {
                next_sparks_ = sparks < settings_.spark_out;
                if (!next_sparks_) wanted_ = ending() == Stop::end_position ? Leg::closing : Leg::none;
            }
        }
        if (wanted_ == Leg::closing && std::abs(end_position() - from) <= nothing) wanted_ = Leg::none;
        if (wanted_ == Leg::none && runs && ends_outside() && !can_stop_at_bound()) wanted_ = Leg::regular;
        if (wanted_ != Leg::none) planner_.begin(request(from, upward, learned), plans_[1 - running_]);
    }

    double end_position() const noexcept {
        return std::clamp(settings_.end_position, settings_.lowest, settings_.highest);
    }

    template <class Learned>
    StrokeRequest request(double from, bool upward, const Learned& learned) noexcept {
        // An end that lies outside was planned for the settings of then: the next stroke leaves it by them.
        const Settings& now =
            next_ == Leg::regular && leg_ == Leg::regular && ends_outside() ? running_settings_ : settings_;
        planned_settings_ = settings_;
        StrokeRequest request;
        request.from = from;
        request.largest_speed = now.largest_speed;
        request.acceleration = now.acceleration;
        if (wanted_ == Leg::closing) {
            request.to = end_position();
            request.shape = {std::min(from, request.to), std::max(from, request.to), fastest};
            request.largest_speed = std::min(now.speed, now.largest_speed);
            return request;
        }
        // With a new region that does not reach beyond this dead point the old one holds once more.
        double bound = upward ? now.upper : now.lower;
        if (upward ? bound <= from + nothing : bound >= from - nothing) bound = upward ? upper_ : lower_;
        next_bound_ = bound;
        next_dwell_ = upward ? now.upper_dwell : now.lower_dwell;
        const bool whole = wanted_ == Leg::regular;
        next_regular_ = whole && lower_ == settings_.lower && upper_ == settings_.upper &&
                        now.speed == settings_.speed && now.sections == settings_.sections;
        const Reciprocation region{upward ? std::min(from, lower_) : bound,
                                   upward ? bound : std::max(from, upper_), now.speed};
        next_acceleration_ = reversal(region, bound, now);
        double offset = learned(upward, next_acceleration_, now.speed);
        if (!next_regular_) offset = std::min(offset, 0.0);  // not learned for this stroke
        const double end = upward ? bound + offset : bound - offset;
        request.to = std::clamp(end, now.lowest, now.highest);
        if (upward ? request.to <= from + nothing : request.to >= from - nothing) request.to = bound;
        clipped_ = request.to != end;
        next_offset_ = upward ? request.to - bound : bound - request.to;
        next_speed_ = now.speed;
        const double behind = whole    ? from
                              : upward ? std::min(from, settings_.lower)
                                       : std::max(from, settings_.upper);
        request.shape = {std::min(behind, request.to), std::max(behind, request.to), now.speed};
        request.spans = SpeedSections::spans(now.sections, request.shape, upward);
        return request;
    }

    // The smaller acceleration of both strokes at a dead point: this one's, and the one's after it.
    double reversal(const Reciprocation& region, double position, const Settings& now) const noexcept {
        double least = std::min(now.acceleration, settings_.acceleration);
        for (const Settings* each : {&now, &settings_})
            for (const bool upward : {true, false}) {
                const auto spans = SpeedSections::spans(each->sections, region, upward);
                const double speed = SpeedSections::ratio_at(spans, position) * each->speed;
                least = std::min(least, 2 * speed * speed / region.stroke());
            }
        return least;
    }

    // Takes up the planned leg. `late` is the time by which the dead point has passed already.
    void take_up(double late) noexcept {
        running_ = 1 - running_;
        leg_ = wanted_;
        state_ = State::stroke;
        time_ = late;
        held_ = false;
        limited_[plan().upward()] = plan().limited() && leg_ == Leg::regular;
        duration_[plan().upward()] = plan().duration();
        if (leg_ != Leg::closing) {
            (plan().upward() ? upper_ : lower_) = next_bound_;
            current_ = {false,        plan().upward(),    false,      next_regular_, next_bound_,
                        next_offset_, next_acceleration_, next_speed_};
            if (leg_ == Leg::first) {
                if (plan().upward())
                    lower_ = settings_.lower;
                else
                    upper_ = settings_.upper;
            }
        }
        sparking_ = next_sparks_;
        dwell_ = next_dwell_;
        running_settings_ = planned_settings_;
        begin_plan(leg_ == Leg::closing ? Leg::closing : Leg::regular);
    }

    void run_stroke(bool hold, double dt) noexcept {
        if (time_ < plan().duration()) {
            const StrokePlan::Moment now = plan().at(time_);
            position_ = now.position;
            velocity_ = now.velocity;
            acceleration_ = now.acceleration;
            if (hold || stop_ == Stop::at_once)
                brake(now, settings_.acceleration, hold && stop_ != Stop::at_once);
            else if (wanted_ == Leg::none && !due_ && ends_outside())
                brake_to_bound(now, dt);
            return;
        }
        time_ -= plan().duration();
        position_ = plan().to();
        state_ = State::waiting;
        wait_ = wait_after();
        if (leg_ == Leg::closing) return;
        if (leg_ == Leg::regular) ++strokes_;
        if (sparking_) ++sparks_;
        arrival_ = current_;
        arrival_.happened = true;
        arrival_.infeed = !sparking_;
    }

    bool ends_outside() const noexcept { return leg_ != Leg::closing && current_.offset > nothing; }

    // Brakes, if it then rests in the region or, before the first dead point, on the way there.
    void brake(const StrokePlan::Moment& now, double acceleration, bool holds) noexcept {
        const double end = now.position + now.velocity * std::abs(now.velocity) / (2 * acceleration);
        const double from = leg_ == Leg::regular ? lower_ : plan().from();
        const bool inside =
            end >= std::min(from, lower_) - nothing && end <= std::max(from, upper_) + nothing;
        if (leg_ == Leg::closing || inside) begin_braking(now, acceleration, holds);
    }

    // The deceleration that ends at the dead point from a position with a speed; infinite beyond it.
    double needed(double position, double speed) const noexcept {
        const double way = plan().upward() ? current_.bound - position : position - current_.bound;
        return way > 0 ? speed * speed / (2 * way) : std::numeric_limits<double>::infinity();
    }

    // In this period, to which time_ has not advanced yet.
    bool can_stop_at_bound() const noexcept {
        const StrokePlan::Moment now = plan().at(time_ + period_);
        return needed(now.position, std::abs(now.velocity)) <= settings_.acceleration;
    }

    // At the last moment at which it can stop at the dead point, where the stroke itself ends beyond.
    void brake_to_bound(const StrokePlan::Moment& now, double dt) noexcept {
        const StrokePlan::Moment next = plan().at(time_ + dt);
        const double deceleration = needed(now.position, std::abs(now.velocity));
        if (deceleration > settings_.acceleration ||
            needed(next.position, std::abs(next.velocity)) <= settings_.acceleration)
            return;
        begin_braking(now, deceleration, false);
        strokes_ += leg_ == Leg::regular;
    }

    void begin_braking(const StrokePlan::Moment& now, double acceleration, bool holds) noexcept {
        state_ = State::braking;
        brake_ = now;
        brake_.acceleration = acceleration;
        holding_ = holds;
        restart_upward_ = upward();
        time_ = 0;
    }

    void run_braking() noexcept {
        const double sign = brake_.velocity > 0 ? 1 : -1, speed = std::abs(brake_.velocity);
        const double duration = speed / brake_.acceleration, t = std::min(time_, duration);
        position_ = brake_.position + sign * (speed - brake_.acceleration * t / 2) * t;
        velocity_ = sign * (speed - brake_.acceleration * t);
        acceleration_ = -sign * brake_.acceleration;
        if (time_ < duration) return;
        velocity_ = acceleration_ = 0;
        if (!holding_ || stop_ == Stop::at_once) {
            state_ = State::rest;
            return;
        }
        state_ = State::waiting;
        wait_ = 0;
        time_ = 0;
        begin_plan(leg_ == Leg::closing ? Leg::closing : Leg::first);
    }

    void wait(bool hold) noexcept {
        velocity_ = acceleration_ = 0;
        const bool inside = position_ >= lower_ - nothing && position_ <= upper_ + nothing;
        if ((stop_ == Stop::at_once && inside) || (wanted_ == Leg::none && !due_)) {
            state_ = State::rest;
            return;
        }
        held_ = hold && (inside || next_ != Leg::regular);
        if (held_) {
            time_ = std::min(time_, wait_);
            return;
        }
        late_ = time_ >= wait_ && next_ == Leg::regular && (due_ || planner_.busy());
        if (due_ || planner_.busy()) wait_ = std::max(wait_, time_);
        if (due_ || planner_.busy() || time_ < wait_) return;
        take_up(time_ - wait_);
        const StrokePlan::Moment now = plan().at(time_);
        position_ = now.position;
        velocity_ = now.velocity;
        acceleration_ = now.acceleration;
    }

    void show() noexcept {
        if (state_ == State::stroke)
            phase_ = plan().shape().phase(position_, plan().upward());
        else if (state_ == State::waiting && arrival_.happened)
            phase_ = arrival_.upper ? pi : 0;
    }

    static constexpr double nothing = 1e-9;  // mu
    static constexpr double fastest = 1e6;   // mu/s, a bound that is none

    Settings settings_, planned_settings_,
        running_settings_;  // now; of the planned leg, of the one that runs
    State state_ = State::rest;
    Stop stop_ = Stop::none;
    StrokePlan plans_[2];
    StrokePlanner planner_;
    int running_ = 0;
    std::size_t pace_ = 1;                                // nodes to plan in a period
    Leg leg_ = Leg::none;                                 // that runs
    Leg next_ = Leg::none, wanted_ = Leg::none;           // after it: without a stop, and as planned
    bool due_ = false, changed_ = false, stops_ = false;  // the next leg is not planned; by old settings
    Arrival arrival_, current_;                           // current_: of the leg that runs
    StrokePlan::Moment brake_{};
    double period_ = 0.001, time_ = 0, wait_ = 0;  // s; time_ since the leg or the wait began
    double position_ = 0, velocity_ = 0, acceleration_ = 0, phase_ = 0;
    double lower_ = 0, upper_ = 0;  // dead points in force
    double dwell_ = 0;              // s, after the leg that runs
    double next_bound_ = 0, next_dwell_ = 0, next_offset_ = 0, next_acceleration_ = 0, next_speed_ = 0;
    double duration_[2] = {0, 0};
    bool limited_[2] = {false, false};  // downward, upward
    std::int32_t strokes_ = 0, sparks_ = 0;
    bool next_regular_ = false, next_sparks_ = false, sparking_ = false;
    bool restart_upward_ = false, holding_ = false, held_ = false, clipped_ = false, late_ = false;
};

}  // namespace plumb
