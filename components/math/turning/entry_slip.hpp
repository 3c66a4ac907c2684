// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <cstdint>

namespace plumb {

// What an operator may have done who entered a diameter.
enum class EntrySlip : std::int32_t {
    none,
    not_positive,  // or not a number
    radius,        // the radius instead of the diameter
    doubled,       // the diameter where a radius was due
    inch,          // in inches on a machine in mm
    metric,        // in mm on a machine in inches
};

// Compares a radius with the one that the program asked for; 0 is a programmed radius that nobody knows. The
// entry is closest to one of the slips, in ratio, or to none of them. A tool that stands wrong by less than
// 29 % of the radius is no slip.
inline EntrySlip slip_of(double radius, double programmed) noexcept {
    if (!(radius > 0 && radius < HUGE_VAL)) return EntrySlip::not_positive;
    if (!(programmed > 0 && programmed < HUGE_VAL)) return EntrySlip::none;
    const double ratio = radius / programmed;
    constexpr double half_octave = 1.4142135623730951, between = 7.1274118724821847;  // sqrt(2 * 25.4)
    if (ratio < 1 / between) return EntrySlip::inch;
    if (ratio < 1 / half_octave) return EntrySlip::radius;
    if (ratio > between) return EntrySlip::metric;
    return ratio > half_octave ? EntrySlip::doubled : EntrySlip::none;
}

}  // namespace plumb
