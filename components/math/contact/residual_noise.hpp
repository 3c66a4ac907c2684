// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>

namespace plumb {

// The noise in a load, by the residuals of a fit: squares of them as they are, and summed up through the
// exponential by which noise shifts an onset; and the same sums for white noise of variance 1.
class ResidualNoise {
public:
    // From the newest sample to the oldest, of weight 0 or 1; q = exp(-spacing / τ).
    void take(double weight, double residual, double q) noexcept {
        sum_ = weight * residual + q * sum_;
        white_ = weight + q * q * white_;
        squares_ += weight * residual * residual;
        sum_squares_ += weight * sum_ * sum_;
        white_sum_ += weight * white_;
    }

    // Variance of the white noise that would shift the onset as much as this noise. The fit has taken part
    // of the slow noise out of the residuals: the more, the fewer time constants there are. Simulations of
    // white noise and of 1/f noise gave the two factors. `n`: the sum of the weights; `length`: the time
    // constant as a part of the record.
    double variance(double n, int unknowns, double length) const noexcept {
        const double white_lost = 1 + 8 * length, slow_lost = 1 + 19 * length;
        const double white = squares_ / std::max(n - unknowns, 1.0);
        const double seen = white_lost * sum_squares_ / white_sum_;
        return white + std::max(seen - white, 0.0) * slow_lost / white_lost;
    }

private:
    double squares_ = 0, sum_ = 0, sum_squares_ = 0, white_ = 0, white_sum_ = 0;
};

}  // namespace plumb
