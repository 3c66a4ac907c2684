// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/leading_command.hpp"
#include "components/math/oscillation/oscillation.hpp"

#include <cmath>
#include <cstddef>

namespace plumb {

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
        oscillation_.set(settings);
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
