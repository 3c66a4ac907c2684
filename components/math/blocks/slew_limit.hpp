// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"

#include <cmath>

namespace plumb {

// Follows a target no faster than a given rate:  |ẏ| ≤ rate.  A target or a rate that is not finite, and a
// negative rate, hold it where it is.
class SlewLimit {
public:
    double step(double target, double rate, double dt) noexcept {
        if (std::isfinite(target) && std::isfinite(rate)) y_ += bounded(target - y_, rate * dt);
        return y_;
    }
    double value() const noexcept { return y_; }

private:
    double y_ = 0;
};

}  // namespace plumb
