// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/can_sensor/canopen_sdo.hpp"
#include "components/io/sensor/sensor_keys.hpp"

#include <net/if.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// A value that comes in frames, or that is asked for by SDO.
struct CanChannel {
    static constexpr bool output = false;

    std::string name;
    CanMatch match;
    std::optional<CanMultiplexer> multiplexer;
    std::optional<CanObject> object;  // asked for; the signal then lies in its data
    CanSignal signal;
    bool bit = false;
    sensor_keys::Scale scale;
    double every = 1;  // s between two requests for an object
    ReadingLimits limits;

    bool is_bit() const { return bit; }
};

// An interface, with a thread of its own.
struct CanLinkSettings {
    std::string name;
    std::string interface;
    bool transmit = false;       // else nothing is ever sent
    double timeout = 0.3;        // s, for the reply to an SDO request
    double retry = 0.5;          // s, after a failure; then twice as long, up to
    double retry_max = 2;        // s
    std::vector<int> nmt_start;  // nodes that are made operational
    std::vector<CanChannel> channels;
};

struct CanSettings {
    std::vector<CanLinkSettings> links;

    // Throws std::runtime_error with file, line, key and the text or number that is right.
    static CanSettings read(const std::filesystem::path& file);
};

namespace can_settings {

inline CanSignal place(TomlReader& table, CanSignal signal) {
    signal.start = static_cast<int>(table.whole("start-bit", 0, CanSignal::most_bits - 1));
    signal.length = static_cast<int>(table.whole_or("length", signal.length, 1, 64));
    signal.motorola = table.choice_or<bool>("order", false, {{"intel", false}, {"motorola", true}});
    if (signal.bytes() > 64) table.refuse("length", "reaches beyond the 64 bytes of a frame");
    return signal;
}

inline void type(TomlReader& table, CanChannel& channel) {
    using Type = CanSignal::Type;
    channel.bit = table.has("type") && table.text("type") == "bit";
    channel.signal.type = table.choice_or<Type>("type", Type::unsigned_number,
                                                {{"unsigned", Type::unsigned_number},
                                                 {"signed", Type::signed_number},
                                                 {"f32", Type::f32},
                                                 {"f64", Type::f64},
                                                 {"bit", Type::unsigned_number}});
    const bool f64 = channel.signal.type == Type::f64, f32 = channel.signal.type == Type::f32;
    channel.signal.length = channel.bit ? 1 : f64 ? 64 : f32 ? 32 : 16;
    if ((channel.bit || f64 || f32) && table.has("length") &&
        table.whole("length", 1, 64) != channel.signal.length)
        table.refuse("length",
                     "differs from the length of the type: " + std::to_string(channel.signal.length));
}

// Frames by id or parameter group, or an object.
inline void source(TomlReader& table, CanChannel& channel, bool transmit) {
    const int sources = table.has("id") + table.has("pgn") + table.has("sdo");
    if (sources != 1) table.refuse("id", "or pgn or sdo: a channel has one of the three");
    if (table.has("sdo")) {
        if (!transmit) table.refuse("sdo", "sends requests: set transmit = true for the link");
        TomlReader object = table.table("sdo");
        channel.object.emplace();
        channel.object->node = static_cast<int>(object.whole("node", 1, 127));
        channel.object->index = static_cast<int>(object.whole("index", 0, 0xFFFF));
        channel.object->subindex = static_cast<int>(object.whole_or("subindex", 0, 0, 0xFF));
        object.end();
        if (channel.signal.length > 32) table.refuse("length", "is more than the 32 bits of a reply");
        channel.signal.length = static_cast<int>(table.whole_or("length", channel.signal.length, 1, 32));
        channel.every = table.number_or("every", 1, 0.01, 3600);
        return;
    }
    if (table.has("pgn")) {
        std::optional<std::uint32_t> sender;
        if (table.has("source")) sender = static_cast<std::uint32_t>(table.whole("source", 0, 0xFF));
        channel.match =
            CanMatch::parameter_group(static_cast<std::uint32_t>(table.whole("pgn", 0, 0x3FFFF)), sender);
    } else {
        channel.match.extended = table.flag_or("extended", false);
        channel.match.mask = channel.match.extended ? CanMatch::extended_bits : CanMatch::standard_bits;
        channel.match.id = static_cast<std::uint32_t>(table.whole("id", 0, CanMatch::extended_bits));
        if (channel.match.id > channel.match.mask)
            table.refuse("id", "is above 0x7FF: write extended = true");
    }
    channel.signal = place(table, channel.signal);
    if (table.has("multiplexer")) {
        TomlReader multiplexer = table.table("multiplexer");
        channel.multiplexer.emplace();
        channel.multiplexer->signal.length = 8;
        channel.multiplexer->signal = place(multiplexer, channel.multiplexer->signal);
        const std::int64_t first = multiplexer.whole("value", 0, INT64_MAX);
        channel.multiplexer->first = static_cast<std::uint64_t>(first);
        channel.multiplexer->last =
            static_cast<std::uint64_t>(multiplexer.whole_or("to", first, first, INT64_MAX));
        multiplexer.end();
    }
}

inline CanChannel channel(TomlReader table, bool transmit, std::set<std::string>& names) {
    CanChannel channel;
    channel.name = sensor_keys::name(table, names);
    type(table, channel);
    source(table, channel, transmit);
    channel.limits.max_age = sensor_keys::max_age(table, channel.object ? channel.every : 0);
    if (!channel.bit) {
        channel.scale = sensor_keys::scale(table);
        sensor_keys::bounds(table, channel.limits);
    }
    table.end();
    return channel;
}

inline CanLinkSettings link(TomlReader table, std::set<std::string>& names) {
    CanLinkSettings link;
    link.name = sensor_keys::name(table, names);
    link.interface = table.text("interface", IFNAMSIZ - 1);
    if (link.interface.find_first_of(" /") != std::string::npos)
        table.refuse("interface", "is '" + link.interface + "', no name such as can0");
    link.transmit = table.flag_or("transmit", false);
    sensor_keys::times(table, link);
    for (const std::int64_t node : table.wholes("nmt-start", 1, 127))
        link.nmt_start.push_back(static_cast<int>(node));
    if (!link.nmt_start.empty() && !link.transmit)
        table.refuse("nmt-start", "sends commands: set transmit = true for the link");
    for (const TomlReader& its : table.tables("channel"))
        link.channels.push_back(channel(its, link.transmit, names));
    for (const CanChannel& its : link.channels)
        if (its.object) sensor_keys::demand_long_retry(table, link);
    if (link.channels.empty()) table.refuse("channel", "is missing: write [[link.channel]]");
    table.end();
    return link;
}

}  // namespace can_settings

inline CanSettings CanSettings::read(const std::filesystem::path& file) {
    return sensor_keys::read<CanSettings>(file, can_settings::link);
}

}  // namespace plumb
