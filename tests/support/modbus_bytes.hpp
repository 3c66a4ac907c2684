// SPDX-License-Identifier: GPL-2.0-or-later
// Frames of Modbus as bytes, for devices in tests. None of it is libmodbus, so that neither checks itself.
#pragma once

#include <cstdint>
#include <vector>

namespace plumb::modbus_bytes {

using Bytes = std::vector<std::uint8_t>;

inline void add_word(Bytes& bytes, int word) {
    bytes.push_back(static_cast<std::uint8_t>(word >> 8 & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(word & 0xFF));
}

inline Bytes with_checksum(Bytes bytes) {
    unsigned sum = 0xFFFF;
    for (const std::uint8_t byte : bytes) {
        sum ^= byte;
        for (int bit = 0; bit < 8; ++bit) sum = (sum & 1) != 0 ? sum >> 1 ^ 0xA001 : sum >> 1;
    }
    bytes.push_back(static_cast<std::uint8_t>(sum & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(sum >> 8));
    return bytes;
}

}  // namespace plumb::modbus_bytes
