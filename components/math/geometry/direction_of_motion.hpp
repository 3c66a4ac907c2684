// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>

namespace plumb {

// The direction in which an axis moved last. It turns when the position has gone back from its furthest
// point by more than a distance: standstill, noise and jogs below it turn nothing, and small jogs add up.
class DirectionOfMotion {
public:
    // Finite, in mu, with the distance above 0. The first position is only where it starts.
    void step(double position, double distance) noexcept {
        if (!started_) lowest_ = highest_ = position;
        started_ = true;
        lowest_ = std::min(lowest_, position);
        highest_ = std::max(highest_, position);
        if (direction_ <= 0 && position - lowest_ > distance)
            turn(1, position);
        else if (direction_ >= 0 && highest_ - position > distance)
            turn(-1, position);
    }

    // The position was set anew, without motion: the furthest point goes with it.
    void shift(double by) noexcept {
        lowest_ += by;
        highest_ += by;
    }

    int direction() const noexcept { return direction_; }  // 1 to the + end, -1 to the - end, 0 unknown

private:
    void turn(int direction, double position) noexcept {
        direction_ = direction;
        lowest_ = highest_ = position;
    }

    double lowest_ = 0, highest_ = 0;  // since it turned last
    int direction_ = 0;
    bool started_ = false;
};

}  // namespace plumb
