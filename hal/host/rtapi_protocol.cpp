// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/rtapi_protocol.hpp"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

namespace plumb::host {

namespace {

constexpr std::size_t longest_text = 1 << 18;  // bytes of a request

// Reads "COUNT " from `at` on and moves `at` behind it. Nothing when the text is not complete.
// Throws std::runtime_error when it is no number.
std::optional<std::size_t> take_number(std::string_view text, std::size_t& at) {
    constexpr std::size_t most_digits = 9;
    const std::string_view rest = text.substr(at, most_digits + 1);
    const std::size_t digits = std::min(rest.find_first_not_of("0123456789"), rest.size());
    const bool ends = digits < rest.size();
    if (digits > most_digits || (ends && (rest[digits] != ' ' || digits == 0)))
        throw std::runtime_error("a number is wrong");
    if (!ends) return std::nullopt;
    const std::size_t number = std::stoul(std::string(rest.substr(0, digits)));
    const std::size_t end = at + digits;
    at = end + 1;
    return number;
}

std::size_t number_at(std::string_view frame, std::size_t at) {
    if (frame.size() < at + 2) throw std::runtime_error("a word does not fit into its frame");
    return static_cast<std::uint8_t>(frame[at]) + 256U * static_cast<std::uint8_t>(frame[at + 1]);
}

void append(std::string& frame, std::uint32_t number, int bytes) {
    for (int i = 0; i < bytes; ++i) frame += static_cast<char>(number >> 8 * i);
}

}  // namespace

std::optional<std::vector<std::string>> words_of_text(std::string_view received) {
    const auto incomplete = [&]() -> std::optional<std::vector<std::string>> {
        if (received.size() > longest_text) throw std::runtime_error("it is too long");
        return std::nullopt;
    };
    std::size_t at = 0;
    const auto count = take_number(received, at);
    if (!count) return incomplete();
    std::vector<std::string> words;
    while (words.size() < *count) {
        const auto length = take_number(received, at);
        if (!length || received.size() - at < *length) return incomplete();
        words.emplace_back(received.substr(at, *length));
        at += *length;
    }
    return words;
}

std::string text_of(const RtapiAnswer& answer) {
    return std::to_string(answer.result) + " ";
}

std::optional<std::vector<std::string>> words_of_frame(std::string_view received) {
    if (received.size() < 2) return std::nullopt;
    const std::size_t size = number_at(received, 0);
    if (size < 4) throw std::runtime_error("a frame of " + std::to_string(size) + " bytes is too short");
    if (received.size() < size) return std::nullopt;
    const std::string_view frame = received.substr(0, size);
    std::vector<std::string> words(number_at(frame, 2));
    std::size_t at = 4;
    for (std::string& word : words) {
        const std::size_t length = number_at(frame, at);
        at += 2;
        if (frame.size() - at < length) throw std::runtime_error("a word does not fit into its frame");
        word = frame.substr(at, length);
        at += length;
    }
    if (at != size) throw std::runtime_error("a frame has bytes behind its last word");
    return words;
}

std::string frame_of(const RtapiAnswer& answer) {
    constexpr std::size_t head = 2 + 4 + 2;
    const std::string output = answer.output.substr(0, UINT16_MAX - head);
    std::string frame;
    append(frame, static_cast<std::uint32_t>(head + output.size()), 2);
    append(frame, static_cast<std::uint32_t>(answer.result), 4);
    append(frame, static_cast<std::uint32_t>(output.size()), 2);
    return frame + output;
}

}  // namespace plumb::host
