// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/can_sensor/can_signal.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace plumb {

// A frame of data as it was received.
struct CanFrame {
    std::uint32_t id = 0;  // 11 or 29 bits
    bool extended = false;
    std::size_t size = 0;
    std::uint8_t bytes[64] = {};
};

// Which frames carry a signal.
struct CanMatch {
    static constexpr std::uint32_t standard_bits = 0x7FF, extended_bits = 0x1FFFFFFF;

    std::uint32_t id = 0;
    std::uint32_t mask = standard_bits;  // bits of the id that have to agree
    bool extended = false;

    bool operator()(const CanFrame& frame) const noexcept {
        return frame.extended == extended && ((frame.id ^ id) & mask) == 0;
    }

    // A parameter group of SAE J1939, from any sender or from one. The priority is left out, and so is the
    // receiver, which the id of a group below 0xF000 names in the place of the lowest eight bits of the
    // number.
    static CanMatch parameter_group(std::uint32_t number, std::optional<std::uint32_t> sender) noexcept {
        const bool to_one = (number >> 8 & 0xFF) < 240;
        CanMatch match;
        match.extended = true;
        match.id = (number & (to_one ? 0x3FF00 : 0x3FFFF)) << 8 | sender.value_or(0);
        match.mask = (to_one ? 0x3FF0000u : 0x3FFFF00u) | (sender ? 0xFFu : 0u);
        return match;
    }
};

// A signal that is in the frame only while another one, the multiplexer, has a value from first to last.
struct CanMultiplexer {
    CanSignal signal;
    std::uint64_t first = 0, last = 0;
};

}  // namespace plumb
