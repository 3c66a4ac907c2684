// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <optional>

namespace plumb {

// The growth of a machine that warms at one duty, and where it ends:
//
//     y = a + sum of b_j (1 - exp(-t / tau_j)) + noise
//
// The b_j are of either sign, so a curve may bend twice and turn. If the noise is expected, as of a few
// passes, the time constants tau_j are a fixed row and the b_j are random; their size and the noise are
// unknown, and all results are means over both, weighted by their probability. Otherwise there are one to
// three exponentials, and all results are means over these models, weighted by AICc.
struct GrowthCurve {
    double steady = 0, steady_sigma = 0;  // unit of y; after very long running
    double rate = 0, rate_sigma = 0;      // per s, at the last time
    double noise = 0;                     // standard deviation of a value
    double freedom = 0;                   // degrees of freedom of the noise
    bool determined = false;              // the interval of steady is smaller than the range of y, and not:
    bool shorter = false;                 // the record is shorter than two of the slowest time constant

    // 95 of 100 between.
    double low() const noexcept { return steady - 2 * steady_sigma; }
    double high() const noexcept { return steady + 2 * steady_sigma; }
};

// Times in s, finite; not all at one time. `expected_noise`: standard deviation of a value, within a factor
// of two; 0: nothing is known about it. Two values give a noise that is little more than the expected one,
// and nothing without one; a steady state needs five.
std::optional<GrowthCurve> fit_growth_curve(const Eigen::VectorXd& t, const Eigen::VectorXd& y,
                                            double expected_noise = 0);

}  // namespace plumb
