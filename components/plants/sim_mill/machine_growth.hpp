// SPDX-License-Identifier: GPL-2.0-or-later
// How much closer to the work the tool of a simulated machine comes by heat. Compensations are scored
// against this truth, so it is never the model of one.
//
//     spindle   s' = (G - s) / tau(n)            G = spindle-growth (n / growth-speed)^growth-exponent
//     column    c' = (-column-share G - c) / column-tau     head and column bend the other way, slowly
//     screw     -alpha (z - screw-fixed) T       T' = (screw-rise |v| / 10 - T) / screw-tau
//     air       air-growth (T_shop - 20)
#pragma once

#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

class MachineGrowth final : public hal::Group {
public:
    using Group::Group;

    // Advances machine number `seed` by dt > 0 seconds at a spindle speed n (rpm) and with an axis at z (mm)
    // that moves with v (mm/s). Returns the growth in mm.
    double step(std::int32_t seed, double n, double z, double v, double dt) noexcept {
        const double reference = usable(speed_, 1e5, 8000);
        const double turning = std::abs(n) / (reference >= 1 ? reference : 8000);
        const double exponent = exponent_(seed);
        if (turning != turning_ || exponent != raised_to_) {
            turning_ = turning;
            raised_to_ = exponent;
            raised_ = std::pow(turning, exponent);
        }
        const double heat = bounded(spindle_growth_(seed) * raised_, most);
        const double spindle = spindle_.step(heat, turning > 0 ? tau_turning_(seed) : tau_stopped_(seed), dt);
        const double column = column_.step(-column_share_(seed) * heat, column_tau_(seed), dt);
        const double warm = screw_.step(screw_rise_(seed) * std::abs(v) / 10, screw_tau_(seed), dt);
        const double air = shop_air(dt, seed);
        shop_temperature_ = 20 + air;
        return spindle + column - steel * (z - screw_fixed_(seed)) * warm + air_growth_(seed) * air;
    }

private:
    static constexpr double steel = 11.5e-6;  // 1/K
    static constexpr double most = 10;        // mm, with any settings

    // A sine, straight between two looks, because each costs much.
    class SlowSine {
    public:
        double at(double time, double period) noexcept {
            constexpr double turn = 6.283185307179586, between_looks = 0.1;  // s
            if (!(time >= look_ && time < look_ + between_looks)) {
                look_ = time;
                value_ = std::sin(turn * look_ / period);
                rate_ = (std::sin(turn * (look_ + between_looks) / period) - value_) / between_looks;
            }
            return value_ + rate_ * (time - look_);
        }

    private:
        double look_ = -1, value_ = 0, rate_ = 0;
    };

    // The swing of the day, and of the heating or air conditioning every 20 minutes.
    double shop_air(double dt, std::int32_t seed) noexcept {
        time_ += dt;
        const double t = time_ + air_start_(seed);
        return air_day_(seed) * day_.at(t, 86400) + air_swing_(seed) * heating_.at(t, 1200);
    }

    const hal::In<double> speed_{this, "growth-speed", 8000, "rpm",
                                 "Speed at which spindle-growth is reached."};
    Drawn spindle_growth_{this, "spindle-growth", 0.06, 0.02, 0.07, "mu", "Growth of the spindle in the end"};
    Drawn exponent_{this, "growth-exponent", 1.7, 1.5, 1.9, "1", "Exponent of the speed in the growth"};
    Drawn tau_turning_{this, "tau-turning", 600, 240, 1200, "s", "Time constant of the turning spindle"};
    Drawn tau_stopped_{this, "tau-stopped", 3600, 2700, 5400, "s", "Time constant of the spindle at rest"};
    Drawn column_share_{
        this, "column-share", 0.35, 0.2, 0.5, "1", "Part of that growth that head and column undo"};
    Drawn column_tau_{this, "column-tau", 7200, 3600, 10800, "s", "Time constant of head and column"};
    Drawn screw_rise_{this, "screw-rise", 2, 1, 3, "K", "Rise of the ball screw if Z kept moving at 10 mm/s"};
    Drawn screw_tau_{this, "screw-tau", 1800, 1200, 2400, "s", "Time constant of the ball screw"};
    Drawn screw_fixed_{this, "screw-fixed", 400, 300, 600, "mu", "Z of the ball screw's fixed bearing"};
    Drawn air_growth_{this, "air-growth", 0.001, 0.001, 0.004, "mu/K", "Growth with the shop's temperature"};
    Drawn air_day_{this, "air-day", 3, 2, 5, "K", "Amplitude of the shop's temperature over the day"};
    Drawn air_swing_{this, "air-swing", 0.4, 0.2, 1, "K", "Amplitude of the shop's temperature over 20 min"};
    Drawn air_start_{
        this, "air-start", 0, 0, 86400, "s", "Time since the shop's mean temperature, at the start"};
    hal::Out<double> shop_temperature_{this, "shop-temperature", "degC", "Temperature of the shop air."};

    FirstOrderLag spindle_, column_, screw_;
    double time_ = 0;
    SlowSine day_, heating_;
    double turning_ = 0, raised_to_ = 1, raised_ = 0;  // the last power, which costs most
};

}  // namespace plumb
