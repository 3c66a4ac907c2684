// SPDX-License-Identifier: GPL-2.0-or-later
// What --list prints.
#pragma once

#include "components/io/sensor/reading.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

namespace plumb {

// Columns as wide as their longest text.
class TextTable {
public:
    explicit TextTable(std::vector<std::string> headings) { add(std::move(headings)); }

    void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }

    void write(std::ostream& out) const {
        std::vector<std::size_t> widths(rows_[0].size());
        for (const auto& row : rows_)
            for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
        for (const auto& row : rows_) {
            std::string line;
            for (std::size_t i = 0; i < row.size(); ++i) {
                line += row[i];
                if (i + 1 < row.size()) line += std::string(widths[i] - row[i].size() + 2, ' ');
            }
            out << line << '\n';
        }
    }

private:
    std::vector<std::vector<std::string>> rows_;
};

inline std::string shown(double number) {
    std::ostringstream text;
    text.precision(6);
    text << number;
    return text.str();
}

// value, unit, valid, age and fault of a channel.
inline std::vector<std::string> shown(const Reading& reading, const std::string& unit) {
    const char* const fault = sentence(reading.fault);

    return {!reading.any ? "-" : shown(reading.value), unit, reading.valid ? "yes" : "no",
            shown(std::round(reading.age * 1000) / 1000) + " s", fault ? fault : "-"};
}

}  // namespace plumb
