// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/growth/stop_rule.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// The temperatures of sensors, and how far each has risen since its first valid one. In degC.
class TemperatureRise {
public:
    void clear() noexcept { *this = TemperatureRise{}; }

    // A temperature of a sensor; not a number if it is invalid.
    void take(std::size_t sensor, double temperature) noexcept {
        now_[sensor] = temperature;
        if (!std::isfinite(temperature)) return;
        if (!std::isfinite(first_[sensor])) first_[sensor] = temperature;
        highest_[sensor] = std::max(highest_[sensor], temperature);
    }

    const StopRule::Temperatures& now() const noexcept { return now_; }

    // Whether one of these sensors, a bit each, has risen by `least`; true if none was valid.
    bool reached(double least, std::uint32_t sensors) const noexcept {
        bool any = false;
        for (std::size_t i = 0; i < first_.size(); ++i) {
            if ((sensors >> i & 1U) == 0 || !std::isfinite(first_[i])) continue;
            any = true;
            if (highest_[i] - first_[i] >= least) return true;
        }
        return !any;
    }

private:
    static StopRule::Temperatures all(double value) noexcept {
        StopRule::Temperatures result{};
        result.fill(value);
        return result;
    }

    StopRule::Temperatures first_ = all(NAN), highest_ = all(-HUGE_VAL), now_ = all(NAN);
};

}  // namespace plumb
