// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// The size of a measured error and its standard uncertainty: small for sure, large for sure, or unknown.
// Lengths in mu.
struct KnownError {
    double size = 0, sigma = 0;
    double bias = 0;  // that may hide in it

    // One-sided, at 95 %.
    bool within(double tolerance) const noexcept { return size + one_sided * sigma <= tolerance; }
    bool significant() const noexcept { return size >= std::max(3 * sigma, 2 * bias) && size > 0; }

    // The cuts that would make the error known, as a multiple of the cuts that there are: within the
    // tolerance, or significant. The sigma is inverse to the root of the number of cuts.
    double more_cuts(double tolerance) const noexcept {
        const double room = tolerance - size;
        const double until_within = room > 0 ? square(one_sided * sigma / room) : HUGE_VAL;
        const double until_significant = size > 0 ? square(3 * sigma / size) : HUGE_VAL;
        return std::min(until_within, until_significant);
    }

private:
    static constexpr double one_sided = 1.645;
    static double square(double z) noexcept { return z * z; }
};

}  // namespace plumb
