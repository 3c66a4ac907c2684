// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/crc_32.hpp"
#include "components/io/retain/retain_fault.hpp"
#include "hal/any_value.hpp"

#include <toml++/toml.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace retained_file {

// Of a store that is bound to its computer.
struct Origin {
    std::string computer;    // "" for one without a machine-id
    std::string store;       // a drawn number
    std::int64_t count = 0;  // of writes
};

}  // namespace retained_file

// All that must outlive a restart, at one moment.
struct Retained {
    using Record = std::map<std::string, hal::Value>;  // by the names of its fields

    Record pins;                                         // by their names
    std::map<std::string, std::vector<Record>> records;  // by the components that have them
    std::optional<retained_file::Origin> origin;         // of the store, if it is bound
};

// The text of the file that holds it: a first line with version and checksum, then TOML.
namespace retained_file {

struct Refused : std::runtime_error {
    Refused(Fault why, const std::string& text) : std::runtime_error(text), fault(why) {}
    const Fault fault;
};

constexpr int version = 1;

inline std::string hexadecimal(std::uint32_t number) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", number);
    return digits;
}

inline std::string value_text(const hal::Value& value) {
    if (const auto* const bit = std::get_if<bool>(&value)) return *bit ? "true" : "false";
    if (const auto* const whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
    const double number = std::get<double>(value);
    if (std::isnan(number)) return "nan";  // TOML's has no sign
    char digits[32];                       // the shortest that give the same number again
    const std::string real(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
    return real.find_first_of(".en") == std::string::npos ? real + ".0" : real;
}

inline std::string fields_text(const Retained::Record& record) {
    std::string fields;
    for (const auto& [name, value] : record)
        fields += (fields.empty() ? "" : ", ") + name + " = " + value_text(value);
    return fields;
}

// Every store begins with these words.
inline std::string first_line(const std::string& rest) {
    return "# retain " + std::to_string(version) + ", CRC-32 of the rest: " + hexadecimal(crc_32(rest)) +
           '\n';
}

inline std::string compose(const Retained& retained, const std::string& machine,
                           const Origin* origin = nullptr) {
    std::string rest = "machine = \"" + machine + "\"\n";
    if (origin != nullptr)
        rest += "origin = { computer = \"" + origin->computer + "\", store = \"" + origin->store +
                "\", count = " + std::to_string(origin->count) + " }\n";
    rest += "\n[pins]\n";
    for (const auto& [name, value] : retained.pins) rest += '"' + name + "\" = " + value_text(value) + '\n';
    rest += "\n[records]\n";
    for (const auto& [component, records] : retained.records) {
        rest += '"' + component + "\" = [\n";
        for (const Retained::Record& record : records) rest += "  { " + fields_text(record) + " },\n";
        rest += "]\n";
    }
    return first_line(rest) + rest;
}

template <class Kind>
const Kind& need(const toml::node* node) {
    const auto* const found = node ? node->as<Kind>() : nullptr;
    if (!found) throw std::runtime_error("its content is not a file of plumb-retain");
    return *found;
}

inline Retained::Record values(const toml::node* table) {
    Retained::Record result;
    for (const auto& [key, value] : need<toml::table>(table)) {
        hal::Value& kept = result[std::string(key.str())];
        if (value.is_boolean())
            kept = value.ref<bool>();
        else if (value.is_integer())
            kept = value.ref<std::int64_t>();
        else
            kept = need<toml::value<double>>(&value).get();
    }
    return result;
}

inline std::optional<Origin> origin(const toml::node* node) {
    if (!node) return std::nullopt;
    const auto& table = need<toml::table>(node);
    const auto text = [&](const char* key) { return need<toml::value<std::string>>(table.get(key)).get(); };
    Origin origin{text("computer"), text("store"), need<toml::value<std::int64_t>>(table.get("count")).get()};
    for (const auto& [number, digits] : {std::pair(origin.store, 16U), std::pair(origin.computer, 8U)})
        if (number.find_first_not_of("0123456789abcdef") != std::string::npos ||
            (number.size() != digits && !(number.empty() && digits == 8)))
            throw std::runtime_error("'" + number + "' is no number of a store or a computer");
    return origin;
}

inline Retained content(const toml::table& table) {
    Retained retained{values(table.get("pins")), {}, origin(table.get("origin"))};
    for (const auto& [component, records] : need<toml::table>(table.get("records")))
        for (const toml::node& record : need<toml::array>(&records))
            retained.records[std::string(component.str())].push_back(values(&record));
    return retained;
}

// Throws Refused for any text that compose() did not make for this machine; its sentence begins with
// `name`.
inline Retained parse(const std::string& text, const std::string& machine, const std::string& name) {
    const auto refuse = [&](Fault why, const std::string& what) { throw Refused(why, name + what); };
    const std::size_t end = text.find('\n');
    if (end == std::string::npos) refuse(Fault::damaged, " is truncated: it has not one whole line");
    const std::string head = text.substr(0, end);
    const std::string rest = text.substr(end + 1);
    int its_version = 0;
    if (std::sscanf(head.c_str(), "# retain %d,", &its_version) != 1)
        refuse(Fault::foreign, " is no file of plumb-retain: it begins with '" + head.substr(0, 40) + "'");
    if (its_version != version)
        refuse(Fault::version, " is of version " + std::to_string(its_version) +
                                   "; this plumb-retain reads version " + std::to_string(version));
    if (text != first_line(rest) + rest)
        refuse(Fault::damaged,
               " is truncated or was changed: the CRC-32 of the lines after the first line, '" + head +
                   "', is " + hexadecimal(crc_32(rest)));
    try {
        const toml::table table = toml::parse(rest);
        const std::string& its_machine = need<toml::value<std::string>>(table.get("machine")).get();
        if (its_machine != machine)
            refuse(Fault::foreign, " is of the machine '" + its_machine + "', not of '" + machine + "'");
        return content(table);
    } catch (const Refused&) {
        throw;
    } catch (const std::exception& error) {
        throw Refused(Fault::damaged, name + ": " + error.what());
    }
}

}  // namespace retained_file
}  // namespace plumb
