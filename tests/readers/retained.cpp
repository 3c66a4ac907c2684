// SPDX-License-Identifier: GPL-2.0-or-later
// The store of `plumb-retain`: as it comes, and with the checksum that its bytes would have.
#include "tests/readers/reader.hpp"

#include "components/io/retain/retained_file.hpp"

#include <cmath>

namespace plumb::readers {
namespace {

const std::string machine = "mill 3";

std::optional<Retained> parsed(const std::string& text) {
    std::optional<Retained> result;
    takes<retained_file::Refused>([&] { result = retained_file::parse(text, machine, "store"); });
    return result;
}

void demand_round_trip(const Retained& retained) {
    const auto composed = [](const Retained& its) {
        return retained_file::compose(its, machine, its.origin ? &*its.origin : nullptr);
    };
    const std::string text = composed(retained);
    const auto again = parsed(text);
    demand(again.has_value(), "a written store is read");
    demand(composed(*again) == text, "a written store is read back identically");
    // Each change of a byte, and each beginning, is found out.
    const std::size_t at = std::hash<std::string>()(text) % text.size();
    std::string changed = text;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    demand(!parsed(changed), "a store with a wrong byte is refused");
    demand(!parsed(text.substr(0, at)), "a store that breaks off is refused");
}

// A store of the bytes' own: nine of them a value.
Retained store_of(std::string_view bytes) {
    Retained retained;
    for (int i = 0; bytes.size() > sizeof(double) && i < 64; ++i, bytes.remove_prefix(sizeof(double) + 1)) {
        double real = 0;
        std::int64_t whole = 0;
        bytes.copy(reinterpret_cast<char*>(&real), sizeof real, 1);
        bytes.copy(reinterpret_cast<char*>(&whole), sizeof whole, 1);
        const hal::Value value = bytes[0] % 3 == 0   ? hal::Value(whole % 2 == 0)
                                 : bytes[0] % 3 == 1 ? hal::Value(whole)
                                                     : hal::Value(real);
        const std::string name = "pin-" + std::to_string(i);
        if (bytes[0] & 4)
            retained.records["component." + std::to_string(i % 3)].push_back({{name, value}});
        else
            retained.pins[name] = value;
    }
    return retained;
}

void read(std::string_view bytes) {
    const std::string text(bytes);
    if (const auto retained = parsed(text)) demand_round_trip(*retained);
    if (const auto retained = parsed(retained_file::first_line(text) + text)) {
        for (const auto& [component, records] : retained->records)
            if (component.find_first_of("\"\\\n") != std::string::npos)
                return;  // plumb-retain names no such component
        demand_round_trip(*retained);
    }
    demand_round_trip(store_of(bytes));
}

const Reader reader{"retained", read};

}  // namespace
}  // namespace plumb::readers
