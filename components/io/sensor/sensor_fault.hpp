// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

// The fault of a channel: of modbus_sensor and can_sensor alike.
enum class SensorFault : std::int32_t {
    none,
    waiting,
    disconnected,
    silent,
    damaged,
    refused,
    old,
    range,
    rate,
    command,
    disabled
};
constexpr const char* sentence(SensorFault fault) {
    switch (fault) {
        case SensorFault::waiting: return "No value has come yet.";
        case SensorFault::disconnected:
            return "The link is not connected; its own fault-code gives the cause.";
        case SensorFault::silent: return "The device does not answer, or sends nothing.";
        case SensorFault::damaged:
            return "The reply or frame is damaged, too short, or belongs to another request.";
        case SensorFault::refused: return "The device refuses the request; standard error has its reason.";
        case SensorFault::old: return "The value is older than max-age.";
        case SensorFault::range: return "The value lies outside min to max, or is not a number.";
        case SensorFault::rate: return "The value changes faster than max-rate.";
        case SensorFault::command:
            return "The command lies outside min to max, or is not a number; it is not written.";
        case SensorFault::disabled: return "The output is not enabled; nothing is written.";
        default: return nullptr;
    }
}

}  // namespace plumb
