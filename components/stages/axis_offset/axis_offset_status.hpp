// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

enum class AxisOffsetStatus : std::int32_t {
    applies = hal::first_own,
    refused,
    takes_back,
    waits,
    limited,
    ramping,
    nothing
};

constexpr hal::Said said(AxisOffsetStatus status) {
    using hal::Kind;
    switch (status) {
        case AxisOffsetStatus::applies: return {Kind::good, "The axis has the offset of its sources."};
        case AxisOffsetStatus::refused:
            return {Kind::warn, "A probing move is refused: its result would contain the offset.",
                    "Take the offset back, then probe."};
        case AxisOffsetStatus::takes_back:
            return {Kind::wait, "The axis moves back: its offset returns to 0.",
                    "Wait for the end of the move."};
        case AxisOffsetStatus::waits:
            return {Kind::wait, "The axis lacks its offset.", "It gets it when the next cycle begins."};
        case AxisOffsetStatus::limited:
            return hal::Said{Kind::warn, "The axis does not have all of its offset.",
                             "Move the axis away from its soft limit, or raise the largest offset."}
                .told(hal::Tell::text);
        case AxisOffsetStatus::ramping:
            return {Kind::wait, "The axis moves to its offset.", "Wait for the end of the move."};
        case AxisOffsetStatus::nothing: return {Kind::off, "No source asks for an offset."};
        default: return hal::said_of_stage(static_cast<hal::Common>(status));
    }
}

struct AxisOffsetSeen {
    bool fault = false, refused = false, enabled = false, on = false, homed = false;
    bool takes_back = false, armed = false, probing = false, limited = false, ramping = false;
    bool lacks = false;  // its own offset
    bool asked = false;  // by a source, or an own offset is in force
};

inline AxisOffsetStatus status_of(const AxisOffsetSeen& seen) noexcept {
    using S = AxisOffsetStatus;
    return hal::first<S>({{seen.fault, hal::common<S>(hal::Common::fault)},
                          {seen.refused, S::refused},
                          {!seen.on, hal::common<S>(hal::Common::machine_off)},
                          {!seen.homed, hal::common<S>(hal::Common::not_homed)},
                          {seen.takes_back && seen.asked, S::takes_back},
                          {!seen.enabled && !seen.ramping, hal::common<S>(hal::Common::off)},
                          {seen.lacks && !seen.armed, S::waits},
                          {seen.lacks && seen.probing, hal::common<S>(hal::Common::probing)},
                          {seen.limited, S::limited},
                          {seen.ramping, S::ramping},
                          {!seen.asked, S::nothing},
                          {true, S::applies}});
}

}  // namespace plumb
