// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/random.hpp"
#include "components/plants/drawn.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <cmath>

namespace plumb {

// A touch probe: repeatability, pre-travel of three lobes, seating in the spindle, and growth of its own as
// it warms up.
class TouchProbe final : public hal::Group {
public:
    using Group::Group;

    void start(std::int32_t seed) noexcept {
        random_ = Random(static_cast<std::uint64_t>(seed), 55);
        mount(seed);
    }

    void mount(std::int32_t seed) noexcept {
        const double s = seating_(seed);
        seat_ = Eigen::Vector3d(0.6 * s * random_.gaussian(), 0.6 * s * random_.gaussian(),
                                s * random_.gaussian());
        drift_.set(0);
    }

    void step(std::int32_t seed, double dt) noexcept { drift_.step(drift_size_(seed), 400, dt); }

    // The ball against its nominal place in the spindle, mm.
    Eigen::Vector3d displacement() const noexcept { return seat_ + Eigen::Vector3d(0, 0, -drift_.value()); }

    // How far the ball travels into a surface before the probe reports it, in a direction of its motion.
    double pre_travel(std::int32_t seed, const Eigen::Vector3d& direction) noexcept {
        const double size = pre_travel_(seed);
        if (std::abs(direction.z()) > 0.7) return 0.3 * size;
        return size * (0.8 + 0.2 * std::cos(3 * std::atan2(direction.y(), direction.x())));
    }

    // The error of one touch along its direction; a false trigger comes too early.
    double noise(std::int32_t seed) noexcept {
        const double usual = repeatability_(seed) * random_.gaussian();
        if (random_.uniform() >= false_triggers_(seed)) return usual;
        return usual - random_.uniform(0.05, 0.2);
    }

private:
    Drawn repeatability_{this, "probe-repeatability",       0.0005, 0.0003, 0.0006,
                         "mu", "Repeatability of the probe"};
    Drawn pre_travel_{this, "probe-pre-travel", 0.01, 0.005, 0.015, "mu", "Pre-travel of the probe"};
    Drawn seating_{this, "probe-seating", 0.0009, 0.0008, 0.001, "mu", "Scatter of its seat in the spindle"};
    Drawn drift_size_{this, "probe-drift", 0.002, 0.001, 0.003, "mu", "Growth of the probe in 10 min"};
    Drawn false_triggers_{this, "probe-false-triggers",          0.002, 0.001, 0.003,
                          "1",  "Part of touches that are false"};
    Random random_;
    Eigen::Vector3d seat_ = Eigen::Vector3d::Zero();
    FirstOrderLag drift_;
};

}  // namespace plumb
