// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/trapezoidal_move.hpp"
#include "components/plants/sim_part_program/part_program.hpp"

#include <cstddef>
#include <utility>

namespace plumb {

// Runs a part program once per call of begin(). Each operation is a tool change if the tool differs, a
// rapid down to 6 mm above the work, a feed to depth, a dwell or a pass from the side, and a rapid up. Then
// the last tool mills the sides until the next begin(). Each step moves Z to its target and waits there.
class PartCycle {
public:
    static constexpr std::int32_t resting = 0, moving = 1, feeding = 2;  // LinuxCNC's motion-type

    bool waiting() const noexcept { return step_ == Step::stand || step_ == Step::sides; }
    void begin(const PartProgram& program) noexcept {
        making_ = true;
        complete_ = false;
        next_ = 0;
        enter(Step::lift, program);
    }

    // Leaves the part: Z up, spindle off, until the next begin().
    void stand(const PartProgram& program) noexcept {
        making_ = cutting_ = false;
        enter(Step::stand, program);
    }

    // Advances by dt > 0 seconds; feed >= 0 in mm/s.
    void step(const PartProgram& program, double feed, double dt) noexcept {
        move_.step(target_, motion_ == feeding ? feed : rapid, acceleration, dt);
        if (move_.arrived(target_) && (waited_ += dt) >= wait_) enter(following(program), program);
    }

    double position() const noexcept { return move_.position(); }
    double velocity() const noexcept { return move_.velocity(); }
    double speed() const noexcept { return speed_; }      // of the spindle, rpm
    bool making() const noexcept { return making_; }      // a part
    bool complete() const noexcept { return complete_; }  // the last part was not left before its end
    bool cutting() const noexcept { return cutting_; }    // operation() is under way
    bool plunging() const noexcept { return step_ == Step::plunge; }  // it feeds down
    std::size_t operation() const noexcept { return index_; }         // the present or the last one
    std::int32_t operations() const noexcept { return begun_; }       // begun so far
    std::int32_t tool() const noexcept { return tool_; }              // in the spindle
    std::int32_t motion() const noexcept {
        return motion_ == moving && move_.arrived(target_) ? resting : motion_;
    }

    bool sides() const noexcept { return step_ == Step::sides; }  // it mills the sides between two parts

    // The cut from the side: width of the tool in the work, and feed.
    double side_entry(const Operation& now) const noexcept {
        return sides() ? contour_width : step_ == Step::cut && now.from_side ? waited_ * pass_feed : 0;
    }
    double side_feed() const noexcept { return sides() ? contour_feed : pass_feed; }

private:
    enum class Step { stand, lift, change, spin_up, descend, plunge, cut, beside, sides };

    // mm, s; the heights after the first one are above the work
    static constexpr double rapid = 300, acceleration = 2500;
    static constexpr double change_height = 100, lifted = 50, clearance = 6, contour_depth = 6;
    static constexpr double change_time = 2, spin_up_time = 1.5, travel_time = 0.7, dwell_time = 0.5;
    static constexpr double pass_feed = 16, pass_overrun = 10, contour_feed = 20, contour_width = 1;
    static constexpr double forever = 1e300;

    Step following(const PartProgram& program) noexcept {
        switch (step_) {
            case Step::lift:
                if (next_ == program.size()) {
                    making_ = cutting_ = false;
                    complete_ = true;
                    return Step::beside;
                }
                index_ = next_++;
                cutting_ = true;
                ++begun_;
                return program[index_].tool == tool_ ? Step::spin_up : Step::change;
            case Step::change: return Step::spin_up;
            case Step::spin_up: return Step::descend;
            case Step::descend: return Step::plunge;
            case Step::plunge: return Step::cut;
            case Step::cut: return Step::lift;
            case Step::beside: return Step::sides;
            default: return step_;
        }
    }

    void enter(Step step, const PartProgram& program) noexcept {
        const Operation& now = program[index_];
        const double bottom = now.top - now.depth;
        const bool another = next_ < program.size() && program[next_].tool != tool_;
        const double pass = (now.diameter + pass_overrun) / pass_feed;
        step_ = step;
        waited_ = 0;
        switch (step) {
            case Step::stand: speed_ = 0; return go(change_height, moving, forever);
            case Step::lift: return go(another ? change_height : now.top + lifted, moving, 0);
            case Step::change: speed_ = 0; return go(change_height, resting, change_time);
            case Step::spin_up:
                speed_ = now.speed;
                return go(position(), resting,
                          now.tool == std::exchange(tool_, now.tool) ? travel_time : spin_up_time);
            case Step::descend: return go(now.top + clearance, moving, 0);
            case Step::plunge: return go(bottom, feeding, 0);
            case Step::cut: return go(bottom, feeding, now.from_side ? pass : dwell_time);
            case Step::beside: return go(now.top - contour_depth, moving, 0);
            case Step::sides: return go(now.top - contour_depth, feeding, forever);
        }
    }

    void go(double target, std::int32_t motion, double wait) noexcept {
        target_ = target;
        motion_ = motion;
        wait_ = wait;
    }

    TrapezoidalMove move_{change_height};
    Step step_ = Step::stand;
    double target_ = change_height, wait_ = forever, waited_ = 0;  // of the step
    std::int32_t motion_ = resting;
    double speed_ = 0;
    std::size_t index_ = std::tuple_size_v<PartProgram> - 1, next_ = 0;
    std::int32_t tool_ = 0, begun_ = 0;
    bool making_ = false, complete_ = false, cutting_ = false;
};

}  // namespace plumb
