// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/growth_log_file.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

namespace plumb {

// The logs of growth tests in a folder, by the number in their heads: names and times of files come from a
// clock, which may be wrong.
struct GrowthLogs {
    int number = 0;                           // the highest
    std::filesystem::path last, same_number;  // that have it; empty without one
    std::filesystem::path damaged;            // one whose number cannot be trusted
};

inline GrowthLogs growth_logs_in(const std::filesystem::path& folder) {
    GrowthLogs logs;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name.rfind("growth-", 0) != 0 || entry.path().extension() != ".csv") continue;
        if (!entry.is_regular_file()) continue;
        std::string start(growth_log_file::identity_bytes, '\0');
        std::ifstream file(entry.path());
        file.read(start.data(), static_cast<std::streamsize>(start.size()));
        start.resize(static_cast<std::size_t>(file.gcount()));
        const growth_log_file::Identity its = growth_log_file::identity_of(start);
        if (its.damaged) logs.damaged = entry.path();
        if (its.number > logs.number || logs.last.empty()) {
            logs.last = entry.path();
            logs.same_number.clear();
        } else if (its.number == logs.number) {
            logs.same_number = entry.path();
        }
        logs.number = std::max(logs.number, its.number);
    }
    return logs;
}

// The log with the highest number. A log without a number is the last one only if it is the only one. Throws
// if one of them is damaged at its number: it may be the last one.
inline std::optional<std::filesystem::path> last_growth_log(const std::filesystem::path& folder) {
    const GrowthLogs logs = growth_logs_in(folder);
    if (!logs.damaged.empty()) {
        read_growth_log(logs.damaged);  // which names line and reason
        throw std::runtime_error(logs.damaged.string() + ": its number is damaged");
    }
    if (logs.last.empty() || (!logs.same_number.empty() && logs.number == 0)) return std::nullopt;
    if (!logs.same_number.empty())
        throw std::runtime_error(logs.last.string() + " and " + logs.same_number.string() +
                                 " have the same number, " + std::to_string(logs.number) +
                                 ": move one of them out of the folder");
    return logs.last;
}

}  // namespace plumb
