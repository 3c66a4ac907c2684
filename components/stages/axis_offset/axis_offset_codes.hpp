// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

enum class Fault : std::int32_t { none, source, report, settings, lost, counts, homed, guest, interlock };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::source:
            return "One of offset-0 to offset-3, or trial, is invalid or beyond 1000; its last good value is used.";
        case Fault::report:
            return "LinuxCNC's offset-request or offset-in-force is invalid or beyond 1000; the offset is "
                   "held.";
        case Fault::settings:
            return "The scale, max-offset or max-rate is out of its range; the last good set stays in force.";
        case Fault::lost:
            return "LinuxCNC does not take the counts: a pin is not wired, or something else clears or "
                   "disables the offsets of this axis; arm again.";
        case Fault::counts: return "The counts exceed 32 bits; load the module again.";
        case Fault::homed:
            return "The machine was homed with an offset in force; turn it off and on, or clear, and home "
                   "again.";
        case Fault::guest:
            return "A change of guest-counts has no valid guest-scale, or asks for an offset beyond 1000; "
                   "the guest's offset is held.";
        case Fault::interlock:
            return "No permit comes from interlock, so the offset is held: net stage-permit of interlock to "
                   "permit, and run plumb doctor --running.";
        default: return nullptr;
    }
}

}  // namespace plumb
