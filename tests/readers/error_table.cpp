// SPDX-License-Identifier: GPL-2.0-or-later
// Tables of `squareness`.
#include "tests/readers/reader.hpp"

#include "components/io/files/error_table_file.hpp"

#include <cmath>

namespace plumb::readers {
namespace {

// Whether the last line of a file has to count its rows.
constexpr bool truncation_is_refused = true;

using Tables = std::map<char, DirectedErrorTable>;

Tables tables_of(std::string_view text) {
    error_table_file::Reader reader;
    reader.read("table.csv", text);
    return std::move(reader).tables();
}

void demand_numbers(const DirectedErrorTable& table) {
    constexpr int parts = 64;
    demand(std::isfinite(table.first()) && table.first() < table.last(), "the positions of a table rise");
    for (int i = -1; i <= parts + 1; ++i) {
        const auto reading = table.at(table.first() + (table.last() - table.first()) * i / parts);
        for (const auto& values : {reading.errors, reading.slopes})
            for (const double value : values)
                demand(std::isfinite(value), "a table that is taken has numbers");
    }
}

// A file that was written or copied by half ends before the end of its last row, or behind that.
void demand_whole(std::string_view text) {
    constexpr std::size_t tries = 32;
    std::size_t end = 0;
    for (std::size_t at = 0; at < text.size(); at = std::min(text.find('\n', at), text.size() - 1) + 1) {
        const std::string_view line = csv::trimmed(text.substr(at, text.find('\n', at) - at));
        if (!line.empty() && line[0] != '#') end = std::min(text.find('\n', at), text.size() - 1) + 1;
    }
    const std::size_t step = end / tries + 1;
    for (std::size_t size = end;; size -= step) {
        demand(!takes<std::runtime_error>([&] { tables_of(text.substr(0, size)); }),
               "a file that breaks off is refused");
        if (size < step) return;
    }
}

void demand_unchanged(const std::string& sealed) {
    demand(takes<std::runtime_error>([&] { tables_of(sealed); }), "a sealed file is taken");
    constexpr std::size_t tries = 64;
    const std::size_t step = 8 * sealed.size() / tries + 1;
    for (std::size_t bit = sealed.size() % step; bit < 8 * sealed.size(); bit += step) {
        std::string flipped = sealed;
        flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
        demand(!takes<std::runtime_error>([&] { tables_of(flipped); }),
               "a sealed file with a flipped bit is refused");
    }
}

void read(std::string_view bytes) {
    Tables tables;
    if (!takes<std::runtime_error>([&] { tables = tables_of(bytes); })) return;
    demand(!tables.empty(), "a file that is taken has a table");
    if (truncation_is_refused) demand_whole(bytes);
    for (const auto& [axis, table] : tables) demand_numbers(table);
    const Tables again = tables_of(bytes);
    demand(again.size() == tables.size(), "the same text gives the same tables");
    const std::string sealed = error_table_file::Reader::sealed("table.csv", bytes);
    demand(error_table_file::Reader::sealed("table.csv", sealed) == sealed,
           "a sealed file is sealed as it is");
    demand_whole(sealed);
    demand_unchanged(sealed);
    for (const auto& [axis, table] : tables) {
        const double middle = (table.first() + table.last()) / 2;
        demand(table.at(middle).errors == again.at(axis).at(middle).errors,
               "the same text gives the same values");
    }
}

const Reader reader{"error_table", read};

}  // namespace
}  // namespace plumb::readers
