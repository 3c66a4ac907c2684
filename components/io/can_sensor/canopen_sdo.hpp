// SPDX-License-Identifier: GPL-2.0-or-later
// Reading one object of a CANopen device by an expedited SDO upload, and NMT, after CiA 301.
#pragma once

#include "components/io/can_sensor/can_frame.hpp"

#include <cstdint>

namespace plumb {

// An object of a node.
struct CanObject {
    int node = 1;  // 1 to 127
    int index = 0;
    int subindex = 0;
};

namespace canopen {

constexpr std::uint32_t nmt = 0, sdo_reply = 0x580, sdo_request = 0x600, heartbeat = 0x700;
constexpr std::uint8_t boot_up = 0, pre_operational = 127;

inline CanFrame upload_request(const CanObject& object) noexcept {
    CanFrame frame;
    frame.id = sdo_request + static_cast<std::uint32_t>(object.node);
    frame.size = 8;
    frame.bytes[0] = 0x40;
    frame.bytes[1] = static_cast<std::uint8_t>(object.index & 0xFF);
    frame.bytes[2] = static_cast<std::uint8_t>(object.index >> 8);
    frame.bytes[3] = static_cast<std::uint8_t>(object.subindex);
    return frame;
}

inline CanFrame start_node(int node) noexcept {
    CanFrame frame;
    frame.id = nmt;
    frame.size = 2;
    frame.bytes[0] = 1;
    frame.bytes[1] = static_cast<std::uint8_t>(node);
    return frame;
}

struct Upload {
    enum class Status { other, good, abort, wrong };

    Status status = Status::other;
    std::uint32_t abort_code = 0;
    int size = 0;                        // bytes of data
    const std::uint8_t* data = nullptr;  // in the frame
};

// Whether a frame is the reply to the request for an object.
inline Upload upload_reply(const CanObject& object, const CanFrame& frame) noexcept {
    Upload upload;
    if (frame.extended || frame.id != sdo_reply + static_cast<std::uint32_t>(object.node) || frame.size != 8)
        return upload;
    const std::uint8_t* const bytes = frame.bytes;
    if ((bytes[1] | bytes[2] << 8) != object.index || bytes[3] != object.subindex) return upload;
    if (bytes[0] == 0x80) {
        upload.status = Upload::Status::abort;
        upload.abort_code = bytes[4] | static_cast<std::uint32_t>(bytes[5]) << 8 |
                            static_cast<std::uint32_t>(bytes[6]) << 16 |
                            static_cast<std::uint32_t>(bytes[7]) << 24;
        return upload;
    }
    // Expedited, with or without a size; anything else has more than four bytes.
    const bool expedited = (bytes[0] & 0xE2) == 0x42;
    upload.status = expedited ? Upload::Status::good : Upload::Status::wrong;
    upload.size = (bytes[0] & 1) != 0 ? 4 - (bytes[0] >> 2 & 3) : 4;
    upload.data = bytes + 4;
    return upload;
}

}  // namespace canopen
}  // namespace plumb
