// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

enum class Fault : std::int32_t {
    none,
    motion,
    tool,
    value,
    limit,
    datum = 6,
    direction,
    tables,
    steep,
    speed,
    contour,
    side,
    twice,
    learned,
    singular
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
        case Fault::datum:
            return "The setting to-bed is true, and no axis of the chain is carried by a parallel axis; the "
                   "last good set of settings stays in force.";
        case Fault::direction:
            return "The radial-offset has no radial-direction; the last good set of settings stays in force.";
        case Fault::tables: return "The tables could not be read again; the former tables stay in force.";
        case Fault::steep:
            return "The tables change too fast with the position; the correction returns to 0.";
        case Fault::singular:
            return "The pose of the rotary axes is singular: there X, Y and Z cannot move the tool in each "
                   "direction; the correction returns to 0.";
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
        case Fault::learned:
            return "Strokes learn the dead points of an axis, and a table has its scale by direction, as "
                   "EXX+ and EXX-; "
                   "the mean of both columns is used: set learn of chopping false, or delete these columns.";
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

enum class SquarenessStatus : std::int32_t {
    corrects = hal::first_own,
    nothing_set,
    ramping,
    bounded,
    unsettled,
    doubtful,
    cut_in_doubt,
    without_effect
};

constexpr hal::Said said(SquarenessStatus status) {
    using hal::Kind;
    using hal::Tell;
    switch (status) {
        case SquarenessStatus::corrects: return {Kind::good, "Corrects the tilts that were measured."};
        case SquarenessStatus::nothing_set:
            return {Kind::off, "No angle is set: nothing is corrected.", "Measure the tilts, and save them."};
        case SquarenessStatus::without_effect:
            return hal::Said{
                Kind::warn, "The angles that are set turn the work and the tool alike: nothing is corrected.",
                "Enter the readings on this page, or run plumb squareness: it gives the angles for "
                "this chain."}
                .told(Tell::text, 10);
        case SquarenessStatus::ramping:
            return {Kind::wait, "The axes move to their correction.", "Wait for the end of the move."};
        case SquarenessStatus::bounded:
            return hal::Said{Kind::warn,
                             "Corrects only in part.",
                             "Measure again, or change the limit that is given.",
                             {},
                             "limited-code"}
                .told(Tell::text);
        case SquarenessStatus::unsettled:
            return hal::Said{Kind::warn,
                             "The next cut did not wait for the correction of its tool.",
                             "Check the first cut of this tool.",
                             {},
                             "unsettled-code"}
                .told(Tell::text);
        case SquarenessStatus::doubtful:
            return {Kind::wait,
                    "The direction in which an axis moved last is not certain, so its lost motion may not be "
                    "corrected.",
                    "Move each axis by 0.1 mm before the next cut."};
        case SquarenessStatus::cut_in_doubt:
            return hal::Said{Kind::warn,
                             "A cut began while the direction in which an axis moved last was not certain.",
                             "Check this cut: it may be off by the lost motion. Move each axis by 0.1 mm."}
                .told(Tell::text);
        default: return hal::said(static_cast<hal::Common>(status));
    }
}

struct SquarenessSeen {
    bool fault = false, set = false;  // set: an angle or a table
    bool without_effect = false;      // the angles displace nothing, and there is no table
    bool enabled = false, homed = false, ramping = false, bounded = false, unsettled = false;
    bool doubtful = false, cut_in_doubt = false;  // an error differs by direction, and that is not certain
    SquarenessStatus interlock{};
};

inline SquarenessStatus status_of(const SquarenessSeen& its) noexcept {
    using S = SquarenessStatus;
    return hal::first<S>({{its.fault, hal::common<S>(hal::Common::fault)},
                          {!its.set, S::nothing_set},
                          {its.interlock != S{}, its.interlock},
                          {!its.enabled, hal::common<S>(hal::Common::off)},
                          {!its.homed, hal::common<S>(hal::Common::not_homed)},
                          {its.without_effect, S::without_effect},
                          {its.bounded, S::bounded},
                          {its.cut_in_doubt, S::cut_in_doubt},
                          {its.ramping, S::ramping},
                          {its.unsettled, S::unsettled},
                          {its.doubtful, S::doubtful},
                          {true, S::corrects}});
}

}  // namespace plumb
