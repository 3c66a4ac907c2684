// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

enum class Fault : std::int32_t {
    none,
    motion,
    tool,
    value,
    limit,
    axis,
    datum,
    direction,
    tables,
    steep,
    speed,
    contour,
    side,
    twice
};
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::motion:
            return "A position or velocity of an axis of the chain is invalid or beyond 1e6; the last good "
                   "position is used, with no velocity.";
        case Fault::tool: return "A tool offset is invalid or beyond 1e4; its last good value is used.";
        case Fault::value:
            return "An angle (below 0.1), a pivot (to 1e6), or a radial or reference offset (to 1e4) is "
                   "invalid; its last good value is used.";
        case Fault::limit:
            return "A limit is out of its range: max-angle, max-correction, max-rate, max-speed, "
                   "settling-time or a "
                   "setting of reversals; the manual page has the ranges; the last good set of settings "
                   "stays in "
                   "force.";
        case Fault::axis:
            return "An angle, a pivot or parallel-axis-corrects is set for an axis that the chain does not "
                   "have; "
                   "the last good set of settings stays in force.";
        case Fault::datum:
            return "The setting to-bed is true, and no axis of the chain is carried by a parallel axis; the "
                   "last good set of settings stays in force.";
        case Fault::direction:
            return "The radial-offset has no radial-direction; the last good set of settings stays in force.";
        case Fault::tables: return "The tables could not be read again; the former tables stay in force.";
        case Fault::steep:
            return "The tables change too fast with the position; the correction returns to 0.";
        case Fault::speed:
            return "The max-speed is not set: set it to the speed of the fastest axis, "
                   "[TRAJ]MAX_LINEAR_VELOCITY; "
                   "the last good set of settings stays in force, and without one nothing is corrected.";
        case Fault::contour:
            return "A compensation-radius (to 1e4) or compensation-plane (17, 18 or 19) is invalid; its last "
                   "good value is used.";
        case Fault::side:
            return "G40 or the other side is in force, not the side of compensation-radius; the radius is "
                   "not "
                   "corrected.";
        case Fault::twice:
            return "LinuxCNC compensates an axis by BACKLASH or COMP_FILE, and a table has the scale of this "
                   "axis, too; the table of the scale is not used.";
        default: return nullptr;
    }
}

enum class Bound : std::int32_t { none, angle, correction, jump, table };
constexpr const char* sentence(Bound bound) {
    switch (bound) {
        case Bound::angle: return "An angle is beyond max-angle; max-angle is used.";
        case Bound::correction: return "The correction is beyond max-correction; max-correction is used.";
        case Bound::jump:
            return "A position changed faster than max-speed; the correction follows at max-rate.";
        case Bound::table: return "A table does not reach this position; its last value is used.";
        default: return nullptr;
    }
}

}  // namespace plumb
