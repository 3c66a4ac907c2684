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
    unsettled
};

constexpr hal::Said said(SquarenessStatus status) {
    using hal::Kind;
    switch (status) {
        case SquarenessStatus::corrects: return {Kind::good, "Corrects the tilts that were measured."};
        case SquarenessStatus::nothing_set:
            return {Kind::off, "No angle is set: nothing is corrected.", "Measure the tilts, and save them."};
        case SquarenessStatus::ramping:
            return {Kind::wait, "The axes move to their correction.", "Wait for the end of the move."};
        case SquarenessStatus::bounded:
            return {Kind::warn, "Corrects only in part.", "Check the setting that is named.", "",
                    "limited-code"};
        case SquarenessStatus::unsettled:
            return {Kind::warn, "The next cut did not wait for the correction of its tool.",
                    "Check the first cut of this tool.", "", "unsettled-code"};
        default: return hal::said(static_cast<hal::Common>(status));
    }
}

struct SquarenessSeen {
    bool fault = false, set = false;  // set: an angle or a table
    bool enabled = false, homed = false, ramping = false, bounded = false, unsettled = false;
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
                          {its.ramping, S::ramping},
                          {its.unsettled, S::unsettled},
                          {true, S::corrects}});
}

}  // namespace plumb
