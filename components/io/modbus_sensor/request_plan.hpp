// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/modbus_sensor/modbus_settings.hpp"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <vector>

namespace plumb {

// A request that reads several channels at once.
struct ModbusGroup {
    ModbusRequest request;
    double every = 0.1;                 // s
    std::vector<std::size_t> channels;  // numbers of the channels in it
};

// Channels that are read become groups: of one device, table and time, whose registers are adjacent, or
// overlap, or leave out at most `gap` registers. Registers of one channel never come from two requests.
inline std::vector<ModbusGroup> request_plan(const std::vector<ModbusChannel>& channels, int gap) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < channels.size(); ++i)
        if (!channels[i].output) order.push_back(i);
    const auto place = [&](std::size_t i) {
        const ModbusChannel& channel = channels[i];
        return std::tuple(channel.device, channel.table, channel.every, channel.first);
    };
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return place(a) < place(b); });
    std::vector<ModbusGroup> groups;
    for (const std::size_t i : order) {
        const ModbusChannel& channel = channels[i];
        const int end = channel.first + channel.count();
        if (!groups.empty()) {
            ModbusGroup& last = groups.back();
            const ModbusRequest& request = last.request;
            const int whole = std::max(end, request.first + request.count) - request.first;
            const int most = request.of_bits() ? MODBUS_MAX_READ_BITS : MODBUS_MAX_READ_REGISTERS;
            if (request.device == channel.device && request.table == channel.table &&
                last.every == channel.every && channel.first <= request.first + request.count + gap &&
                whole <= most) {
                last.request.count = whole;
                last.channels.push_back(i);
                continue;
            }
        }
        ModbusGroup group;
        group.request.device = channel.device;
        group.request.table = channel.table;
        group.request.first = channel.first;
        group.request.count = channel.count();
        group.every = channel.every;
        group.channels = {i};
        groups.push_back(group);
    }
    return groups;
}

}  // namespace plumb
