// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// The heights, against the present one, at which a tool cuts two lands. A tool above the axis loses
// clearance by asin(height / radius). `rubbing` is +1 if it rubs above, -1 if below, as for a tool that is
// mounted upside down or work that turns the other way. Lengths in mu.
struct LandPair {
    double first = 0, second = 0;  // the first is on the side of +Y
    bool about = true;             // the present height is in the middle

    double half() const noexcept { return (first - second) / 2; }

    // Whether a tool at `height` has clearance. 0 is a clearance that nobody checks.
    static bool clears(double height, double radius, double clearance, double rubbing) noexcept {
        return !(clearance > 0) || height * rubbing <= radius * std::sin(clearance) * (1 + 1e-9);
    }

    // Lands at +-step; if the clearance, in rad, is too small for that, at the present height and two smaller
    // steps away from the rubbing side.
    static LandPair of(double step, double radius, double clearance, double rubbing) noexcept {
        if (clears(step, radius, clearance, 1)) return {step, -step, true};
        const double smaller = std::min(step, kept * radius * std::sin(clearance));
        return rubbing > 0 ? LandPair{0, -2 * smaller, false} : LandPair{2 * smaller, 0, false};
    }

private:
    static constexpr double kept = 0.9;  // of the clearance
};

}  // namespace plumb
