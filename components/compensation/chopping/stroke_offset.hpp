// SPDX-License-Identifier: GPL-2.0-or-later
// The offset of the axis from its position, and where the axis stands without it:
//
// 1. AxisPlace: an extra joint whose drive is off; its command goes where the axis is.
// 2. StrokeOffset follows the motion and rests where it ended. HomedWatch says what becomes of the rest when
//    its joint loses its origin, GuardedOffset keeps bound, rate and acceleration.
// 3. StandingOff: machine off has made an offset a part of the position.
#pragma once

#include "components/math/blocks/acceleration_limit.hpp"
#include "components/math/blocks/bounded.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace plumb {

// Where an extra joint stands while nothing drives it: its command is there, so that turning on moves
// nothing. LinuxCNC does the same for its own joints. With the drive on the command never follows the axis.
//
// A reading that fails, jumps, or has not followed the strokes says nothing about the axis. The place is then
// unknown until the joint is homed again. A jump is a change in one period that neither the period before nor
// the one after has; a hand that pushes changes the reading in all of them.
class AxisPlace {
public:
    // Of a period; lengths in mu.
    struct Now {
        bool on = false, homed = false;  // the machine, the joint
        bool moves = false;              // by a stroke
        bool measurable = false;
        double measured = 0, commanded = 0;
        double most = 0, speed = 0;  // the largest distance between them, 0: unknown; mu/s, of the strokes
    };

    void begin(double millimetre) noexcept { millimetre_ = millimetre; }

    // One period of dt s. True if the command has to be at place() at once.
    bool step(const Now& now, double dt) noexcept {
        if (!std::exchange(began_, true)) {
            on_ = now.on;
            homed_ = now.homed;
        }
        const bool goes_off = on_ && !now.on, homes = now.homed && !homed_;
        since_change_ = on_ == now.on ? std::min(since_change_ + dt, 2 * patience) : 0;
        on_ = now.on;
        homed_ = now.homed;
        if (now.homed && !homes) look(now, dt);
        if (!now.homed || homes) {
            read_ = false;
            return take_over(now, homes);
        }
        const double reach = now.most > 0 ? now.most : millimetre_ + latest * now.speed;
        if (goes_off && (lag(now) > reach || 4 * unanswered_ > reach)) known_ = false;
        if (now.moves || now.on) lag_ = lag(now);
        if (now.on || !known_) return false;
        place_ = sound_;
        return true;
    }

    bool known() const noexcept { return known_; }
    double place() const noexcept { return place_; }  // mu

private:
    static double lag(const Now& now) noexcept { return std::abs(now.commanded - now.measured); }

    // LinuxCNC moves a joint that is not homed, or gives it another origin.
    bool take_over(const Now& now, bool homes) noexcept {
        if (!now.measurable) return false;
        const bool moved = !now.moves && lag(now) > lag_ + standing * millimetre_;
        const bool follows = homes ? moved || !known_ : !now.on;
        if (now.moves) lag_ = lag(now);
        if (homes || !now.on) known_ = true;
        if (follows) place_ = now.measured;
        return follows;
    }

    // Whether an axis can have moved like these readings.
    void look(const Now& now, double dt) noexcept {
        const bool counts = !now.on || since_change_ < patience;
        since_jump_ = std::min(since_jump_ + dt, 2 * patience);
        if (!now.measurable) {
            if (counts) known_ = false;
            return;
        }
        if (!read_) {
            sound_ = last_ = now.measured;
            change_ = before_ = unanswered_ = 0;
            commanded_ = now.commanded;
            read_ = true;
        }
        const double change = now.measured - last_, step = std::abs(change_);
        const bool jumps = std::abs(change) > fastest * millimetre_ * dt ||
                           step - std::max(std::abs(before_), std::abs(change)) > jump * millimetre_;
        if (jumps) since_jump_ = 0;
        if (counts && since_jump_ < patience) known_ = false;
        sound_ = std::abs(change) > jump * millimetre_ ? last_ : now.measured;
        unanswered_ = change != 0 ? 0 : unanswered_ + std::abs(now.commanded - commanded_);
        before_ = change_;
        change_ = change;
        last_ = now.measured;
        commanded_ = now.commanded;
    }

    static constexpr double latest = 0.2;     // s, by which any axis follows
    static constexpr double patience = 1;     // s, in which a supply fails or returns with the drive
    static constexpr double fastest = 5000;   // mm/s, of any axis
    static constexpr double jump = 0.05;      // mm
    static constexpr double standing = 0.01;  // mm, of an axis that nothing moves

    double millimetre_ = 1;  // mu
    bool began_ = false, on_ = false, homed_ = false, known_ = true, read_ = false;
    double place_ = 0, lag_ = 0;             // lag_: when it was last homed
    double last_ = 0, sound_ = 0;            // readings; sound_: that no later one can make a jump
    double change_ = 0, before_ = 0;         // of the reading, in the last two periods
    double commanded_ = 0, unanswered_ = 0;  // way of the command since the reading last changed
    double since_change_ = 2 * patience, since_jump_ = 2 * patience;  // s, of the drive; of the reading
};

// An offset that follows its target exactly, unless that breaks its bound, its rate or its acceleration.
class GuardedOffset {
public:
    struct Limits {
        double most, rate, acceleration;  // mu, mu/s, mu/s2
    };

    // Impossible limits leave the last good ones in force, and so does a limit by which the offset cannot
    // stop within its bound. The acceleration is possible. A smaller bound or rate waits until the motion
    // that was planned by the last one has ended, and a smaller acceleration until the offset then stands.
    void allow(const Limits& wanted, bool moves, double farthest, double dt) noexcept {
        const double most = limits_.most, hardest = limits_.acceleration;
        Limits given = wanted;
        const bool planned = moves && moved_;  // and not a motion that begins
        moved_ = moves;
        if (planned) {
            given.most = std::max(given.most, most);
            given.rate = std::max(given.rate, limits_.rate);
        }
        if (given.rate >= 1e-3 && given.rate <= 1e6) limits_.rate = given.rate;
        const bool ends = !moves && !stands_;
        if (given.acceleration >= hardest || (!ends && guard_.stops_within(most, given.acceleration, dt)))
            limits_.acceleration = given.acceleration;
        const bool possible = given.most >= 0 && given.most <= farthest;
        refused_ =
            possible && given.most < most && !guard_.stops_within(given.most, limits_.acceleration, dt);
        if (possible && !refused_) limits_.most = given.most;
    }

    // An offset that is held does not follow.
    void step(double target, bool holds, double dt) noexcept {
        const auto& [most, largest, acceleration] = limits_;
        const double rate = largest * (1 + rounding);  // a motion at the largest rate is no step
        if (holds)
            guard_.hold();
        else
            guard_.step(bounded(target, std::max(most, std::abs(value()))),
                        {rate, rate, acceleration, rate, rate, most}, dt);
        stands_ = value() == last_;
        last_ = value();
        kept_back_ = std::abs(value() - target) > 1e-6;
    }

    // The axis has been moved, perhaps beyond the bound.
    void put(double place) noexcept {
        guard_.move_to(place, 1, 1);
        guard_.hold();
    }

    // The offset has become a part of the position: it is 0, and nothing moves.
    void release() noexcept { guard_ = {}; }

    double value() const noexcept { return guard_.value(); }
    bool kept_back() const noexcept { return kept_back_; }  // from its target
    bool stands() const noexcept { return stands_; }        // in the last period
    bool refused() const noexcept { return refused_; }      // a bound below the present offset

private:
    static constexpr double rounding = 1e-9;

    AccelerationLimit guard_;
    Limits limits_{};
    double last_ = 0;
    bool moved_ = false, stands_ = true, kept_back_ = false, refused_ = false;
};

// What becomes of an offset at rest while its joint is not homed. It stays for a moment; a stage that ramps
// it down meanwhile has taken it away then, and nothing is to be there when the joint is homed again.
class HomedWatch {
public:
    enum class Offset { stays, as_applied, none };

    // One period of dt s.
    Offset step(bool homed, bool ramps, double dt) noexcept {
        if (homed) {
            const bool returned = unhomed_ > 0;
            unhomed_ = 0;
            return returned ? Offset::as_applied : Offset::stays;
        }
        unhomed_ = std::min(unhomed_ + dt, 2 * patience);
        return ramps && unhomed_ > patience ? Offset::none : Offset::stays;
    }

private:
    static constexpr double patience = 1;  // s, with a joint that is not homed

    double unhomed_ = 0;  // s, since homed was lost
};

// The offset of an axis from its position: it follows the stroke, and rests where a motion has ended. All
// positions are in mu.
class StrokeOffset {
public:
    static constexpr double nothing = 1e-9;

    struct Period {
        bool moves = false, ends = false;  // ends: the motion has ended in this period
        double command = 0, mean = 0;      // of the motion, from the position; mean: without the lead
        bool on = false, homed = false;    // the machine, the joint
        bool ramps = false;                // a stage takes the offset of a joint that is not homed away
    };

    void allow(const GuardedOffset::Limits& limits, bool moves, double farthest, double dt) noexcept {
        guarded_.allow(limits, moves, farthest, dt);
    }

    // Stays where it is.
    void freeze() noexcept { rest_ = value(); }
    // Is at a place at once: the axis has been moved there.
    void put(double place) noexcept {
        guarded_.put(place);
        rest_ = place;
    }
    // It has become a part of the position.
    void release() noexcept {
        rest_ = 0;
        guarded_.release();
    }

    void step(const Period& now, double dt) noexcept {
        if (now.ends) rest_ = std::abs(now.mean) <= nothing ? 0 : now.mean;
        switch (homed_watch_.step(now.homed, now.ramps, dt)) {
            case HomedWatch::Offset::as_applied: rest_ = value(); break;
            case HomedWatch::Offset::none: rest_ = 0; break;
            case HomedWatch::Offset::stays: break;
        }
        // Where a bound has stopped it, a larger one must not move it later.
        if (!now.moves && guarded_.kept_back() && guarded_.stands()) rest_ = value();
        guarded_.step(now.moves ? now.command : rest_, !now.on && now.homed, dt);
    }

    double value() const noexcept { return guarded_.value(); }
    double rest() const noexcept { return rest_; }
    bool kept_back() const noexcept { return guarded_.kept_back(); }
    bool refused() const noexcept { return guarded_.refused(); }  // a bound below the present offset

private:
    GuardedOffset guarded_;
    HomedWatch homed_watch_;
    double rest_ = 0;
};

// Whether an axis still stands where machine off has ended its strokes, and not at their end position, or
// beyond it. Positions are in mu.
class StandingOff {
public:
    // Machine off has made an offset from the last position a part of it.
    void begin(double offset) noexcept {
        if (offset == 0) return;
        stands_ = std::abs(offset) > least;
        end_ = last_;
        outward_ = offset > 0 ? -1 : 1;
    }
    void end() noexcept { stands_ = false; }

    // The position in a period. It counts where the machine is on.
    void step(double position, bool on) noexcept {
        if (on) stands_ &= outward_ * (position - end_) < -least;
        last_ = position;
    }

    bool stands() const noexcept { return stands_; }
    double distance() const noexcept {
        return stands_ ? last_ - end_ : 0;
    }  // mu, from the end of the strokes

private:
    static constexpr double least = 1e-6;

    bool stands_ = false;
    double last_ = 0, end_ = 0, outward_ = 1;
};

}  // namespace plumb
