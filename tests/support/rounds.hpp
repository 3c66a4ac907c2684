// SPDX-License-Identifier: GPL-2.0-or-later
// How long a test computes.
#pragma once

namespace plumb {

// How many rounds a statistic takes. The sanitizers look for faults of the code, which a few rounds show, and
// take several times as long.
constexpr int rounds([[maybe_unused]] int of_the_statistic, [[maybe_unused]] int under_the_sanitizers) {
#ifdef PLUMB_SANITIZED
    return under_the_sanitizers;
#else
    return of_the_statistic;
#endif
}

}  // namespace plumb
