// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/acceleration_limit.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/soft_limit_taper.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

// The soft limits of a joint that also carries an offset, and the largest offset and speed that respect them.
// Lengths are in mu, speeds in mu/s, accelerations in mu/s2. A direction is any number with its sign. All
// functions but valid() require valid limits.
struct SoftLimits {
    static constexpr double farthest = 1e9;                 // mu
    static constexpr double softest = 1e-3, hardest = 1e9;  // mu/s2

    double min = 0, max = 0;         // of the joint
    double joint_acceleration = 0;   // largest of the joint by motion
    double offset_acceleration = 0;  // largest that the offset adds to it

    // One period of the joint.
    struct Step {
        double from, to;  // places of the joint
        double moved;     // distance by motion, at least 0; 0 after a jump of the place
        double dt;        // s, above 0
    };

    // False for NaN too.
    bool valid() const noexcept {
        const auto possible = [](double acceleration) {
            return acceleration >= softest && acceleration <= hardest;
        };
        return min < max && std::abs(min) <= farthest && std::abs(max) <= farthest &&
               possible(joint_acceleration) && possible(offset_acceleration);
    }

    // The largest slope of the taper. It leaves the rest of offset_acceleration for all but motion.
    double share() const noexcept { return std::min(0.75 * offset_acceleration / joint_acceleration, 1.0); }

    // From a place to the limit in this direction; below 0 beyond it.
    double distance(double direction, double place) const noexcept {
        return direction > 0 ? max - place : place - min;
    }

    // The part of an offset that may be applied at a place.
    double allowed(double offset, double place) const noexcept {
        return std::copysign(tapered(std::abs(offset), distance(offset, place), share()), offset);
    }

    // Whether motion may change the part of an offset that is allowed, in this period or as the joint brakes.
    bool tapers(double offset, const Step& joint) const noexcept {
        return room_at_rest(offset, joint) < taper_length(std::abs(offset), share());
    }

    // The largest speed at which an offset may grow in this direction: it stops, with a quarter of
    // offset_acceleration, before the taper at the place where the joint can stop. As the joint leaves the
    // limit, the offset may go with it.
    double largest_speed(double direction, double offset, const Step& joint) const noexcept {
        const double leaves = speed_away(direction, joint), stops = room_at_rest(direction, joint);
        const double way = std::max(share() * std::max(stops, 0.0) - direction_of(direction) * offset, 0.0);
        return share() * std::max(leaves, 0.0) +
               AccelerationLimit::stopping_speed(way, offset_acceleration / 4, joint.dt);
    }

    // The largest |offset|, so that motion takes the drive no further beyond a limit than it was, however
    // late motion brakes. `before` is the offset of the last period.
    double largest_offset(double offset, double before, const Step& joint) const noexcept {
        const double last = offset * before > 0 ? std::abs(before) : 0;
        const double beyond = std::max(last - distance_left(offset, joint.from), 0.0);
        return std::max(distance_left(offset, joint.to) + beyond, last - joint.moved);
    }

private:
    // mu/s, from the limit in this direction.
    double speed_away(double direction, const Step& joint) const noexcept {
        return bounded(distance_left(direction, joint.to) - distance_left(direction, joint.from),
                       joint.moved) /
               joint.dt;
    }
    // The distance from the limit where the joint can stop.
    double room_at_rest(double direction, const Step& joint) const noexcept {
        const double room = distance_left(direction, joint.to), leaves = speed_away(direction, joint);
        return leaves < 0 ? room - leaves * leaves / (2 * joint_acceleration) : room;
    }
    static double direction_of(double direction) noexcept { return direction > 0 ? 1 : -1; }
    double distance_left(double direction, double place) const noexcept {
        return std::max(distance(direction, place), 0.0);
    }
};

}  // namespace plumb
