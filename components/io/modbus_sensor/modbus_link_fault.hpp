// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

enum class ModbusLinkFault : std::int32_t { none, name, unreachable, port, lost, silent };
constexpr const char* sentence(ModbusLinkFault fault) {
    switch (fault) {
        case ModbusLinkFault::name:
            return "The name of the device is unknown, or the name server does not answer.";
        case ModbusLinkFault::unreachable: return "The device does not accept a connection.";
        case ModbusLinkFault::port: return "The serial port is missing, is in use, or refuses its settings.";
        case ModbusLinkFault::lost: return "The connection was lost.";
        case ModbusLinkFault::silent: return "No device of the link answers correctly.";
        default: return nullptr;
    }
}

}  // namespace plumb
