// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/corner.hpp"
#include "components/math/geometry/tilt.hpp"

#include <optional>
#include <vector>

namespace plumb {

// An indicator on the tool's side runs along the blade of a square, as one axis moves; the square's base lies
// along another. A reading grows as the plunger is pressed in.
struct SquareReadings {
    Axis moved = Axis::Y;
    Lean plunger{Axis::X, 1, 0};    // the direction in which it points, along the square's base
    std::vector<double> positions;  // mm, of the moved axis
    std::vector<double> readings;   // mm
    // With the square turned by half a turn about its blade, and the plunger pointing the other way; or none.
    std::vector<double> turned;
    double uncertainty = 0;                    // mm, standard, of a reading
    std::optional<double> square_uncertainty;  // rad, standard, of the square; without it and unless turned,
                                               // the square counts as true
};

// t is the position, s the lean of the axis towards the plunger's direction, b the lean of the blade:
//
//     reading = (s - b) t + constant       turned: reading = (-s - b) t + another constant
//
// Throws std::invalid_argument with the reason.
Corner corner_from_square(const SquareReadings& square);

}  // namespace plumb
