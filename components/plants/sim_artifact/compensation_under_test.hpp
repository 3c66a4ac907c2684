// SPDX-License-Identifier: GPL-2.0-or-later
// The compensation of a simulated machine: offsets of X, Y and Z by the temperatures of spindle and bed, set
// by somebody who knew the machine within 5 %. It can have faults.
#pragma once

#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/random.hpp"
#include "components/plants/sim_artifact/temperature_sensors.hpp"
#include "hal/axes.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <array>

namespace plumb {

class CompensationUnderTest final : public hal::Group {
public:
    using Group::Group;

    enum Error { none, absent, wrong_sign, weak, strong, swapped_axes, frozen, offset, swapped_sensors };

    // Once in a period, before the sensors and step().
    void read() noexcept {
        const std::int32_t wanted = fault_;
        error_ = wanted >= none && wanted <= swapped_sensors ? wanted : static_cast<std::int32_t>(none);
        asked_ = request_;
    }
    TemperatureSensors::Error sensor_error() const noexcept {
        switch (error_) {
            case frozen: return TemperatureSensors::Error::frozen;
            case offset: return TemperatureSensors::Error::offset;
            case swapped_sensors: return TemperatureSensors::Error::swapped;
            default: return TemperatureSensors::Error::none;
        }
    }

    void start(std::int32_t seed) noexcept {
        Random random(static_cast<std::uint64_t>(seed), 99);
        for (double& each : factor_) each = seed == 0 ? 1 : random.uniform(0.95, 1.05);
    }

    // The offsets, in mm, by what the machine's error is for 1 K of spindle and bed.
    Eigen::Vector3d step(const std::array<Eigen::Vector3d, 2>& sensitivities,
                         const TemperatureSensors& sensors, double dt) noexcept {
        Eigen::Vector3d c = Eigen::Vector3d::Zero();
        for (std::size_t i = 0; i < 2; ++i)
            c -= factor_[i] * sensitivities[i] * (sensors.true_value(i) - sensors.true_value(2));
        switch (error_) {
            case absent: c.setZero(); break;
            case wrong_sign: c = -c; break;
            case weak: c *= 0.8; break;
            case strong: c *= 1.3; break;
            case swapped_axes: c = Eigen::Vector3d(c.x(), c.z(), c.y()); break;
            default: break;
        }
        const double share = share_.step(asked_ ? 1 : 0, 0.5, dt);
        on_ = asked_ ? share > 0.999 : share >= 0.001;
        const Eigen::Vector3d applied = (share > 0.999 ? 1 : share < 0.001 ? 0 : share) * c;
        for (int i = 0; i < 3; ++i) out_[static_cast<std::size_t>(i)] = applied[i];
        return applied;
    }

private:
    hal::In<bool> request_{this, "compensation-request", false, "The compensation shall be on."};
    hal::In<std::int32_t> fault_{
        this, "compensation-fault", 0,
        "Fault: 0 none, 1 absent, 2 sign, 3 weak, 4 strong, 5 axes, 6 frozen, 7 offset, 8 sensors."};
    hal::Out<bool> on_{this, "compensation-on", "The compensation is on."};
    hal::Axes<hal::Out<double>, 3> out_{this, "%-offset", "mu", "Compensation in %."};
    std::array<double, 2> factor_{1, 1};
    FirstOrderLag share_;
    std::int32_t error_ = 0;
    bool asked_ = false;
};

}  // namespace plumb
