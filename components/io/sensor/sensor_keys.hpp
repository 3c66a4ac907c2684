// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/toml_reader.hpp"
#include "components/io/sensor/reading.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <set>
#include <string>

namespace plumb::sensor_keys {

constexpr std::size_t longest_name = 20;    // so that every pin fits into HAL's 47 characters
constexpr std::size_t most_channels = 256;  // more pins do not fit into HAL's memory
constexpr double unbounded = 1e308;

// The name of a link or channel; all names of a file differ, as names of pins do.
inline std::string name(TomlReader& table, std::set<std::string>& names) {
    const std::string result = table.pin_name("name", longest_name);
    if (!names.insert(result).second) table.refuse("name", "'" + result + "' is there twice");
    if (names.size() > most_channels)
        table.refuse("name", "'" + result + "' is one too many: a file has at most " +
                                 std::to_string(most_channels) + " links and channels");
    return result;
}

// How the number of the device becomes the value of the pin: number * scale + offset.
struct Scale {
    double scale = 1;
    double offset = 0;
    std::string unit;

    double value_of(double number) const noexcept { return number * scale + offset; }
};

inline Scale scale(TomlReader& table) {
    Scale result;
    result.scale = table.number_or("scale", 1, -unbounded, unbounded);
    if (result.scale == 0) table.refuse("scale", "is 0: the value would never change");
    result.offset = table.number_or("offset", 0, -unbounded, unbounded);
    result.unit = table.text("unit", 12);
    return result;
}

// max_age has to exceed the time between two values.
inline double max_age(TomlReader& table, double every) {
    const double initial = every < 0.4 ? 1 : 2.5 * every;
    const double result = table.number_or("max-age", initial, 0.001, 86400);
    if (result <= every)
        table.refuse("max-age", "is not longer than every: a value would be too old before the next");
    return result;
}

inline void bounds(TomlReader& table, ReadingLimits& limits) {
    limits.min = table.number_or("min", limits.min, -unbounded, unbounded);
    limits.max = table.number_or("max", limits.max, -unbounded, unbounded);
    if (limits.min >= limits.max)
        table.refuse(table.has("max") ? "max" : "min", "leaves no value between min and max");
    limits.max_rate = table.number_or("max-rate", limits.max_rate, 0, unbounded);
    if (limits.max_rate == 0) table.refuse("max-rate", "is 0: the value could never change");
}

// The times of a link.
template <class Link>
void times(TomlReader& table, Link& link) {
    link.timeout = table.number_or("timeout", link.timeout, 0.002, 10);
    link.retry = table.number_or("retry", link.retry, 0.002, 60);
    link.retry_max = table.number_or("retry-max", std::max(link.retry_max, link.retry), link.retry, 3600);
}

// Of a link whose replies have no number.
template <class Link>
void demand_long_retry(TomlReader& table, const Link& link) {
    if (link.retry < link.timeout)
        table.refuse("retry",
                     "is shorter than timeout: a late reply would pass for the reply to the next request");
}

// A file of links. Throws std::runtime_error with file, line, key and the text or number that is right.
template <class Settings, class Read>
Settings read(const std::filesystem::path& file, const Read& link) {
    const toml::table content = TomlReader::parse(file);
    TomlReader table(file, content);
    Settings settings;
    std::set<std::string> names;
    for (const TomlReader& its : table.tables("link")) settings.links.push_back(link(its, names));
    table.end();
    if (settings.links.empty()) table.refuse("link", "is missing: write [[link]]");
    return settings;
}

}  // namespace plumb::sensor_keys
