// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

// Whether a tool that fed down can still be in the work. A descent begins as Z feeds down. It ends when Z
// moves away and is back at the height where the last feed down began, or is in another operation or has
// another tool. So the tool counts as in the work while it dwells at depth, and while it leaves a hole.
class Descent {
public:
    // `z` in mu; one that is not finite counts as the last one.
    void step(double z, bool feeds_down, bool moves_away, std::int32_t operation,
              std::int32_t tool) noexcept {
        z_ = std::isfinite(z) ? z : z_;
        if (feeds_down && (!under_way_ || moved_away_)) {
            under_way_ = true;
            operation_ = operation;
            tool_ = tool;
            top_ = bottom_ = z_;
        }
        moved_away_ = moves_away;
        bottom_ = std::min(bottom_, z_);
        const bool back = z_ >= top_ - margin * (top_ - bottom_);
        const bool elsewhere = operation != operation_ || tool != tool_;
        if (moves_away && (back || elsewhere)) under_way_ = false;
    }

    void cancel() noexcept { under_way_ = false; }

    bool under_way() const noexcept { return under_way_; }

private:
    static constexpr double margin = 0.05;  // of the descent: noise of the feedback at the retract height

    bool under_way_ = false, moved_away_ = false;
    std::int32_t operation_ = 0, tool_ = 0;
    double z_ = 0, top_ = 0, bottom_ = 0;  // mu
};

}  // namespace plumb
