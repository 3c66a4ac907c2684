// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// The plane of X and of a Y that is not square to it. `angle` is the one between +X and +Y in rad, within
// 0 and pi; a quarter turn if they are square.
class SkewedAxes {
public:
    SkewedAxes() = default;
    explicit SkewedAxes(double angle) noexcept : cosine_(std::cos(angle)), sine_(std::sin(angle)) {}

    // Movement of the tip along X, and square to it, for a travel of Y.
    double x_of(double y_travel) const noexcept { return y_travel * cosine_; }
    double height_of(double y_travel) const noexcept { return y_travel * sine_; }
    // The travel of Y that lifts the tip by `height`.
    double travel_for(double height) const noexcept { return height / sine_; }

private:
    double cosine_ = 0, sine_ = 1;
};

}  // namespace plumb
