// SPDX-License-Identifier: GPL-2.0-or-later
// Four sensors: spindle, bed, air and artifact. Each has a lag, an offset, noise, and dropouts. Sensors can
// be frozen, have an offset of several kelvin, or be swapped; these faults are part of the machine.
#pragma once

#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/random.hpp"
#include "components/plants/drawn.hpp"
#include "hal/component.hpp"

#include <array>
#include <cmath>

namespace plumb {

class TemperatureSensors final : public hal::Group {
public:
    using Group::Group;

    enum class Error { none, frozen, offset, swapped };

    void start(std::int32_t seed, const std::array<double, 4>& bodies) noexcept {
        random_ = Random(static_cast<std::uint64_t>(seed), 77);
        for (std::size_t i = 0; i < 4; ++i) {
            offset_[i] = random_.uniform(-0.3, 0.3);
            lag_[i].set(bodies[i]);
            shown_[i] = bodies[i];
            since_[i] = 0;
        }
        begun_ = false;
    }

    void step(std::int32_t seed, const std::array<double, 4>& bodies, Error error, double dt) noexcept {
        time_ += dt;
        for (std::size_t i = 0; i < 4; ++i) lag_[i].step(bodies[i], lag_time_(seed), dt);
        if (begun_ && time_ < 5) {
            for (double& each : since_) each += dt;
            show();
            return;
        }
        time_ = 0;
        const double noise = noise_(seed), lost = dropouts_(seed);
        for (std::size_t i = 0; i < 4; ++i) {
            std::size_t body = i;
            if (error == Error::swapped && i < 2) body = 1 - i;
            since_[i] += dt;
            if (begun_ && random_.uniform() < lost) continue;  // a value that does not come
            if (begun_ && error == Error::frozen && i == 0) {
                since_[i] = 0;
                continue;
            }
            shown_[i] = lag_[body].value() + offset_[i] + noise * random_.gaussian() +
                        (error == Error::offset && i == 0 ? 4 : 0);
            const double quantum = quantum_;
            if (quantum > 1e-6 && quantum < 10) shown_[i] = std::round(shown_[i] / quantum) * quantum;
            since_[i] = 0;
        }
        begun_ = true;
        show();
    }

    double lag(std::int32_t seed) noexcept { return lag_time_(seed); }  // s
    double value(std::size_t sensor) const noexcept { return shown_[sensor]; }
    // Calibrated: without its own offset, but with its faults.
    double true_value(std::size_t sensor) const noexcept { return shown_[sensor] - offset_[sensor]; }

private:
    void show() noexcept {
        for (std::size_t i = 0; i < 4; ++i) {
            temperature_[i] = shown_[i];
            age_[i] = since_[i];
            valid_[i] = since_[i] < 60;
        }
    }

    hal::Row<hal::Out<double>, 4> temperature_{this, "temperature", "degC",
                                               "Temperature of spindle, bed, air, artifact."};
    hal::Row<hal::Out<double>, 4> age_{this, "temperature-age", "s", "Age of that temperature."};
    hal::Row<hal::Out<bool>, 4> valid_{this, "temperature-valid", "The sensor gives values."};
    Drawn lag_time_{this, "sensor-lag", 120, 60, 300, "s", "Lag of the sensors"};
    Drawn noise_{this, "sensor-noise", 0.05, 0.03, 0.06, "K", "Noise of the sensors"};
    Drawn dropouts_{this, "sensor-dropouts", 0.01, 0.001, 0.03, "1", "Part of the values that does not come"};

    hal::In<double> quantum_{this, "sensor-quantum", 0, "K", "Step in which the sensors report; 0 for none."};

    Random random_;
    std::array<FirstOrderLag, 4> lag_;
    std::array<double, 4> offset_{}, shown_{}, since_{};
    double time_ = 0;
    bool begun_ = false;
};

}  // namespace plumb
