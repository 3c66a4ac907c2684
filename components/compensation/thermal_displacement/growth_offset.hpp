// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/displacement_settings.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/slew_limit.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// The offset that follows a growth: in steps of a tolerance, within a bound, at a rate, and only when the
// offset may move.
class GrowthOffset {
public:
    struct Settings {
        double tolerance = 0.002;   // mu, smallest change that is applied
        double max_offset = 0.15;   // mu
        double max_rate = 0.01;     // mu/s
        double time_tolerance = 0;  // s, smallest change by the time method: a distance of the feed
        double verify_step = 0;     // mu
        bool constant_in_part = false;

        double smallest(Method method, double feed) const noexcept {
            return method == Method::time ? std::max(tolerance, std::abs(feed) * time_tolerance) : tolerance;
        }
    };

    struct Wish {
        bool applying = false;    // else it returns to 0
        bool known = false;       // there is a growth
        bool may_change = false;  // the growth that it follows
        bool may_move = false;    // Z, now
        double growth = 0;        // mu
        double step = 0;          // mu, on purpose beside the growth
    };

    // One period of dt > 0, in s. A change up to `smallest` mu is not applied.
    void step(const Wish& wish, const Settings& settings, double smallest, double dt) noexcept {
        if (!wish.applying) target_ = 0;
        if (wish.applying && wish.known && wish.may_change && std::abs(wish.growth - target_) > smallest)
            target_ = wish.growth;
        const double asked = wish.applying ? target_ + wish.step : 0;
        const double offset = bounded(asked, settings.max_offset);
        limited_ = offset != asked;
        if (wish.may_move) slew_.step(offset, settings.max_rate, dt);
    }

    double value() const noexcept { return slew_.value(); }  // mu
    bool limited() const noexcept { return limited_; }       // the growth exceeds the bound

private:
    bool limited_ = false;
    double target_ = 0;  // mu
    SlewLimit slew_;
};

}  // namespace plumb
