// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

enum class SquarenessStatus : std::int32_t {
    corrects = hal::first_own,
    nothing_set,
    ramping,
    bounded,
    unsettled,
    doubtful,
    cut_in_doubt
};

constexpr hal::Said said(SquarenessStatus status) {
    using hal::Kind;
    using hal::Tell;
    switch (status) {
        case SquarenessStatus::corrects: return {Kind::good, "Corrects the tilts that were measured."};
        case SquarenessStatus::nothing_set:
            return {Kind::off, "No angle is set: nothing is corrected.", "Measure the tilts, and save them."};
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
                          {its.bounded, S::bounded},
                          {its.cut_in_doubt, S::cut_in_doubt},
                          {its.ramping, S::ramping},
                          {its.unsettled, S::unsettled},
                          {its.doubtful, S::doubtful},
                          {true, S::corrects}});
}

}  // namespace plumb
