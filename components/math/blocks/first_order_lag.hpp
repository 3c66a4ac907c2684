// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// First-order lag τ ẏ + y = u, stepped exactly for an input held constant over dt, so that the response
// does not depend on the thread period. Without lag (τ ≤ 0 or NaN) y = u. A step that would make y infinite
// or NaN is refused: y stays.
class FirstOrderLag {
public:
    explicit FirstOrderLag(double initial = 0) noexcept : y_(initial) {}

    double step(double u, double tau, double dt) noexcept {
        if (tau != tau_ || dt != dt_) {
            tau_ = tau;
            dt_ = dt;
            gain_ = tau > 0 ? -std::expm1(-dt / tau) : 1;
        }
        const double y = gain_ < 1 ? y_ + (u - y_) * gain_ : u;
        if (std::isfinite(y)) y_ = y;
        return y_;
    }
    void set(double y) noexcept { y_ = y; }
    double value() const noexcept { return y_; }

private:
    double y_;
    double tau_ = 0;  // of the gain below, which is kept because the exponential costs most
    double dt_ = 0;
    double gain_ = 1;
};

}  // namespace plumb
