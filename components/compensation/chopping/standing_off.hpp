// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// Whether an axis still stands where machine off has ended its strokes, and not at their end position, or
// beyond it. Positions are in mu.
class StandingOff {
public:
    // Machine off has made the place of the axis its position.
    void begin(double end, double place) noexcept {
        stands_ = std::abs(place - end) > least;
        end_ = end;
        outward_ = end > place ? 1 : -1;
    }
    void end() noexcept { stands_ = false; }

    // The position, where the machine is on.
    void step(double position) noexcept { stands_ &= outward_ * (position - end_) < -least; }

    bool stands() const noexcept { return stands_; }

private:
    static constexpr double least = 1e-6;

    bool stands_ = false;
    double end_ = 0, outward_ = 1;
};

}  // namespace plumb
