// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

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

}  // namespace plumb
