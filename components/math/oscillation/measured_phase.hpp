// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/pi.hpp"
#include "components/math/oscillation/stroke_plan.hpp"

#include <cmath>

namespace plumb {

// The phase of an axis that follows planned strokes, by its measured position: 0 at its own lower dead point,
// pi at its own upper one. An axis with a lag turns later than its command, and short of it or beyond.
//
// A stroke begins where the axis turned. It ends as far from its commanded end as the last stroke of its
// direction did. The axis turns where it comes back after the command has turned, by 1e-4 of the stroke: the
// phase stands meanwhile, for 1.2 degrees. So neither noise of a scale nor an axis that swings at a hold
// changes the direction.
class MeasuredPhase {
public:
    // A motion begins; the axis rests.
    void begin(double measured) noexcept {
        farthest_ = measured;
        turned_ = false;
    }

    // The plan is that of the command now.
    void step(double measured, const StrokePlan& plan) noexcept {
        if (!(plan.shape().stroke() > 0)) return;  // none has run
        const double sign = upward_ ? 1 : -1;
        if (sign * (measured - farthest_) > 0) farthest_ = measured;
        bool turns = plan.upward() != upward_;
        if (turns && sign * (farthest_ - measured) > least_return * plan.shape().stroke()) {
            turn(measured, plan);
            turns = false;
        }
        if (!turns) follow(plan);
        if (ends_[0] < ends_[1])
            phase_ = Reciprocation{ends_[0], ends_[1], 1}.phase(turns ? farthest_ : measured, upward_);
    }

    double phase() const noexcept { return phase_ < 2 * pi ? phase_ : 0; }  // rad, 0 to 2 pi

private:
    void turn(double measured, const StrokePlan& plan) noexcept {
        if (turned_) beyond_[upward_] = farthest_ - to_;
        begin_ = farthest_;
        commanded_begin_ = plan.from();
        turned_ = true;
        upward_ = !upward_;
        farthest_ = measured;
    }

    // The ends of the plan, as far as the axis is to reach them.
    void follow(const StrokePlan& plan) noexcept {
        to_ = plan.to();
        const Reciprocation& shape = plan.shape();
        ends_[0] = shape.lower;
        ends_[1] = shape.upper;
        ends_[upward_] += beyond_[upward_];
        if (turned_ && plan.from() == commanded_begin_ && ends_[!upward_] == commanded_begin_)
            ends_[!upward_] = begin_;
    }

    static constexpr double least_return = 1e-4;  // of the stroke

    double ends_[2] = {0, 0};    // mu, lower and upper
    double beyond_[2] = {0, 0};  // mu, of the axis beyond the end of its command, where it last turned
    double to_ = 0;              // mu, commanded end of the present stroke
    double begin_ = 0, commanded_begin_ = 0, farthest_ = 0;
    double phase_ = 0;
    bool upward_ = true, turned_ = false;  // since begin()
};

}  // namespace plumb
