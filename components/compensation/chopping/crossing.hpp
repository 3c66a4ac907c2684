// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <utility>

namespace plumb {

// Whether a position crosses a coordinate, either way. A move that ends at the coordinate has crossed it. A
// new coordinate, or an invalid value, is no crossing.
class Crossing {
public:
    bool step(double position, double coordinate, double farthest) noexcept {
        if (!(std::abs(position) <= farthest && std::abs(coordinate) <= farthest)) return false;
        const int before = std::exchange(place_, (position > coordinate) - (position < coordinate));
        const bool same = std::exchange(coordinate_, coordinate) == coordinate;
        const int side = !same || place_ != 0 ? place_ : before != 0 ? -side_ : side_;
        return std::exchange(side_, side) * side < 0 && same;
    }

private:
    double coordinate_ = 0;
    int place_ = 0, side_ = 0;  // below -1, above 1; side: after the last crossing, 0 before it was seen
};

}  // namespace plumb
