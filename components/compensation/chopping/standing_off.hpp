// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// Whether an axis still stands where machine off has ended its strokes, and not at their end position, or
// beyond it. Positions are in mu.
class StandingOff {
public:
    // Machine off has made an offset from the last position a part of it.
    void begin(double offset) noexcept {
        if (offset == 0) return;
        stands_ = std::abs(offset) > least;
        end_ = last_;
        outward_ = offset > 0 ? -1 : 1;
    }
    void end() noexcept { stands_ = false; }

    // The position in a period. It counts where the machine is on.
    void step(double position, bool on) noexcept {
        if (on) stands_ &= outward_ * (position - end_) < -least;
        last_ = position;
    }

    bool stands() const noexcept { return stands_; }
    double distance() const noexcept {
        return stands_ ? last_ - end_ : 0;
    }  // mu, from the end of the strokes

private:
    static constexpr double least = 1e-6;

    bool stands_ = false;
    double last_ = 0, end_ = 0, outward_ = 1;
};

}  // namespace plumb
