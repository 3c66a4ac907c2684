// SPDX-License-Identifier: GPL-2.0-or-later
// What LinuxCNC's rtapi_app sends to the process that has HAL's modules, and gets back: text in LinuxCNC 2.9,
// binary frames in 2.10.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::host {

struct RtapiAnswer {
    int result;               // 0, or a negative errno; status of the program that asked
    std::string output = {};  // which it prints; 2.9 has none
};

// The words of a request of 2.9: "COUNT " and then "LENGTH BYTES" for each word. Nothing if the request is
// not complete. Throws std::runtime_error if it is something else, or longer than 256 KiB.
std::optional<std::vector<std::string>> words_of_text(std::string_view received);
std::string text_of(const RtapiAnswer& answer);

// The words of a request of 2.10: the size of the frame, the number of words, and then length and bytes of
// each word. Numbers have 16 bits, the low byte first. Nothing if the frame is not complete. Throws
// std::runtime_error if its sizes contradict each other.
std::optional<std::vector<std::string>> words_of_frame(std::string_view received);

// Output beyond the size of a frame is cut off.
std::string frame_of(const RtapiAnswer& answer);

}  // namespace plumb::host
