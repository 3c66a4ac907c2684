// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/turning/cut_fit.hpp"

#include <array>
#include <cstddef>

namespace plumb {

// The cuts of a procedure. X is outward, Y against the position for which the height is wanted; lengths in
// mu.
struct TurnedCuts {
    std::array<Cut, CutFit::most> cuts;
    std::size_t count = 0;
    double x_zero = 0;  // X at which the control has the axis, outward
    double travel = 0;  // of X between the first two cuts, as entered; 0 if not

    const Cut& operator[](std::size_t i) const noexcept { return cuts[i]; }
    double programmed(std::size_t i) const noexcept { return cuts[i].x - x_zero; }
};

}  // namespace plumb
