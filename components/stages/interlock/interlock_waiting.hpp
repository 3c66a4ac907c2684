// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

// What the machine waits for, as a screen shows it; from service on by the number of the lost service.
enum class Waiting : std::int32_t {
    none,
    renew,
    probing_refused,
    long_held,
    offsets,
    uncompensated,
    homing,
    service
};

constexpr Waiting waits_for_service(std::int32_t number) {
    return static_cast<Waiting>(static_cast<std::int32_t>(Waiting::service) + number);
}

constexpr const char* sentence(Waiting waiting) {
    constexpr const char* services[] = {
        "The feed is held: plumb-retain (service 0) does not answer. Start LinuxCNC again.",
        "The feed is held: linuxcnc_link (service 1) does not answer. Start LinuxCNC again.",
        "The feed is held: service 2 does not answer. Start LinuxCNC again.",
        "The feed is held: service 3 does not answer. Start LinuxCNC again.",
        "The feed is held: LinuxCNC's task (service 4) does not answer. Start LinuxCNC again.",
        "The feed is held: LinuxCNC's io (service 5) does not answer. Start LinuxCNC again.",
        "The feed is held: growth_log (service 6) does not answer. Start LinuxCNC again.",
        "The feed is held: service 7 does not answer. Start LinuxCNC again."};
    switch (waiting) {
        case Waiting::renew:
            return "A function is off because a service was lost, and the feed is held. When the service "
                   "answers again, turn the switch of the function off and on.";
        case Waiting::probing_refused: return "Probing is refused: take the offset back first.";
        case Waiting::long_held:
            return "The feed is held for long: an offset or a correction of the tool does not come to rest.";
        case Waiting::offsets:
            return "The next move waits until no offset and no correction of the tool changes.";
        case Waiting::uncompensated: return "An axis lacks its offset until the next cycle begins.";
        case Waiting::homing:
            return "Homing waits: an offset is in force. Take it back, or switch the function off.";
        default: break;
    }
    const std::int32_t number =
        static_cast<std::int32_t>(waiting) - static_cast<std::int32_t>(Waiting::service);
    return number >= 0 && number < 8 ? services[number] : nullptr;
}

}  // namespace plumb
