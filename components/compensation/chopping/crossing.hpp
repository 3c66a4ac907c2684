// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// Whether a position crosses a coordinate, either way. A new coordinate, or an invalid value, is no crossing.
class Crossing {
public:
    bool step(double position, double coordinate, double farthest) noexcept {
        if (!(std::abs(position) <= farthest && std::abs(coordinate) <= farthest)) return false;
        const double side = position - coordinate;
        const bool same = coordinate == coordinate_;
        const bool crosses = same && side_ != 0 && side != side_ && side * side_ <= 0;
        if (side != 0 || !same) side_ = side;
        coordinate_ = coordinate;
        return crosses;
    }

private:
    double side_ = 0, coordinate_ = 0;  // the last distance that was not 0
};

}  // namespace plumb
