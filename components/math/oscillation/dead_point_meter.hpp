// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// The farthest position of an axis around a reversal: the vertex of the parabola through the farthest sample
// and its neighbours.
class DeadPointMeter {
public:
    // Begins to look for the end of a motion upward or downward.
    void begin(bool upward) noexcept {
        sign_ = upward ? 1 : -1;
        samples_ = 0;
        after_ = false;
    }

    void step(double position) noexcept {
        const double y = sign_ * position;
        if (samples_ == 0 || y > top_) {
            before_top_ = samples_ > 0 ? last_ : y;
            top_ = y;
            after_ = false;
        } else if (!after_) {
            after_top_ = y;
            after_ = true;
        }
        last_ = y;
        if (samples_ < 1000000) ++samples_;
    }

    bool found() const noexcept { return after_ && samples_ >= 3; }  // the axis has turned

    // Requires found().
    double position() const noexcept {
        const double bend = before_top_ - 2 * top_ + after_top_, slope = after_top_ - before_top_;
        return sign_ * (bend < 0 ? top_ - slope * slope / (8 * bend) : top_);
    }

private:
    double sign_ = 1, top_ = 0, before_top_ = 0, after_top_ = 0, last_ = 0;
    int samples_ = 0;
    bool after_ = false;
};

}  // namespace plumb
