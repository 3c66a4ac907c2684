// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

// For any reader of comma-separated values.
namespace plumb::csv {

constexpr std::size_t most_bytes = 4 << 20;

// Throws std::runtime_error with the file and the reason.
inline std::string text_of(const std::filesystem::path& file, std::size_t most = most_bytes) {
    const auto refuse = [&](const std::string& why) { throw std::runtime_error(file.string() + ": " + why); };
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) refuse(std::strerror(ENOENT));
    if (!std::filesystem::is_regular_file(status)) refuse("is no regular file");
    if (std::filesystem::file_size(file, error) > most)
        refuse("is longer than " + std::to_string(most >> 20) + " MiB");
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    if (!stream) refuse(std::strerror(errno));
    text << stream.rdbuf();
    return text.str();
}

inline std::string_view without_byte_order_mark(std::string_view text) {
    constexpr std::string_view mark = "\xef\xbb\xbf";
    if (text.substr(0, mark.size()) == mark) text.remove_prefix(mark.size());
    return text;
}

inline std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return "";
    return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

inline std::vector<std::string_view> split_at_commas(std::string_view line) {
    std::vector<std::string_view> fields;
    for (;;) {
        const std::size_t comma = line.find(',');
        fields.push_back(trimmed(line.substr(0, comma)));
        if (comma == std::string_view::npos) return fields;
        line.remove_prefix(comma + 1);
    }
}

// Finite, with a decimal point in every locale; else nothing.
inline std::optional<double> number(std::string_view field) {
    if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
    double value = 0;
    const char* const end = field.data() + field.size();
    const auto [rest, error] = std::from_chars(field.data(), end, value);
    if (error != std::errc() || rest != end || !std::isfinite(value)) return std::nullopt;
    return value;
}

// Any content of a file, as a message quotes it.
inline std::string quoted(std::string_view text) {
    std::string result = "'";
    for (const char c : text.substr(0, 40)) result += c >= ' ' && c <= '~' ? c : '?';
    return result + (text.size() > 40 ? "...'" : "'");
}

inline std::string decimal(double value) {
    char digits[32];
    return std::string(
        digits, std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, 9).ptr);
}

}  // namespace plumb::csv
