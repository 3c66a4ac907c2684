// SPDX-License-Identifier: GPL-2.0-or-later
// Requests and replies of Modbus as bytes, after "MODBUS Application Protocol Specification V1.1b3", "MODBUS
// Messaging on TCP/IP Implementation Guide V1.0b" and "MODBUS over Serial Line V1.02".
//
// A reply is compared with its request in every field: libmodbus accepts the reply of another unit over TCP.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace plumb {

enum class ModbusTable { holding, input, coil, discrete };

// Reading `count` registers or bits, or, with `words`, writing them.
struct ModbusRequest {
    static constexpr int most_registers = 125, most_bits = 2000;  // of one reply

    int device = 1;
    ModbusTable table = ModbusTable::holding;
    int first = 0;  // register or bit, counted from 0
    int count = 1;
    std::vector<std::uint16_t> words = {};  // to write: registers, or one coil as 0 or 1
    bool multiple = false;                  // writes one register as several are written

    bool writes() const { return !words.empty(); }
    bool of_bits() const { return table == ModbusTable::coil || table == ModbusTable::discrete; }
    std::uint8_t function() const {
        if (writes()) return table == ModbusTable::coil ? 5 : words.size() == 1 && !multiple ? 6 : 16;
        switch (table) {
            case ModbusTable::coil: return 1;
            case ModbusTable::discrete: return 2;
            case ModbusTable::input: return 4;
            default: return 3;
        }
    }
};

struct ModbusReply {
    enum class Status { incomplete, good, exception, wrong };

    Status status = Status::incomplete;
    int exception = 0;                      // number of the device's refusal
    std::vector<std::uint16_t> words = {};  // registers, or bits as 0 or 1
};

// The sentence of an exception.
inline const char* modbus_exception(int number) {
    switch (number) {
        case 1: return "illegal function: the device does not have this table";
        case 2: return "illegal data address: the device does not have these registers";
        case 3: return "illegal data value";
        case 4: return "device failure";
        case 5: return "acknowledge: the device needs more time";
        case 6: return "device busy";
        case 8: return "memory parity error";
        case 10: return "gateway path unavailable";
        case 11: return "gateway: the device does not answer";
        default: return "unknown exception";
    }
}

namespace modbus_frame {

using Bytes = std::vector<std::uint8_t>;

inline std::uint16_t crc(const std::uint8_t* bytes, std::size_t size) noexcept {
    std::uint16_t sum = 0xFFFF;
    for (std::size_t i = 0; i < size; ++i) {
        sum = static_cast<std::uint16_t>(sum ^ bytes[i]);
        for (int bit = 0; bit < 8; ++bit)
            sum = static_cast<std::uint16_t>(sum & 1 ? sum >> 1 ^ 0xA001 : sum >> 1);
    }
    return sum;
}

inline void add_word(Bytes& bytes, int word) {
    bytes.push_back(static_cast<std::uint8_t>(word >> 8 & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(word & 0xFF));
}

inline int word_at(const std::uint8_t* bytes) noexcept {
    return bytes[0] << 8 | bytes[1];
}

// The device and the protocol data unit.
inline Bytes body(const ModbusRequest& request) {
    Bytes bytes{static_cast<std::uint8_t>(request.device), request.function()};
    add_word(bytes, request.first);
    switch (request.function()) {
        case 5: add_word(bytes, request.words[0] != 0 ? 0xFF00 : 0); break;
        case 6: add_word(bytes, request.words[0]); break;
        case 16:
            add_word(bytes, static_cast<int>(request.words.size()));
            bytes.push_back(static_cast<std::uint8_t>(2 * request.words.size()));
            for (const std::uint16_t word : request.words) add_word(bytes, word);
            break;
        default: add_word(bytes, request.count);
    }
    return bytes;
}

// How many bytes device and protocol data unit of the reply have, from the first three; 0 for fewer than
// needed, -1 for none that can be a reply to this request.
inline int body_size(const ModbusRequest& request, const std::uint8_t* bytes, std::size_t size) {
    if (size >= 1 && bytes[0] != request.device) return -1;
    if (size < 2) return 0;
    if (bytes[1] == (request.function() | 0x80)) return 3;
    if (bytes[1] != request.function()) return -1;
    if (request.writes()) return 6;
    if (size < 3) return 0;
    const int data = request.of_bits() ? (request.count + 7) / 8 : 2 * request.count;
    return bytes[2] == data ? 3 + data : -1;
}

// From a complete body.
inline ModbusReply reply_of(const ModbusRequest& request, const std::uint8_t* bytes) {
    ModbusReply reply;
    reply.status = ModbusReply::Status::good;
    if (bytes[1] & 0x80) {
        reply.status = ModbusReply::Status::exception;
        reply.exception = bytes[2];
    } else if (request.writes()) {  // the reply repeats the beginning of the request
        const Bytes sent = body(request);
        for (std::size_t i = 0; i < 6; ++i)
            if (bytes[i] != sent[i]) reply.status = ModbusReply::Status::wrong;
    } else {
        for (int i = 0; i < request.count; ++i)
            reply.words.push_back(static_cast<std::uint16_t>(request.of_bits() ? bytes[3 + i / 8] >> i % 8 & 1
                                                                               : word_at(bytes + 3 + 2 * i)));
    }
    return reply;
}

inline ModbusReply wrong() {
    ModbusReply reply;
    reply.status = ModbusReply::Status::wrong;
    return reply;
}

}  // namespace modbus_frame

// Over TCP: with a number that the reply repeats.
inline std::vector<std::uint8_t> tcp_frame(const ModbusRequest& request, std::uint16_t number) {
    const auto body = modbus_frame::body(request);
    modbus_frame::Bytes bytes;
    modbus_frame::add_word(bytes, number);
    modbus_frame::add_word(bytes, 0);
    modbus_frame::add_word(bytes, static_cast<int>(body.size()));
    bytes.insert(bytes.end(), body.begin(), body.end());
    return bytes;
}

// The bytes that have come so far. Bytes after the end of the reply are wrong: nobody has asked for them.
inline ModbusReply tcp_reply(const ModbusRequest& request, std::uint16_t number, const std::uint8_t* bytes,
                             std::size_t size) {
    using namespace modbus_frame;
    const std::array<std::uint8_t, 4> begin{static_cast<std::uint8_t>(number >> 8),
                                            static_cast<std::uint8_t>(number & 0xFF), 0, 0};
    for (std::size_t i = 0; i < begin.size() && i < size; ++i)
        if (bytes[i] != begin[i]) return wrong();
    if (size < 7) return {};
    const int its_size = body_size(request, bytes + 6, size - 6);
    const int stated = word_at(bytes + 4);
    if (its_size < 0 || (its_size > 0 && stated != its_size)) return wrong();
    if (its_size == 0) return stated >= 3 ? ModbusReply{} : wrong();
    const auto whole = static_cast<std::size_t>(6 + its_size);
    return size < whole ? ModbusReply{} : size > whole ? wrong() : reply_of(request, bytes + 6);
}

// On a serial line: with a checksum.
inline std::vector<std::uint8_t> rtu_frame(const ModbusRequest& request) {
    modbus_frame::Bytes bytes = modbus_frame::body(request);
    const std::uint16_t sum = modbus_frame::crc(bytes.data(), bytes.size());
    bytes.push_back(static_cast<std::uint8_t>(sum & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(sum >> 8));
    return bytes;
}

inline ModbusReply rtu_reply(const ModbusRequest& request, const std::uint8_t* bytes, std::size_t size) {
    using namespace modbus_frame;
    const int its_size = body_size(request, bytes, size);
    if (its_size < 0) return wrong();
    const auto whole = static_cast<std::size_t>(its_size + 2);
    if (its_size == 0 || size < whole) return {};
    const std::uint16_t sum = crc(bytes, whole - 2);
    const bool intact = bytes[whole - 2] == (sum & 0xFF) && bytes[whole - 1] == sum >> 8;
    return size > whole || !intact ? wrong() : reply_of(request, bytes);
}

}  // namespace plumb
