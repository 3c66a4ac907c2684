// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

enum class CanLinkFault : std::int32_t { none, unsupported, missing, down, bus_off, errors, overrun };
constexpr const char* sentence(CanLinkFault fault) {
    switch (fault) {
        case CanLinkFault::unsupported: return "The kernel has no SocketCAN, or refuses the socket.";
        case CanLinkFault::missing: return "The interface does not exist.";
        case CanLinkFault::down: return "The interface is down.";
        case CanLinkFault::bus_off: return "The controller is bus-off; it neither sends nor receives.";
        case CanLinkFault::errors: return "The controller reports errors on the bus.";
        case CanLinkFault::overrun: return "The computer was too slow, and frames were lost.";
        default: return nullptr;
    }
}

}  // namespace plumb
