// SPDX-License-Identifier: GPL-2.0-or-later
// Numbers as text, for files: the shortest decimals that read back to the same value.
#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "hal/host/time.hpp"

namespace plumb::host {

// Appends a number: digits, "nan", "inf" or "-inf".
inline void append_number(std::string& text, double number) {
    char digits[32];
    text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

// Appends a time in s, exactly.
inline void append_seconds(std::string& text, Nanoseconds time) {
    char digits[32];
    if (time < 0) text += '-';
    const auto magnitude = static_cast<std::uint64_t>(time < 0 ? -time : time);
    text.append(digits, std::to_chars(digits, digits + sizeof digits, magnitude / one_second).ptr);
    const std::uint64_t fraction = magnitude % one_second;
    if (fraction == 0) return;
    const char* const end = std::to_chars(digits, digits + sizeof digits, one_second + fraction).ptr;
    std::string_view decimals(digits + 1,
                              static_cast<std::size_t>(end - digits - 1));  // without the leading 1
    decimals.remove_suffix(decimals.size() - 1 - decimals.find_last_not_of('0'));
    text += '.';
    text += decimals;
}

// Reads a number that fills the whole text; nothing when it does not.
inline std::optional<double> number_of(std::string_view text) {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    double number = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

}  // namespace plumb::host
