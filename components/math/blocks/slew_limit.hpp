// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"

#include <cmath>

namespace plumb {

// Follows a target no faster than a given rate: |ẏ| ≤ rate. It holds if target or rate is not finite, or
// the rate negative.
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
