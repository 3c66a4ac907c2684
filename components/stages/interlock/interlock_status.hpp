// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

enum class InterlockStatus : std::int32_t {
    permits = hal::first_own,
    holds,
    nothing_on,
    stage_fault,
    withholds,
    settles,
    stage_lacks,
    stage_limited
};

constexpr hal::Said said(InterlockStatus status) {
    using hal::Kind;
    switch (status) {
        case InterlockStatus::permits: return {Kind::good, "All functions that are switched on compensate."};
        case InterlockStatus::holds:
            return {Kind::warn, "The machine waits.", "Remove the cause that is named.", {}, "waiting-code"};
        case InterlockStatus::nothing_on:
            return {Kind::off, "No function is switched on.", "Switch a function on."};
        case InterlockStatus::stage_fault:
            return hal::Said{Kind::bad, "A stage has a fault, and its axis does not follow.",
                             "Look at the faults of the stages."}
                .told(hal::Tell::never);  // the stage tells it
        case InterlockStatus::withholds:
            return {Kind::warn, "A function is switched on, and a service that it needs is missing.",
                    "Look at the page of the function."};
        case InterlockStatus::settles:
            return {Kind::wait, "The next move waits until the axes have their offsets.",
                    "Wait for the end of the move."};
        case InterlockStatus::stage_lacks:
            return {Kind::wait, "An axis lacks its offset.", "It gets it when the next cycle begins."};
        case InterlockStatus::stage_limited:
            return {Kind::warn, "A limit of a stage prevents the full offset of its axis.",
                    "Look at the limits of the stages."};
        default: return hal::said_of_stage(static_cast<hal::Common>(status));
    }
}

struct InterlockSeen {
    bool fault = false, holds = false;  // holds: the machine, for a cause that somebody must remove
    bool on = false;                    // a function is switched on
    bool machine_on = false, homed = false;
    bool stage_fault = false, withholds = false, suspended = false, probing = false;
    bool settles = false, stage_lacks = false, stage_limited = false;
};

inline InterlockStatus status_of(const InterlockSeen& its) noexcept {
    using S = InterlockStatus;
    return hal::first<S>({{its.fault, hal::common<S>(hal::Common::fault)},
                          {its.holds, S::holds},
                          {!its.on, S::nothing_on},
                          {its.withholds, S::withholds},
                          {!its.machine_on, hal::common<S>(hal::Common::machine_off)},
                          {!its.homed, hal::common<S>(hal::Common::not_homed)},
                          {its.stage_fault, S::stage_fault},
                          {its.suspended, hal::common<S>(hal::Common::suspended)},
                          {its.probing, hal::common<S>(hal::Common::probing)},
                          {its.settles, S::settles},
                          {its.stage_lacks, S::stage_lacks},
                          {its.stage_limited, S::stage_limited},
                          {true, S::permits}});
}

}  // namespace plumb
