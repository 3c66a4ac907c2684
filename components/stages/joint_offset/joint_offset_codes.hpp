// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

enum class Fault : std::int32_t {
    none,
    source,
    position,
    feedback,
    settings,
    limits,
    origin,
    interlock,
    bound,
    unhomed,
    unreleased
};
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::source:
            return "One of offset-0 to offset-3, or trial, is invalid or beyond 1000; its last good value is used.";
        case Fault::position:
            return "The joint-command or position is invalid or beyond 1e9; its last good value is used.";
        case Fault::feedback:
            return "The drive-feedback is invalid or beyond 1e9; LinuxCNC sees the joint stand, and stops "
                   "with a following error when it moves.";
        case Fault::settings:
            return "The max-offset, ramp-rate or max-rate is out of its range; the last good set stays in "
                   "force.";
        case Fault::limits:
            return "A limit is not set or out of range: min-limit below max-limit (both to 1e9), "
                   "joint-acceleration or offset-acceleration (0.001 to 1e9); the last good set stays in "
                   "force, and without one no offset is applied.";
        case Fault::origin:
            return "The origin was set with an offset in force; unhome the joint and home it again.";
        case Fault::interlock:
            return "No permit comes from interlock, so the offset is held: net stage-permit of interlock to "
                   "permit, and run plumb doctor --running.";
        case Fault::bound:
            return "The max-offset is below the present offset; the last good one stays in force until the "
                   "offset is within the new one.";
        case Fault::unhomed:
            return "The joint is not homed while a stroke is out; the offset stays. Turn the machine off and "
                   "on, and home the joint.";
        case Fault::unreleased:
            return "A source with release-at-off is not 0 although the machine was off: net released to its "
                   "component; the source has no effect until it is 0.";
        default: return nullptr;
    }
}

}  // namespace plumb
