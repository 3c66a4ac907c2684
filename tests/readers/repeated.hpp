// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace plumb::readers {

// Bytes of which a part may be repeated: \1 begins the part, \2 ends it, and the byte behind that is the
// number of times that it doubles. So a few bytes are a line of many megabytes, or brackets by the
// thousand.
inline std::string repeated(std::string_view bytes, std::size_t longest) {
    std::string text;
    while (!bytes.empty()) {
        const std::size_t begin = bytes.find('\1');
        text += bytes.substr(0, begin);
        if (begin == std::string_view::npos) break;
        bytes.remove_prefix(begin + 1);
        const std::size_t end = std::min(bytes.find('\2'), bytes.size());
        const std::string part(bytes.substr(0, end));
        bytes.remove_prefix(std::min(end + 1, bytes.size()));
        const unsigned doublings = bytes.empty() ? 0 : static_cast<unsigned char>(bytes.front()) % 32;
        if (!bytes.empty()) bytes.remove_prefix(1);
        for (std::size_t count = std::size_t{1} << doublings; count > 0 && !part.empty(); --count) {
            if (text.size() + part.size() > longest) break;
            text += part;
        }
    }
    return text;
}

}  // namespace plumb::readers
