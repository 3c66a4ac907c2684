// SPDX-License-Identifier: GPL-2.0-or-later
// libmodbus puts words together and takes them apart; their order, bit fields and floats are ours: its
// modbus_get_float_abcd() of 3.1.6 reads the bytes in another order than later versions do.
#pragma once

#include <modbus/modbus.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

namespace plumb {

// How a number lies in registers of 16 bits.
struct ModbusEncoding {
    enum class Type { bit, u16, s16, u32, s32, u64, s64, bcd16, bcd32, f32, f64 };

    Type type = Type::u16;
    bool low_word_first = false;
    bool low_byte_first = false;  // within a register
    int first_bit = 0;            // of a bit or a bit field; 0 is the lowest
    int bits = 0;                 // of a bit field; 0 for the whole number

    int registers() const noexcept {
        switch (type) {
            case Type::bit:
            case Type::u16:
            case Type::s16:
            case Type::bcd16: return 1;
            case Type::u64:
            case Type::s64:
            case Type::f64: return 4;
            default: return 2;
        }
    }
    bool is_float() const noexcept { return type == Type::f32 || type == Type::f64; }
    bool is_signed() const noexcept { return type == Type::s16 || type == Type::s32 || type == Type::s64; }
    bool is_decimal() const noexcept { return type == Type::bcd16 || type == Type::bcd32; }
};

namespace modbus_value {

inline std::uint16_t ordered(std::uint16_t word, const ModbusEncoding& encoding) noexcept {
    return encoding.low_byte_first ? static_cast<std::uint16_t>(word << 8 | word >> 8) : word;
}

// Which of the registers holds the word number i, counted from the highest.
inline int place(int i, const ModbusEncoding& encoding) noexcept {
    return encoding.low_word_first ? encoding.registers() - 1 - i : i;
}

// A digit in four bits each; NaN if one is above 9.
inline double of_digits(std::uint64_t raw) noexcept {
    double number = 0;
    for (int shift = 28; shift >= 0; shift -= 4) {
        const std::uint64_t digit = raw >> shift & 15;
        if (digit > 9) return std::numeric_limits<double>::quiet_NaN();
        number = 10 * number + static_cast<double>(digit);
    }
    return number;
}

// The inverse.
inline std::uint64_t digits_of(std::uint64_t number) noexcept {
    std::uint64_t raw = 0;
    for (int shift = 0; number > 0; shift += 4, number /= 10) raw |= number % 10 << shift;
    return raw;
}

template <class To, class From>
To same_bits(From from) noexcept {
    static_assert(sizeof(To) == sizeof(From));
    To to;
    std::memcpy(&to, &from, sizeof to);
    return to;
}

}  // namespace modbus_value

// The number in encoding.registers() registers. A bit is 0 or 1; a bit field of a signed type has a sign.
inline double decoded(const std::uint16_t* registers, const ModbusEncoding& encoding) noexcept {
    using namespace modbus_value;
    using Type = ModbusEncoding::Type;
    std::uint16_t words[4] = {};  // from the highest
    for (int i = 0; i < encoding.registers(); ++i)
        words[i] = ordered(registers[place(i, encoding)], encoding);
    std::uint64_t raw = words[0];
    if (encoding.registers() == 2) raw = static_cast<std::uint32_t>(MODBUS_GET_INT32_FROM_INT16(words, 0));
    if (encoding.registers() == 4) raw = static_cast<std::uint64_t>(MODBUS_GET_INT64_FROM_INT16(words, 0));
    if (encoding.type == Type::f32)
        return static_cast<double>(same_bits<float>(static_cast<std::uint32_t>(raw)));
    if (encoding.type == Type::f64) return same_bits<double>(raw);
    if (encoding.type == Type::bit) return static_cast<double>(raw >> encoding.first_bit & 1);
    if (encoding.is_decimal()) return of_digits(raw);
    const int width = encoding.bits > 0 ? encoding.bits : 16 * encoding.registers();
    const std::uint64_t mask = ~std::uint64_t{0} >> (64 - width);
    raw = raw >> encoding.first_bit & mask;
    const bool negative = encoding.is_signed() && (raw >> (width - 1) & 1) != 0;
    return negative ? static_cast<double>(static_cast<std::int64_t>(raw | ~mask)) : static_cast<double>(raw);
}

// The inverse: writes encoding.registers() registers, rounded to the nearest whole number where the type is
// one. False, and nothing is written, if the type does not hold the number. Bit fields cannot be written.
inline bool encode(double value, const ModbusEncoding& encoding, std::uint16_t* registers) noexcept {
    using namespace modbus_value;
    using Type = ModbusEncoding::Type;
    std::uint64_t raw = 0;
    if (!std::isfinite(value) || encoding.bits > 0) return false;
    if (encoding.type == Type::f32) {
        if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) return false;
        raw = same_bits<std::uint32_t>(static_cast<float>(value));
    } else if (encoding.type == Type::f64) {
        raw = same_bits<std::uint64_t>(value);
    } else {
        const double whole = std::round(value);
        const int width = 16 * encoding.registers();
        const double span = encoding.type == Type::bit ? 2
                            : encoding.is_decimal()    ? std::pow(10, width / 4)
                                                       : std::ldexp(1, width);
        const double least = encoding.is_signed() ? -span / 2 : 0;
        if (whole < least || whole >= least + span) return false;
        raw = whole < 0 ? static_cast<std::uint64_t>(static_cast<std::int64_t>(whole))
                        : static_cast<std::uint64_t>(whole);
        if (encoding.is_decimal()) raw = digits_of(raw);
    }
    std::uint16_t words[4] = {static_cast<std::uint16_t>(raw)};
    if (encoding.registers() == 2) MODBUS_SET_INT32_TO_INT16(words, 0, raw);
    if (encoding.registers() == 4) MODBUS_SET_INT64_TO_INT16(words, 0, raw);
    for (int i = 0; i < encoding.registers(); ++i)
        registers[place(i, encoding)] = ordered(words[i], encoding);
    return true;
}

}  // namespace plumb
