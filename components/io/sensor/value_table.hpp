// SPDX-License-Identifier: GPL-2.0-or-later
// What --list prints.
#pragma once

#include "components/io/sensor/link_state.hpp"

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

inline std::vector<std::string> shown(const Reading& reading, const std::string& unit) {
    const char* const fault = sentence(reading.fault);
    const double age = std::round(reading.age * 1000) / 1000;
    return {reading.any ? shown(reading.value) : "-", unit, reading.valid ? "yes" : "no", shown(age) + " s",
            fault ? fault : "-"};
}

// Starts the links of a deque of Workers, prints all channels when they are valid or the time is over, and
// returns the exit status: 1 if a channel is not valid. Outputs are left out.
template <class Links>
int list_values(Links& links, double seconds, std::ostream& out) {
    for (auto& link : links) link.start();
    const auto each = [&](auto&& look) {
        for (auto& link : links) {
            auto& state = link.state();
            const std::lock_guard lock(state.mutex);
            for (std::size_t i = 0; i < state.judges.size(); ++i)
                if (!state.settings.channels[i].output)
                    look(state.settings, state.settings.channels[i], state.judges[i].at(seconds_now()));
        }
    };
    const auto all_valid = [&] {
        bool valid = true;
        each([&](const auto&, const auto&, const Reading& reading) { valid &= reading.valid; });
        return valid;
    };
    for (const double until = seconds_now() + seconds; seconds_now() < until && !all_valid();)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    TextTable table({"link", "channel", "value", "unit", "valid", "age", "fault"});
    bool valid = true;
    each([&](const auto& link, const auto& channel, const Reading& reading) {
        std::vector<std::string> row{link.name, channel.name};
        for (std::string& text : shown(reading, channel.is_bit() ? "bit" : channel.scale.unit))
            row.push_back(std::move(text));
        table.add(std::move(row));
        valid &= reading.valid;
    });
    table.write(out);
    for (auto& link : links) link.ask_to_stop();
    return valid ? 0 : 1;
}

}  // namespace plumb
