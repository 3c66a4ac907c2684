// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// The part of an offset that may be applied before a soft limit, so that joint and offset together neither
// pass the limit nor stop dead at it:
//
//     f(d) = share (d - 2/3 d^1.5 / length^0.5)   for 0 < d < length = 3 offset / share
//     f(d) = offset                               for d >= length
//     f(d) = 0                                    for d <= 0
//
// d is the distance of the joint from the limit. The slope f' = share (1 - (d / length)^0.5) is at most
// share <= 1, so f <= d. A joint that can still stop before the limit, v² <= 2 a d, by |acceleration| <= a,
// gives
//
//     |f"| = |f'' v² + f' acceleration| <= share a
//
// because  2 d |f''| + f' = share  everywhere: the offset adds at most share times the joint's own
// acceleration, on the way to the limit and away from it, at any speed.
//
// offset, distance: mu; 0 < share <= 1. The offset is positive towards the limit; an offset away from it
// needs no taper.
inline double taper_length(double offset, double share) noexcept {
    return 3 * offset / share;
}

inline double tapered(double offset, double distance, double share) noexcept {
    if (offset <= 0) return offset;
    if (distance <= 0) return 0;
    const double length = taper_length(offset, share);
    if (distance >= length) return offset;
    return std::min(share * distance * (1 - std::sqrt(distance / length) * (2.0 / 3)), offset);
}

}  // namespace plumb
