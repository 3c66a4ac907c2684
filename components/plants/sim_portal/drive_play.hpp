// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

// The load of a drive with play, held by friction: it lags by half the play while the motor pushes it. At
// rest it sticks, and breaks away only when the motor has wound up further, by `stick`.
class DrivePlay {
public:
    void draw(std::int32_t seed, std::uint64_t stream) noexcept {
        Random random(static_cast<std::uint32_t>(seed), stream);
        waves_ = random.uniform(0.5, 1.5);
        phase_ = random.uniform(0, 2 * pi);
    }

    void reset(double motor) noexcept {
        load_ = motor;
        part_ = 0;
        slides_ = false;
    }

    // All finite, in mu; `variation` of the play along the travel, whose place u goes from -1 to 1.
    void step(double motor, double play, double variation, double stick, double u) noexcept {
        const double half = play / 2 * (1 + variation * std::sin(waves_ * pi * u + phase_));
        const double wound = motor - load_;
        slides_ = std::abs(wound) > half + (slides_ ? 0 : stick);
        if (slides_) load_ = half > 0 ? motor - std::copysign(half, wound) : motor;
        part_ = half > 0 ? (motor - load_) / half : 0;
    }

    double load() const noexcept { return load_; }
    // Place in the play: 1 while the motor pushes to the + end, -1 while it pushes to the - end.
    double part() const noexcept { return part_; }

private:
    double waves_ = 1, phase_ = 0;
    double load_ = 0, part_ = 0;
    bool slides_ = false;
};

}  // namespace plumb
