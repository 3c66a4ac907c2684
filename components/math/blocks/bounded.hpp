// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// x kept within ±limit. A negative or NaN limit, which a user can set, means zero; an x that is not a number
// becomes zero.
inline double bounded(double x, double limit) noexcept {
    const double most = limit > 0 ? limit : 0;
    return x > most ? most : x < -most ? -most : x == x ? x : 0;
}

}  // namespace plumb
