// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/modbus_sensor/modbus_request.hpp"
#include "components/io/modbus_sensor/modbus_value.hpp"
#include "components/io/sensor/sensor_keys.hpp"

#include <termios.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// A value that is read, or written.
struct ModbusChannel {
    std::string name;
    int device = 1;
    ModbusTable table = ModbusTable::holding;
    int first = 0;  // register or bit, counted from 0
    ModbusEncoding encoding;
    sensor_keys::Scale scale;
    double every = 0.1;  // s
    ReadingLimits limits;
    bool output = false;
    bool multiple = false;  // one register is written by the function for several

    bool is_bit() const {
        return table == ModbusTable::coil || table == ModbusTable::discrete ||
               encoding.type == ModbusEncoding::Type::bit;
    }
    int count() const {
        return table == ModbusTable::coil || table == ModbusTable::discrete ? 1 : encoding.registers();
    }
};

// A sentence for a register that looks like a number of a manual, which counts from 40001 or 30001; else
// empty.
inline std::string numbering_hint(const ModbusChannel& channel) {
    const int first = channel.table == ModbusTable::holding ? 40001
                      : channel.table == ModbusTable::input ? 30001
                                                            : 65536;
    if (channel.first < first || channel.first > first + 9998) return {};
    return channel.name + ": register " + std::to_string(channel.first) + " of a manual that counts from " +
           std::to_string(first) + " is register = " + std::to_string(channel.first - first) + " here.";
}

struct SerialSettings {
    int baud = 19200;
    speed_t speed = B19200;
    char parity = 'E';
    int stop_bits = 1;

    // Seconds that a byte takes.
    double byte_time() const { return (9.0 + (parity != 'N') + stop_bits) / baud; }

    // Such as 19200 8E1.
    std::string text() const { return std::to_string(baud) + " 8" + parity + std::to_string(stop_bits); }

    // Between two frames, s: three and a half bytes, and no less than above 19200 baud.
    double silence() const { return std::max(3.5 * byte_time(), 1.75e-3); }
};

// A connection over TCP, or a serial line, with a thread of its own.
struct ModbusLinkSettings {
    std::string name;
    std::string host, port;  // of TCP
    std::string path;        // of a serial device; empty for TCP
    SerialSettings serial;
    double timeout = 0.3;   // s, for a whole reply
    double retry = 0.5;     // s, after a failure; then twice as long, up to
    double retry_max = 10;  // s
    int gap = 0;            // registers that nobody asks for, in the middle of a request
    std::vector<ModbusChannel> channels;

    bool is_serial() const { return !path.empty(); }
    std::string place() const { return is_serial() ? path + ", " + serial.text() : host + ":" + port; }
};

struct ModbusSettings {
    std::vector<ModbusLinkSettings> links;

    // Throws std::runtime_error with file, line, key and the text or number that is right.
    static ModbusSettings read(const std::filesystem::path& file);
};

namespace modbus_settings {

// The speeds of a serial line, in baud, and the system's numbers for them. Other speeds open a port at 9600
// without an error.
inline const std::vector<std::pair<int, speed_t>>& speeds() {
    static const std::vector<std::pair<int, speed_t>> all{
        {1200, B1200},     {2400, B2400},     {4800, B4800},    {9600, B9600},
        {19200, B19200},   {38400, B38400},   {57600, B57600},  {115200, B115200},
        {230400, B230400}, {460800, B460800}, {921600, B921600}};
    return all;
}

inline void tcp(TomlReader& table, ModbusLinkSettings& link) {
    const std::string text = table.text("tcp");
    const auto wrong = [&]() {
        table.refuse("tcp", "is '" + text + "': write \"host\", \"host:port\" or \"[IPv6 address]:port\"");
    };
    std::string rest;
    if (text.front() == '[') {
        const auto end = text.find(']');
        if (end == std::string::npos) wrong();
        link.host = text.substr(1, end - 1);
        rest = text.substr(end + 1);
    } else {
        const auto end = text.find(':');
        link.host = text.substr(0, end);
        if (end != std::string::npos) rest = text.substr(end);
    }
    const auto digits = [](const std::string& port) {
        return !port.empty() && port.size() <= 5 &&
               port.find_first_not_of("0123456789") == std::string::npos && std::stoi(port) >= 1 &&
               std::stoi(port) <= 65535;
    };
    link.port = rest.empty() ? "502" : rest.substr(1);
    if (link.host.empty() || link.host.find_first_of(" /") != std::string::npos || !digits(link.port) ||
        (!rest.empty() && rest.front() != ':'))
        wrong();
}

inline void serial(TomlReader& table, ModbusLinkSettings& link, std::set<std::string>& names) {
    link.path = table.text("rtu");
    if (!names.insert(link.path).second)
        table.refuse("rtu",
                     "is '" + link.path + "', the line of another link, whose channels may name device");
    if (link.path.front() != '/')
        table.refuse("rtu", "is '" + link.path + "', no absolute path such as /dev/serial/by-id/...");
    link.serial.baud = static_cast<int>(table.whole_or("baud", 19200, 1, 10000000));
    std::string all;
    bool known = false;
    for (const auto& [baud, speed] : speeds()) {
        all += " " + std::to_string(baud);
        if (baud == link.serial.baud) {
            known = true;
            link.serial.speed = speed;
        }
    }
    if (!known) table.refuse("baud", "is " + std::to_string(link.serial.baud) + ", not one of" + all);
    link.serial.parity = table.choice_or<char>("parity", 'E', {{"even", 'E'}, {"odd", 'O'}, {"none", 'N'}});
    link.serial.stop_bits = static_cast<int>(table.whole_or("stop-bits", 1, 1, 2));
}

inline void encoding(TomlReader& table, ModbusChannel& channel) {
    using Type = ModbusEncoding::Type;
    ModbusEncoding& encoding = channel.encoding;
    encoding.type = table.choice_or<Type>("type", Type::u16,
                                          {{"bit", Type::bit},
                                           {"u16", Type::u16},
                                           {"s16", Type::s16},
                                           {"u32", Type::u32},
                                           {"s32", Type::s32},
                                           {"u64", Type::u64},
                                           {"s64", Type::s64},
                                           {"bcd16", Type::bcd16},
                                           {"bcd32", Type::bcd32},
                                           {"f32", Type::f32},
                                           {"f64", Type::f64}});
    const std::vector<std::pair<std::string, bool>> orders{{"high-first", false}, {"low-first", true}};
    encoding.low_word_first = table.choice_or<bool>("words", false, orders);
    encoding.low_byte_first = table.choice_or<bool>("bytes", false, orders);
    const int width = 16 * encoding.registers();
    if (encoding.type == Type::bit) {
        encoding.first_bit = static_cast<int>(table.whole("first-bit", 0, 15));
    } else if (table.has("first-bit") || table.has("bits")) {
        if (encoding.is_float() || encoding.is_decimal())
            table.refuse("bits", "are a part of a whole number, not of a float or of decimal digits");
        if (channel.output) table.refuse("bits", "cannot be written: an output is a whole register");
        encoding.first_bit = static_cast<int>(table.whole("first-bit", 0, width - 1));
        encoding.bits = static_cast<int>(table.whole("bits", 1, width - encoding.first_bit));
    }
}

inline ModbusChannel channel(TomlReader table, const ModbusLinkSettings& link, std::set<std::string>& names,
                             int device, bool output) {
    ModbusChannel channel;
    channel.output = output;
    channel.name = sensor_keys::name(table, names);
    const int first_device = link.is_serial() ? 1 : 0, last_device = link.is_serial() ? 247 : 255;
    channel.device = static_cast<int>(table.whole_or("device", device, first_device, last_device));
    channel.table = output ? table.choice_or<ModbusTable>(
                                 "table", ModbusTable::holding,
                                 {{"holding", ModbusTable::holding}, {"coil", ModbusTable::coil}})
                           : table.choice<ModbusTable>("table", {{"holding", ModbusTable::holding},
                                                                 {"input", ModbusTable::input},
                                                                 {"coil", ModbusTable::coil},
                                                                 {"discrete", ModbusTable::discrete}});
    const bool of_bits = channel.table == ModbusTable::coil || channel.table == ModbusTable::discrete;
    if (of_bits) {
        channel.encoding.type = ModbusEncoding::Type::bit;
        channel.first = static_cast<int>(table.whole("bit", 0, 65535));
    } else {
        channel.first = static_cast<int>(table.whole("register", 0, 65535));
        encoding(table, channel);
        if (channel.first + channel.encoding.registers() > 65536)
            table.refuse("register", "leaves no room for the type: the last register is 65535");
    }
    if (output && channel.encoding.type == ModbusEncoding::Type::bit && !of_bits)
        table.refuse("type", "is bit, which cannot be written alone: write the whole register, or a coil");
    channel.every = table.number_or("every", 0.1, 0.001, 3600);
    channel.limits.max_age = sensor_keys::max_age(table, channel.every);
    if (!channel.is_bit()) {
        channel.scale = sensor_keys::scale(table);
        if (output) {
            channel.limits.min = table.number("min", -sensor_keys::unbounded, sensor_keys::unbounded);
            channel.limits.max = table.number("max", -sensor_keys::unbounded, sensor_keys::unbounded);
            if (channel.limits.min >= channel.limits.max) table.refuse("max", "is not above min");
            if (channel.encoding.registers() == 1) channel.multiple = table.flag_or("multiple", false);
        } else {
            sensor_keys::bounds(table, channel.limits);
        }
    }
    table.end();
    return channel;
}

inline ModbusLinkSettings link(TomlReader table, std::set<std::string>& names) {
    ModbusLinkSettings link;
    link.name = sensor_keys::name(table, names);
    if (table.has("tcp") == table.has("rtu")) table.refuse("tcp", "or rtu: a link has one of the two");
    if (table.has("tcp"))
        tcp(table, link);
    else
        serial(table, link, names);
    sensor_keys::times(table, link);
    if (link.is_serial()) sensor_keys::demand_long_retry(table, link);
    link.gap = static_cast<int>(table.whole_or("gap", 0, 0, 100));
    const bool serial = link.is_serial();
    const int device = static_cast<int>(table.whole_or("device", 1, serial ? 1 : 0, serial ? 247 : 255));
    for (const TomlReader& its : table.tables("channel"))
        link.channels.push_back(channel(its, link, names, device, false));
    for (const TomlReader& its : table.tables("output"))
        link.channels.push_back(channel(its, link, names, device, true));
    if (link.channels.empty()) table.refuse("channel", "is missing: write [[link.channel]]");
    table.end();
    return link;
}

}  // namespace modbus_settings

inline ModbusSettings ModbusSettings::read(const std::filesystem::path& file) {
    return sensor_keys::read<ModbusSettings>(file, modbus_settings::link);
}

}  // namespace plumb
