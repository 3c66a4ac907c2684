// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

enum class JointOffsetStatus : std::int32_t { applies = hal::first_own, limited, ramping, nothing };

constexpr hal::Said said(JointOffsetStatus status) {
    using hal::Kind;
    switch (status) {
        case JointOffsetStatus::applies: return {Kind::good, "The joint has the offset of its sources."};
        case JointOffsetStatus::limited:
            return hal::Said{Kind::warn, "The joint does not have all of its offset.",
                             "Move the joint away from its soft limit, or raise its largest offset or rate."}
                .told(hal::Tell::text);
        case JointOffsetStatus::ramping:
            return {Kind::wait, "The joint moves to its offset.", "Wait for the end of the move."};
        case JointOffsetStatus::nothing: return {Kind::off, "No source asks for an offset."};
        default: return hal::said_of_stage(static_cast<hal::Common>(status));
    }
}

struct JointOffsetSeen {
    bool fault = false, enabled = false, on = false, homed = false, limited = false, ramping = false;
    bool asked = false;  // by a source, or an offset is in force
};

inline JointOffsetStatus status_of(const JointOffsetSeen& seen) noexcept {
    using S = JointOffsetStatus;
    return hal::first<S>({{seen.fault, hal::common<S>(hal::Common::fault)},
                          {!seen.enabled, hal::common<S>(hal::Common::off)},
                          {!seen.on, hal::common<S>(hal::Common::machine_off)},
                          {!seen.homed, hal::common<S>(hal::Common::not_homed)},
                          {seen.limited, S::limited},
                          {seen.ramping, S::ramping},
                          {!seen.asked, S::nothing},
                          {true, S::applies}});
}

}  // namespace plumb
