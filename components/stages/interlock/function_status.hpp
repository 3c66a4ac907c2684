// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

// What interlock knows about a function. Services and stages are sums of 1, 2, 4, ...
struct FunctionSeen {
    bool on = false, suspended = false;                 // by the operator, by the program
    bool leaves = false;                                // goes off when the tool is clear
    bool uncommissioned = false;                        // and held for that
    std::int32_t stages_uncommissioned = 0;             // of its own
    bool enabled = false, lost = false;                 // as the pins
    std::int32_t lost_services = 0, late_services = 0;  // of those that it needs
    bool machine_on = false, homed = false, in_order = true;
    bool silent = false;             // its state does not come
    std::int32_t silent_stages = 0;  // of its own: those whose state does not come
    std::int32_t stages_with_fault = 0, stages_that_lack = 0, stages_limited = 0;  // of its own
};

// The number of the first one of a sum.
constexpr std::int32_t first_number(std::int32_t sum) {
    std::int32_t number = 0;
    while (number < 31 && (sum >> number & 1) == 0) ++number;
    return number;
}

// Who keeps a function from acting, and else whether its axes follow.
constexpr hal::Common status_of(const FunctionSeen& its) {
    using hal::Common;
    const std::int32_t missing = its.lost_services ? its.lost_services : its.late_services;
    if (!its.on) return Common::off;
    if (its.leaves) return Common::leaves;
    if (its.uncommissioned)
        return its.stages_uncommissioned ? Common::stage_uncommissioned : Common::uncommissioned;
    if (its.lost && its.enabled && missing) return hal::of_service(Common::ending, first_number(missing));
    if (its.lost_services) return hal::of_service(Common::lost, first_number(its.lost_services));
    if (its.late_services) return hal::of_service(Common::late, first_number(its.late_services));
    if (its.lost) return Common::renew;
    if (!its.in_order) return Common::order;
    if (its.silent) return Common::unpermitted;
    if (its.silent_stages && !its.enabled) return Common::stage_fault;
    if (its.suspended && !its.enabled) return Common::suspended;
    if (!its.machine_on) return Common::machine_off;
    if (!its.homed) return Common::not_homed;
    if (!its.enabled) return Common::probing;
    if (its.stages_with_fault) return Common::stage_fault;
    if (its.stages_that_lack) return Common::stage_lacks;
    return its.stages_limited ? Common::stage_limited : Common::none;
}

}  // namespace plumb
