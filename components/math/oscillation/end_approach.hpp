// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/climb.hpp"

#include <algorithm>
#include <limits>

namespace plumb {

// The acceleration of a way to the end position. An axis stands there, and no stroke has shown how far it
// goes beyond where its command stops. So the first way has a small part of the acceleration of the strokes,
// and less where the axis turned far beyond the ends of these. The next ones rise as the strokes do, while
// the axis does not go beyond. How far it goes is in proportion to the acceleration.
class EndApproach {
public:
    struct Strokes {
        double demand = 0, level = 1;  // mu/s2 at full speed, and the part of it now
        double overshoot = 0;          // s2, how far the axis turns beyond its command, for each acceleration
    };

    // Nothing is known of the axis.
    void begin() noexcept { learned_ = 0; }

    // Mu/s2. The axis may go beyond by `room`, mu.
    double acceleration(const Strokes& its, double room) const noexcept {
        const double first = std::clamp(within(room, its.overshoot), least * its.demand,
                                        Climb::slow * Climb::slow * its.demand);
        return std::min(learned_ > 0 ? learned_ : first, largest * its.demand * its.level);
    }

    // After a way with this acceleration, by which the axis went so far beyond, mu. Where its scale reads
    // another place than its motor, no way is slow enough.
    void ended(const Strokes& its, double acceleration, double beyond, double room) noexcept {
        const double next = std::min(Climb::fastest * acceleration, within(room, beyond / acceleration));
        learned_ = std::max(next, least * its.demand);
    }

private:
    // Mu/s2, by which an axis with this overshoot stays within the room.
    static double within(double room, double overshoot) noexcept {
        return overshoot > 0 ? room / (reserve * overshoot) : std::numeric_limits<double>::infinity();
    }

    static constexpr double largest = 0.25, least = 0.004;  // of the acceleration of the strokes
    static constexpr double reserve = 2;

    double learned_ = 0;  // mu/s2; 0: nothing
};

}  // namespace plumb
