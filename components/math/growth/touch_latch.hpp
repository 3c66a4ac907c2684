// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// Latches the first touch of a probe after it is armed. The direction of the touch is the fastest motion
// before it, because the machine begins to brake at the touch.
class TouchLatch {
public:
    void arm() noexcept { *this = TouchLatch{}; }

    // One period while the latch is armed: the probe touches, or begins to. Velocities in mu/s, finite. True
    // at the touch.
    bool step(bool touches, bool begins, const std::array<double, 3>& velocity) noexcept {
        std::size_t fastest = 0;
        for (std::size_t i = 1; i < 3; ++i)
            if (std::abs(velocity[i]) > std::abs(velocity[fastest])) fastest = i;
        if (!touches && velocity[fastest] != 0)
            direction_ = static_cast<std::int32_t>(fastest + 1) * (velocity[fastest] > 0 ? 1 : -1);
        latched_ = begins;
        return begins;
    }

    bool latched() const noexcept { return latched_; }
    // 1 to 3 for X to Z, negative for motion in -X to -Z; 0 if the machine did not move.
    std::int32_t direction() const noexcept { return direction_; }

private:
    bool latched_ = false;
    std::int32_t direction_ = 0;
};

}  // namespace plumb
