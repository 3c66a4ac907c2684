// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/client/duration.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <stdexcept>

namespace plumb::client {
namespace {

struct Unit {
    const char* name;
    std::int64_t length;  // ns
};

// The longest first; the remainder of each of the first four is written in the next unit.
constexpr Unit units[] = {{"d", 86'400'000'000'000},
                          {"h", 3'600'000'000'000},
                          {"min", 60'000'000'000},
                          {"s", 1'000'000'000},
                          {"ms", 1'000'000},
                          {"us", 1'000},
                          {"ns", 1}};

std::string with_unit(double number, const char* unit) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g %s", number, unit);
    return text;
}

}  // namespace

Time parse_duration(const std::string& text) {
    double number = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    std::string unit(rest, end);
    if (unit.empty()) unit = "s";
    if (error == std::errc())
        for (const Unit& known : units) {
            if (unit != known.name) continue;
            const double length = std::round(number * static_cast<double>(known.length));
            if (length >= 0 && length < 9.2e18) return Time(static_cast<std::int64_t>(length));
        }
    throw std::invalid_argument("'" + text + "' is not a time such as 600, 250ms, 10min or 4h");
}

std::string describe_duration(Time duration) {
    const std::int64_t length = duration.count();
    for (std::size_t i = 0; i < std::size(units); ++i) {
        if (length < units[i].length) continue;
        if (length < 60'000'000'000)
            return with_unit(static_cast<double>(length) / static_cast<double>(units[i].length),
                             units[i].name);
        const std::int64_t rest = length % units[i].length / units[i + 1].length;
        const std::string whole = std::to_string(length / units[i].length) + " " + units[i].name;
        return rest ? whole + " " + std::to_string(rest) + " " + units[i + 1].name : whole;
    }
    return "0 s";
}

}  // namespace plumb::client
