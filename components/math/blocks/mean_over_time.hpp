// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <optional>

namespace plumb {

// The mean of a quantity over time.
class MeanOverTime {
public:
    // A value for so many seconds. A value that is not within ±limit does not count.
    void step(double value, double limit, double dt) noexcept {
        if (!(std::abs(value) <= limit)) return;
        sum_ += value * dt;
        time_ += dt;
    }

    // The mean since the last one was taken; nothing if no value counted.
    std::optional<double> take() noexcept {
        const std::optional<double> mean = time_ > 0 ? std::optional(sum_ / time_) : std::nullopt;
        clear();
        return mean;
    }

    void clear() noexcept { sum_ = time_ = 0; }

private:
    double sum_ = 0, time_ = 0;
};

}  // namespace plumb
