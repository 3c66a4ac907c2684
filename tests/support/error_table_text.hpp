// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

namespace plumb {

// A text of error tables with the line that closes a file of so many rows.
inline std::string closed(std::string text) {
    std::size_t rows = 0;
    for (std::size_t line = 0; line < text.size(); line = text.find('\n', line) + 1) {
        const char first = text[std::min(text.find_first_not_of(" \t", line), text.size())];
        rows += first != 0 && std::string("+-.0123456789").find(first) != std::string::npos;
        if (text.find('\n', line) == std::string::npos) text += '\n';
    }
    return text + "# end, " + std::to_string(rows) + " rows\n";
}

}  // namespace plumb
