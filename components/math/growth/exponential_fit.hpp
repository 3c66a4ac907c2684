// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace plumb {

// y = a + b (1 - exp(-t / τ)). a is free: the first value is as noisy as the others.
struct ExponentialFit {
    double a = 0, b = 0;    // unit of y
    double tau = 0;         // s
    double steady = 0;      // a + b
    double steady_low = 0;  // the interval of steady that covers 95 of 100: not symmetric
    double steady_high = 0;
    double scatter = 0;       // standard deviation of a value about the curve
    double rate = 0;          // per s, at the last time
    double time_to_95 = 0;    // s from t = 0 until 95 % of b
    bool determined = false;  // false: the curve does not bend enough, and the interval has no end

    double at(double t) const noexcept { return a - b * std::expm1(-t / tau); }
    // Half of the longer side of the interval: the standard uncertainty of steady, infinite if undetermined.
    double steady_uncertainty() const noexcept {
        if (!determined) return std::numeric_limits<double>::infinity();
        return std::max(steady_high - steady, steady - steady_low) / 2;
    }
};

// Fits by variable projection over τ, from a 50th of the time of observation to 10 times it. The interval of
// the steady state is that of the profile likelihood: every value that some τ makes as probable.
// `uncertainty` is that of a value; 0 if unknown, else the scatter about the curve counts where it is larger.
// Times in s, of any origin t >= 0. Nothing with fewer than 5 values, or values at one time, or values that
// are not finite.
std::optional<ExponentialFit> fit_exponential(const Eigen::VectorXd& t, const Eigen::VectorXd& y,
                                              double uncertainty = 0);

}  // namespace plumb
