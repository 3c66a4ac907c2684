// SPDX-License-Identifier: GPL-2.0-or-later
// A motion from its start to its rest, and the command of the axis in it:
//
// 1. Oscillation plans strokes and gives a position in each period.
// 2. JerkLimit is the mean of its last positions, LeadingCommand adds the lead.
// 3. StrokeMotion decides by orders: stroke, stop, hold, return to point R, or leave the work.
#pragma once

#include "components/math/oscillation/oscillation.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// The mean of the last samples of a motion. It stays within the positions, speeds and accelerations of the
// motion, and its jerk is at most 2 a / T: a the largest acceleration, T the time of the samples. A reversal
// with the acceleration a ends short by a T^2 / 24.
class JerkLimit {
public:
    static constexpr std::size_t most = 128;  // samples

    // At rest at a position, with another number of samples, 1 to `most`.
    void reset(double position, std::size_t count) noexcept {
        count_ = count;
        samples_.fill(position);
        newest_ = 0;
        origin_ = position;
        sum_ = fresh_ = 0;
        settled_ = count;
        value_ = position;
    }

    double step(double position) noexcept {
        const double last = samples_[newest_];
        newest_ = newest_ + 1 < count_ ? newest_ + 1 : 0;
        sum_ += position - samples_[newest_];
        fresh_ += position - origin_;
        samples_[newest_] = position;
        // The sum of all samples, without the rounding of the sums before it.
        if (newest_ == 0) {
            sum_ = fresh_;
            fresh_ = 0;
        }
        settled_ = position == last ? settled_ + (settled_ < count_) : 1;
        return value_ = settled_ >= count_ ? position : origin_ + sum_ / static_cast<double>(count_);
    }

    double value() const noexcept { return value_; }
    bool settled() const noexcept { return settled_ >= count_; }  // all samples are the same

private:
    std::array<double, most> samples_{};
    std::size_t count_ = 1, newest_ = 0, settled_ = 1;
    double origin_ = 0, sum_ = 0, fresh_ = 0;  // sums are of distances from the origin
    double value_ = 0;
};

// The command of a stroke: its positions with a limited jerk, ahead by the lead times their velocity.
class LeadingCommand {
public:
    // At rest at a position, mu, with the samples that limit the jerk.
    void begin(double position, std::size_t samples) noexcept {
        jerk_.reset(position, samples);
        position_ = position;
        velocity_ = 0;
    }

    // The lead is in s.
    void step(double position, double lead, double dt) noexcept {
        const double before = jerk_.value(), velocity_before = velocity_;
        velocity_ = (jerk_.step(position) - before) / dt;
        acceleration_ = (velocity_ - velocity_before) / dt;
        position_ = jerk_.value() + lead * velocity_;
    }

    void rest() noexcept { velocity_ = acceleration_ = 0; }

    double position() const noexcept { return position_; }          // mu
    double mean() const noexcept { return jerk_.value(); }          // mu, without the lead
    double velocity() const noexcept { return velocity_; }          // mu/s, without the lead
    double acceleration() const noexcept { return acceleration_; }  // mu/s2, without the lead
    bool settled() const noexcept { return jerk_.settled(); }

private:
    JerkLimit jerk_;
    double position_ = 0, velocity_ = 0, acceleration_ = 0;
};

// A motion from its start to its rest: strokes, a stop, or a return to the end position, point R. A stop is
// not taken back. A return begins when strokes are not permitted any more or by an order, and only a failure,
// which stops at once, ends it before the end position. All positions are in mu.
class StrokeMotion {
public:
    enum class State { rest, stroking, stopping, returning };
    using Settings = Oscillation::Settings;
    using Stop = Oscillation::Stop;

    // Of the command, from a start to the rest.
    struct Command {
        double lead = 0, jerk_time = 0;  // s
        std::size_t samples = 1;         // that limit the jerk
    };

    // Of a period.
    struct Orders {
        bool runs = true, permitted = true;
        bool leaves = false;              // an abort takes the axis out of the work
        bool returns = false;             // in this period
        Stop hold = Stop::none;           // at_once, dead_point or end_position
        Stop usual = Stop::end_position;  // if it does not run
        bool stands = false;              // at once, also on a return
        bool changed = true;              // the settings, since the last period
    };

    void start(const Settings& settings, double place, const Command& command) noexcept {
        begin(State::stroking, place, command);
        oscillation_.start(settings, place);
    }

    void return_to_end(const Settings& settings, double place, const Command& command) noexcept {
        begin(State::returning, place, command);
        passes_hold_ = true;
        oscillation_.go_to_end(settings, place);
    }

    // Rests at a place at once: the drive is off.
    void freeze(double place) noexcept {
        state_ = State::rest;
        oscillation_.freeze(place);
    }

    // Stops at once.
    void fail() noexcept {
        failed_ = true;
        if (state_ != State::rest) state_ = State::stopping;
    }

    // One period of dt s, as Oscillation::step().
    template <class Learned>
    void step(const Orders& now, const Settings& settings, double dt, std::size_t nodes,
              const Learned& learned) noexcept {
        if (state_ == State::rest) return command_.rest();
        obey(now, settings);
        if (now.changed) oscillation_.set(settings);
        const Stop hold = passes_hold_ || forbidden_ ? Stop::none : now.hold;
        oscillation_.step(dt, now.stands ? Stop::at_once : hold, nodes, learned);
        command_.step(oscillation_.position(), its_.lead, dt);
        if (oscillation_.state() == Oscillation::State::rest && command_.settled()) state_ = State::rest;
    }

    State state() const noexcept { return state_; }
    bool failed() const noexcept { return failed_; }  // since the last start
    bool moves() const noexcept { return state_ != State::rest; }
    const Command& command() const noexcept { return its_; }
    const LeadingCommand& leading() const noexcept { return command_; }
    Oscillation& oscillation() noexcept { return oscillation_; }
    const Oscillation& oscillation() const noexcept { return oscillation_; }

private:
    void begin(State state, double place, const Command& command) noexcept {
        state_ = state;
        failed_ = passes_hold_ = forbidden_ = leaves_ = false;
        its_ = command;
        command_.begin(place, command.samples);
    }

    void obey(const Orders& now, const Settings& settings) noexcept {
        forbidden_ |= !now.permitted || now.leaves;
        passes_hold_ = (passes_hold_ || now.returns) && now.hold != Stop::none;
        if (failed_) return oscillation_.stop(Stop::at_once);
        if (forbidden_ || now.returns) state_ = State::returning;
        if (state_ == State::returning) return withdraw(settings);
        if (now.runs) return;
        state_ = State::stopping;
        oscillation_.stop(now.usual);
    }

    void withdraw(const Settings& settings) noexcept {
        const double place = oscillation_.position();
        const bool stands =
            oscillation_.state() == Oscillation::State::rest;  // the command has yet to follow
        const bool leaves = forbidden_ && settings.clear != Stop::none;
        if (stands && leaves && !leaves_)
            oscillation_.leave(settings, place);
        else if (stands && !leaves && std::abs(place - settings.end_position) > nothing)
            oscillation_.go_to_end(settings, place);
        else
            oscillation_.stop(leaves ? Stop::leave : Stop::withdraw);
        leaves_ = leaves;
    }

    static constexpr double nothing = OscillationLeg::nothing;

    State state_ = State::rest;
    bool failed_ = false;       // it stops at once
    bool forbidden_ = false;    // since the start
    bool leaves_ = false;       // by the dead point that is clear
    bool passes_hold_ = false;  // a return goes before the hold that was there when it was ordered
    Command its_;
    Oscillation oscillation_;
    LeadingCommand command_;
};

}  // namespace plumb
