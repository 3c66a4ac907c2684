// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace plumb {

// A number in the bytes of a frame. Bits are counted as in DBC files: bit 8 * i + k is the bit k of byte i,
// and 0 is the lowest of a byte. An Intel number begins with its lowest bit and goes up; a Motorola number
// begins with its highest bit and goes down, from bit 0 of a byte to bit 7 of the next one.
struct CanSignal {
    enum class Type { unsigned_number, signed_number, f32, f64 };

    static constexpr int most_bits = 8 * 64;  // of a frame

    int start = 0;
    int length = 16;  // bits, 1 to 64
    bool motorola = false;
    Type type = Type::unsigned_number;

    // How many bytes of a frame it needs; more than 64 if no frame holds it.
    std::size_t bytes() const noexcept {
        const int last = motorola ? 8 * (start / 8) + (7 - start % 8) + length - 1 : start + length - 1;
        return static_cast<std::size_t>(last / 8 + 1);
    }
};

// The bits of a signal, the highest first. The frame has at least signal.bytes() bytes.
inline std::uint64_t raw_bits(const CanSignal& signal, const std::uint8_t* bytes) noexcept {
    std::uint64_t raw = 0;
    // In the order of transmission, bit 7 of each byte comes first.
    const int first = 8 * (signal.start / 8) + (7 - signal.start % 8);
    for (int i = 0; i < signal.length; ++i) {
        const int bit = signal.motorola ? first + i : signal.start + signal.length - 1 - i;
        const int shift = signal.motorola ? 7 - bit % 8 : bit % 8;
        raw = raw << 1 | (static_cast<std::uint64_t>(bytes[bit / 8]) >> shift & 1);
    }
    return raw;
}

// The number; a float that is not a number stays one.
inline double decoded(const CanSignal& signal, const std::uint8_t* bytes) noexcept {
    const std::uint64_t raw = raw_bits(signal, bytes);
    switch (signal.type) {
        case CanSignal::Type::f32: {
            const auto half = static_cast<std::uint32_t>(raw);
            float value;
            std::memcpy(&value, &half, sizeof value);
            return static_cast<double>(value);
        }
        case CanSignal::Type::f64: {
            double value;
            std::memcpy(&value, &raw, sizeof value);
            return value;
        }
        case CanSignal::Type::signed_number: {
            const std::uint64_t sign = std::uint64_t{1} << (signal.length - 1);
            return static_cast<double>(static_cast<std::int64_t>((raw ^ sign) - sign));
        }
        default: return static_cast<double>(raw);
    }
}

}  // namespace plumb
