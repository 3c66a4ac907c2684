// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumb {

// Watches how far an axis goes beyond the end of a way to the end position, until it stands there.
class EndWatch {
public:
    // Of a period. `to` counts on the way; all positions are in mu.
    struct Now {
        bool closes = false;  // the command is on the way
        double from = 0, to = 0, commanded = 0, measured = 0;
    };

    // True once, when beyond() is known: the axis stands, or its command leaves the end before.
    bool step(const Now& now, double dt) noexcept {
        if (now.closes) return follow(now);
        if (!watches_) return false;
        look(now.measured);
        const bool there = std::abs(now.commanded - to_) <= nothing;
        arrived_ |= there;
        left_ -= dt;
        if (left_ > 0 && (there || !arrived_)) return false;
        watches_ = false;
        return arrived_;
    }

    double beyond() const noexcept { return std::max(farthest_, 0.0); }  // mu, of the last way

private:
    bool follow(const Now& now) noexcept {
        if (!watches_ || now.from != from_ || now.to != to_) {
            watches_ = true;
            arrived_ = false;
            from_ = now.from;
            to_ = now.to;
            farthest_ = -std::numeric_limits<double>::infinity();
        }
        left_ = settling;
        look(now.measured);
        return false;
    }

    void look(double measured) noexcept {
        farthest_ = std::max(farthest_, to_ > from_ ? measured - to_ : to_ - measured);
    }

    static constexpr double settling = 0.5;  // s, after the command
    static constexpr double nothing = 1e-6;  // mu

    bool watches_ = false, arrived_ = false;
    double from_ = 0, to_ = 0, farthest_ = 0, left_ = 0;
};

}  // namespace plumb
