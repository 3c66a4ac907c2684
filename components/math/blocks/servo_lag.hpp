// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// A position loop y' = K (u - y), stepped exactly for a command u that is linear from one period to the
// next, so that a moving axis follows at the distance v/K for any thread period.
class ServoLag {
public:
    // Advances by dt > 0 seconds to the command u; gain K > 0 in 1/s.
    double step(double u, double gain, double dt) noexcept {
        if (gain != gain_ || dt != dt_) {
            gain_ = gain;
            dt_ = dt;
            kept_ = std::exp(-gain * dt);
        }
        const double following = (u - u_) / (gain * dt);
        y_ = u - following + (y_ - u_ + following) * kept_;
        u_ = u;
        return y_;
    }
    double value() const noexcept { return y_; }

    // At rest at y.
    void reset(double y) noexcept { u_ = y_ = y; }

private:
    double u_ = 0;
    double y_ = 0;
    double gain_ = 0;
    double dt_ = 0;
    double kept_ = 0;
};

}  // namespace plumb
