// SPDX-License-Identifier: GPL-2.0-or-later
// Requests to Modbus devices and the judgement of their replies, after "MODBUS Application Protocol
// Specification V1.1b3". libmodbus sends and receives the frames.
//
// A reply is compared with its request in every field: libmodbus accepts the reply of another unit over TCP.
#pragma once

#include <modbus/modbus.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumb {

enum class ModbusTable { holding, input, coil, discrete };

// Reading `count` registers or bits, or, with `words`, writing them.
struct ModbusRequest {
    int device = 1;
    ModbusTable table = ModbusTable::holding;
    int first = 0;  // register or bit, counted from 0
    int count = 1;
    std::vector<std::uint16_t> words = {};  // to write: registers, or one coil as 0 or 1
    bool multiple = false;                  // writes one register as several are written

    bool writes() const { return !words.empty(); }
    bool of_bits() const { return table == ModbusTable::coil || table == ModbusTable::discrete; }
    int function() const {
        if (writes())
            return table == ModbusTable::coil       ? MODBUS_FC_WRITE_SINGLE_COIL
                   : words.size() == 1 && !multiple ? MODBUS_FC_WRITE_SINGLE_REGISTER
                                                    : MODBUS_FC_WRITE_MULTIPLE_REGISTERS;
        switch (table) {
            case ModbusTable::coil: return MODBUS_FC_READ_COILS;
            case ModbusTable::discrete: return MODBUS_FC_READ_DISCRETE_INPUTS;
            case ModbusTable::input: return MODBUS_FC_READ_INPUT_REGISTERS;
            default: return MODBUS_FC_READ_HOLDING_REGISTERS;
        }
    }

    // Device, function and data.
    std::vector<std::uint8_t> bytes() const {
        const int its = function();
        const int second = its == MODBUS_FC_WRITE_SINGLE_COIL       ? (words[0] != 0 ? 0xFF00 : 0)
                           : its == MODBUS_FC_WRITE_SINGLE_REGISTER ? words[0]
                           : writes()                               ? static_cast<int>(words.size())
                                                                    : count;
        std::vector<std::uint8_t> result(6);
        result[0] = static_cast<std::uint8_t>(device);
        result[1] = static_cast<std::uint8_t>(its);
        MODBUS_SET_INT16_TO_INT8(result.data(), 2, first);
        MODBUS_SET_INT16_TO_INT8(result.data(), 4, second);
        if (its == MODBUS_FC_WRITE_MULTIPLE_REGISTERS) {
            result.resize(7 + 2 * words.size());
            result[6] = static_cast<std::uint8_t>(2 * words.size());
            for (std::size_t i = 0; i < words.size(); ++i)
                MODBUS_SET_INT16_TO_INT8(result.data(), 7 + 2 * i, words[i]);
        }
        return result;
    }

    // Bytes of registers or bits in a reply.
    int data_size() const { return of_bits() ? (count + 7) / 8 : 2 * count; }

    // Device, function and data of a reply that is not an exception.
    std::size_t reply_size() const { return writes() ? 6 : 3 + static_cast<std::size_t>(data_size()); }
};

struct ModbusReply {
    enum class Status { silent, good, exception, wrong };

    Status status = Status::silent;
    int exception = 0;                      // number of the device's refusal
    std::vector<std::uint16_t> words = {};  // registers, or bits as 0 or 1
};

inline ModbusReply modbus_wrong() {
    ModbusReply reply;
    reply.status = ModbusReply::Status::wrong;
    return reply;
}

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

// Device, function and data of an exception.
constexpr std::size_t modbus_exception_size = 3;

// The judgement of a reply's device, function and data.
inline ModbusReply modbus_reply_of(const ModbusRequest& request, const std::uint8_t* bytes,
                                   std::size_t size) {
    ModbusReply reply = modbus_wrong();
    if (size < modbus_exception_size || bytes[0] != request.device) return reply;
    if (bytes[1] == (request.function() | 0x80) && size == modbus_exception_size) {
        reply.status = ModbusReply::Status::exception;
        reply.exception = bytes[2];
        return reply;
    }
    if (bytes[1] != request.function() || size != request.reply_size()) return reply;
    if (request.writes()) {  // the reply repeats the beginning of the request
        if (!std::equal(bytes, bytes + size, request.bytes().begin())) return reply;
    } else if (bytes[2] != request.data_size()) {
        return reply;
    } else if (request.of_bits()) {
        std::vector<std::uint8_t> bits(static_cast<std::size_t>(request.count));
        modbus_set_bits_from_bytes(bits.data(), 0, static_cast<unsigned>(request.count), bytes + 3);
        reply.words.assign(bits.begin(), bits.end());
    } else {
        for (int i = 0; i < request.count; ++i)
            reply.words.push_back(static_cast<std::uint16_t>(MODBUS_GET_INT16_FROM_INT8(bytes, 3 + 2 * i)));
    }
    reply.status = ModbusReply::Status::good;
    return reply;
}

// On a serial line, behind it: two bytes of checksum.
constexpr std::size_t modbus_checksum_size = 2;

// The shortest reply on a serial line. Fewer bytes without a request are stray ones.
constexpr std::size_t modbus_shortest = modbus_exception_size + modbus_checksum_size;

inline bool modbus_checksum_holds(const std::uint8_t* bytes, std::size_t size) {
    unsigned rest = 0xFFFF;
    for (std::size_t i = 0; i < size; ++i) {
        rest ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) rest = rest >> 1 ^ (rest & 1 ? 0xA001 : 0);
    }
    return rest == 0;  // with the checksum behind its bytes
}

// The judgement of a reply on a serial line, with stray bytes before and behind it.
inline ModbusReply modbus_line_reply_of(const ModbusRequest& request,
                                        const std::vector<std::uint8_t>& bytes) {
    for (const std::size_t size : {request.reply_size() + modbus_checksum_size, modbus_shortest}) {
        if (bytes.size() < size || bytes.size() >= size + modbus_shortest) continue;
        for (std::size_t first = 0; first + size <= bytes.size(); ++first) {
            const std::uint8_t* const its = bytes.data() + first;
            if (!modbus_checksum_holds(its, size)) continue;
            const ModbusReply reply = modbus_reply_of(request, its, size - modbus_checksum_size);
            if (reply.status != ModbusReply::Status::wrong) return reply;
        }
    }
    return modbus_wrong();
}

// In front of it over TCP: the number of the request, 0 for Modbus, and the size of the rest.
constexpr std::size_t modbus_tcp_head = 6;

// How many bytes a reply has whose first six these are; 0 if none to this request has so many.
inline std::size_t modbus_tcp_size(const ModbusRequest& request, const std::uint8_t* bytes) {
    const auto stated = static_cast<std::uint16_t>(MODBUS_GET_INT16_FROM_INT8(bytes, 4));
    const bool possible = stated == modbus_exception_size || stated == request.reply_size();
    return possible ? modbus_tcp_head + stated : 0;
}

inline ModbusReply modbus_tcp_reply_of(const ModbusRequest& request, std::uint16_t number,
                                       const std::uint8_t* bytes, std::size_t size) {
    if (size < modbus_tcp_head || size != modbus_tcp_size(request, bytes) ||
        static_cast<std::uint16_t>(MODBUS_GET_INT16_FROM_INT8(bytes, 0)) != number ||
        MODBUS_GET_INT16_FROM_INT8(bytes, 2) != 0)
        return modbus_wrong();
    return modbus_reply_of(request, bytes + modbus_tcp_head, size - modbus_tcp_head);
}

}  // namespace plumb
