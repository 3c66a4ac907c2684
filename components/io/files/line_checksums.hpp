// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <boost/crc.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

namespace plumb {

// The checksums of a file of lines that is only appended to, from its first line on. Each line ends with a
// comma and the CRC-32 of all lines up to it, without their checksums, each with a line feed. So a changed
// line is found, and a lost or moved one too; the file up to the end of any line is whole.
class LineChecksums {
public:
    static constexpr std::size_t digits = 8;

    // The same lines with their checksums. Each ends with a line feed.
    std::string added(std::string_view lines) {
        std::string result;
        while (!lines.empty()) {
            const std::size_t end = std::min(lines.find('\n'), lines.size() - 1);
            const std::string_view line = lines.substr(0, end);
            result.append(line).append(",").append(next(line)).append("\n");
            lines.remove_prefix(end + 1);
        }
        return result;
    }

    // The next line, which has no line feed, without its checksum. Nothing if that is not its own.
    std::optional<std::string_view> checked(std::string_view line) {
        if (line.size() < digits + 1 || line[line.size() - digits - 1] != ',') return std::nullopt;
        const std::string_view content = line.substr(0, line.size() - digits - 1);
        if (next(content) != line.substr(line.size() - digits)) return std::nullopt;
        return content;
    }

private:
    std::string next(std::string_view line) {
        crc_.process_bytes(line.data(), line.size());
        crc_.process_byte('\n');
        char text[digits + 1];
        std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(crc_.checksum()));
        return text;
    }

    boost::crc_32_type crc_;
};

}  // namespace plumb
