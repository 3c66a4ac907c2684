// SPDX-License-Identifier: GPL-2.0-or-later
// Watches the measured motion, in this order: the following error, the phase, the dead point that the command
// has reached (cycle time, speed for a set cycle time), the end of a way to point R, the dead points.
#pragma once

#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/compensation/chopping/dead_point_watch.hpp"
#include "components/compensation/chopping/stroke_motion.hpp"
#include "components/compensation/chopping/stroke_settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace plumb {

// The time of a cycle, and a pulse at each dead point.
class CycleClock {
public:
    void begin() noexcept { since_lower_ = -1; }

    void step(double dt) noexcept {
        for (double& left : pulse_left_) left = std::max(left - dt, 0.0);
        if (since_lower_ >= 0) since_lower_ += dt;
    }

    static constexpr double pulse_time = 0.02;  // s, which a PLC with a scan of 10 ms sees

    // A dead point, with or without infeed.
    void arrive(bool upper, bool infeed) noexcept {
        pulse_left_[upper] = infeed ? pulse_time : 0;
        if (upper) return;
        if (since_lower_ >= 0) time_ = since_lower_;
        since_lower_ = 0;
    }

    double time() const noexcept { return time_; }  // s, of the last cycle
    bool pulse(bool upper) const noexcept { return pulse_left_[upper] > 0; }

private:
    double time_ = 0, since_lower_ = -1;  // s; negative before the first lower dead point
    double pulse_left_[2] = {0, 0};
};

// Watches how far an axis goes beyond the end of a way to the end position, until it stands there.
class EndWatch {
public:
    // Of a period. `to` counts on the way; all positions are in mu.
    struct Now {
        bool closes = false;  // the command is on the way
        double from = 0, to = 0, commanded = 0, measured = 0;
    };

    // True once, when beyond() is known: the axis stands, or its command leaves the end before.
    bool step(const Now& now, double dt) noexcept {
        if (now.closes) return follow(now);
        if (!watches_) return false;
        look(now.measured);
        const bool there = std::abs(now.commanded - to_) <= nothing;
        arrived_ |= there;
        left_ -= dt;
        if (left_ > 0 && (there || !arrived_)) return false;
        watches_ = false;
        return arrived_;
    }

    double beyond() const noexcept { return std::max(farthest_, 0.0); }  // mu, of the last way

private:
    bool follow(const Now& now) noexcept {
        if (!watches_ || now.from != from_ || now.to != to_) {
            watches_ = true;
            arrived_ = false;
            from_ = now.from;
            to_ = now.to;
            farthest_ = -std::numeric_limits<double>::infinity();
        }
        left_ = settling;
        look(now.measured);
        return false;
    }

    void look(double measured) noexcept {
        farthest_ = std::max(farthest_, to_ > from_ ? measured - to_ : to_ - measured);
    }

    static constexpr double settling = 0.5;  // s, after the command
    static constexpr double nothing = 1e-6;  // mu

    bool watches_ = false, arrived_ = false;
    double from_ = 0, to_ = 0, farthest_ = 0, left_ = 0;
};

// Watches the measured motion: the following error, the dead points, which learning corrects, the phase and
// the time of a cycle.
class StrokeSupervision {
public:
    // Of a period.
    struct Seen {
        bool measurable = false;
        double measured = 0, commanded = 0;  // mu
        double motor = 0;                    // mu, by the encoder of the motor
    };

    struct Findings {
        Fault fault = Fault::none;
        bool stops = false;      // the stroke, at once
        bool corrected = false;  // the ends of the strokes to come
    };

    // A motion begins.
    void begin(const Seen& seen) noexcept {
        watch_.begin();
        clock_.begin();
        recovery_ = 0;
        if (seen.measurable) phase_.begin(seen.measured);
    }

    // A stroke begins, or has other settings.
    void select(const StrokeInForce& in_force) noexcept {
        if (in_force.values().learn)
            change_learning().select(in_force.learned_stroke(), in_force.learning());
        else
            change_learning().open();
    }
    // A person has looked at the scale that slipped.
    void accept() noexcept {
        slipped_ = false;
        watch_.accept();
    }
    bool slipped() const noexcept { return slipped_; }  // since then
    void forget() noexcept {
        watch_.forget();
        accept();
    }
    void pause() noexcept { watch_.pause(); }

    Findings step(const Seen& seen, const StrokeMotion& motion, StrokeInForce& in_force, double dt) noexcept {
        Findings found;
        const StrokeSettings& values = in_force.values();
        if (motion.moves() && seen.measurable && values.max_following_error > 0 &&
            std::abs(seen.measured - last_commanded_) > values.max_following_error)
            found = {Fault::following, true, false};
        const double commanded = std::exchange(last_commanded_, seen.commanded);
        recovery_ = std::max(recovery_ - dt, 0.0);
        if (seen.measurable) phase_.step(seen.measured, motion.oscillation().plan());
        arrive(motion, in_force, dt);
        watch_end({seen.measurable, seen.measured, commanded, seen.motor}, motion, values.learn, dt, found);
        look({seen.measurable, seen.measured, commanded, seen.motor}, motion, in_force, dt, found);
        return found;
    }

    // The part of the speed that learning permits.
    double part(const StrokeSettings& values) const noexcept {
        return values.learn ? learning().speed_factor() : 1;
    }

    // One that lasts. `blind` if it moves and cannot be measured.
    Fault fault(const StrokeSettings& values, bool blind) const noexcept {
        if (!values.learn) return Fault::none;
        const DeadPointLearning& its = learning();
        return blind                                           ? Fault::feedback
               : its.weak_drive()                              ? Fault::weak_drive
               : its.capped()                                  ? Fault::last_good
               : its.weak()                                    ? Fault::weak
               : !its.learned() && its.cycles() >= most_cycles ? Fault::not_learned
               : its.drift() > values.max_drift                ? Fault::drift
                                                               : Fault::none;
    }

    // The stroke is held until the axis, which fell behind, rests.
    bool recovers() const noexcept { return recovery_ > 0; }

    DeadPointLearning& change_learning() noexcept { return watch_.change_learning(); }
    std::uint32_t changes() const noexcept { return watch_.changes(); }  // of learning
    const DeadPointLearning& learning() const noexcept { return watch_.learning(); }
    const DeadPointWatch& dead_points() const noexcept { return watch_; }
    const MeasuredPhase& phase() const noexcept { return phase_; }
    const CycleClock& clock() const noexcept { return clock_; }

private:
    static constexpr int most_cycles = 30;        // of learning
    static constexpr double recovery_time = 0.5;  // s

    void arrive(const StrokeMotion& motion, StrokeInForce& in_force, double dt) noexcept {
        clock_.step(dt);
        const Oscillation::Arrival& arrival = motion.oscillation().arrival();
        if (!motion.moves() || !arrival.happened) return;
        watch_.arrive(arrival);
        clock_.arrive(arrival.upper, arrival.infeed);
        if (!arrival.upper) fit_cycle_time(motion.oscillation(), in_force);
    }

    // Where a way to the end position ends.
    void watch_end(const Seen& seen, const StrokeMotion& motion, bool learns, double dt,
                   Findings& found) noexcept {
        if (!seen.measurable) return;
        const Oscillation& oscillation = motion.oscillation();
        const EndWatch::Now now{motion.moves() && oscillation.closing(), oscillation.plan().from(),
                                oscillation.plan().to(), seen.commanded, seen.measured};
        if (end_.step(now, dt) && learns && change_learning().ended(end_.beyond()) &&
            found.fault == Fault::none)
            found.fault = Fault::passed_end;
    }

    // The command is that of the period before, which the axis has seen.
    void look(const Seen& seen, const StrokeMotion& motion, const StrokeInForce& in_force, double dt,
              Findings& found) noexcept {
        const Oscillation& oscillation = motion.oscillation();
        if (!motion.moves() || !seen.measurable || oscillation.state() == Oscillation::State::braking ||
            oscillation.held() ||
            oscillation.closing()) {  // which leaves the dead point with more acceleration than a stroke
            watch_.pause();
            return;
        }
        const StrokeSettings& values = in_force.values();
        const LeadingCommand& command = motion.leading();
        const DeadPointWatch::Sample now{seen.measured,
                                         seen.commanded,
                                         command.velocity(),
                                         command.acceleration(),
                                         oscillation.second_half(),
                                         oscillation.upward(),
                                         oscillation.plan().duration(),
                                         dt,
                                         std::abs(oscillation.plan().to() - oscillation.plan().from()),
                                         oscillation.speed(),
                                         oscillation.state() == Oscillation::State::waiting,
                                         seen.motor,
                                         oscillation.planned_acceleration()};
        const DeadPointWatch::Present present{values.learn, values.override_ == 1,
                                              in_force.speed(part(values)), values.longest_waits()};
        switch (watch_.step(now, present)) {
            case DeadPointWatch::Event::wrong_scale: found = {Fault::scale, true}; break;
            case DeadPointWatch::Event::slips:
                found = {Fault::slips, true, true};
                slipped_ = true;
                break;
            case DeadPointWatch::Event::lost: found = {Fault::lost, true}; break;
            case DeadPointWatch::Event::lags: found = {Fault::lags, true}; break;
            case DeadPointWatch::Event::falls_behind: recovery_ = recovery_time; break;
            case DeadPointWatch::Event::passes: found.fault = Fault::beyond; break;
            case DeadPointWatch::Event::beyond: found.fault = Fault::beyond; [[fallthrough]];
            case DeadPointWatch::Event::corrected: found.corrected = true; break;
            case DeadPointWatch::Event::none: break;
        }
    }

    // Changes the speed so that a cycle with its sections and dwells takes the set time: in proportion, as
    // far as the acceleration permits, once both strokes have had the present speed.
    void fit_cycle_time(const Oscillation& oscillation, StrokeInForce& in_force) noexcept {
        const StrokeSettings& values = in_force.values();
        const double speed = in_force.speed(part(values));
        const double target = values.cycle_time - (values.lower_dwell + values.upper_dwell);
        if (values.speed_kind != StrokeSettings::with_sections || values.override_ != 1 ||
            part(values) != 1 || watch_.arrival(false).speed != speed ||
            watch_.arrival(true).speed != speed || !(target > 0))
            return;
        in_force.stretch((oscillation.stroke_time(true) + oscillation.stroke_time(false)) / target);
    }

    DeadPointWatch watch_;
    EndWatch end_;
    MeasuredPhase phase_;
    CycleClock clock_;
    double last_commanded_ = 0;  // mu
    double recovery_ = 0;        // s, left
    bool slipped_ = false;       // the scale
};

}  // namespace plumb
