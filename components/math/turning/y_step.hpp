// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// Height y of the tip before a step of Y by `step`, not 0, from the radius before it, r and x there, and the
// radius r3 of a cut after it that went deeper by infeed, above 0 towards the axis. Signed. A cut that
// removes nothing leaves r3 = r and means nothing: reject r3 >= r. Lengths in mu.
inline double height_by_y_step(double r, double x, double r3, double infeed, double step) noexcept {
    return ((r3 - r) * (r3 + r) + 2 * x * infeed - infeed * infeed - step * step) / (2 * step);
}

}  // namespace plumb
