// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/regular_file.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace plumb {

// The settings in the TOML file of `plumb-retain`.
struct RetainSettings {
    std::string machine;
    std::filesystem::path store;                  // where the values are kept
    double every = 5;                             // s, at least, between two writes
    std::vector<std::string> pins;                // to keep
    std::vector<std::string> records;             // components whose records to keep
    std::vector<std::string> program;             // files that together are the program
    std::map<std::string, std::string> formerly;  // former names of instances, by their names now
    bool bound = false;                           // to this computer, and to its last store

    // Whether a pin or the records of an instance are kept.
    bool keeps(const std::string& instance) const {
        const auto its = [&](const std::string& pin) { return pin.rfind(instance + '.', 0) == 0; };
        return std::any_of(pins.begin(), pins.end(), its) ||
               std::find(records.begin(), records.end(), instance) != records.end();
    }

    // Throws std::runtime_error with file, line and reason.
    static RetainSettings read(const std::filesystem::path& file);
};

// Writes a file without values, unless there is one. In the name halcmd leaves the quotes of
// "[EMC](MACHINE)".
inline void begin_settings(const std::filesystem::path& file, std::string machine) {
    if (std::filesystem::exists(std::filesystem::symlink_status(file))) return;
    if (machine.size() > 1 && machine.front() == '"' && machine.back() == '"')
        machine = machine.substr(1, machine.size() - 2);
    if (machine.find_first_of("\"\\\n") != std::string::npos)
        throw std::runtime_error("the name of the machine has a quote or a backslash: " + machine);
    std::ofstream out(file);
    out << "# SPDX-License-Identifier: GPL-2.0-or-later\nmachine = \"" << machine << "\"\npins = []\n";
    if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
}

namespace retain_settings {

[[noreturn]] inline void refuse(const std::filesystem::path& file, const toml::source_region& place,
                                const std::string& why) {
    throw std::runtime_error(file.string() + ":" + std::to_string(place.begin.line) + ": " + why);
}

inline bool hal_name(const std::string& text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::isalnum(c) || c == '-' || c == '_' || c == '.' || c == ':';
    });
}

// Takes one key after the other out of the table; keys that remain are unknown.
class Reader {
public:
    Reader(const std::filesystem::path& file, toml::table& table) : file_(file), table_(table) {}

    std::string text(const std::string& key) const {
        const toml::node* const node = table_.get(key);
        if (!node) return "";
        if (!node->is_string()) refuse(*node, key + " is no text in quotes");
        const std::string text = node->as_string()->get();
        const auto plain = [](unsigned char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
        if (text.empty() || !std::all_of(text.begin(), text.end(), plain))
            refuse(*node, key + " is empty, or has quotes, backslashes or characters beyond ASCII");
        return text;
    }

    double seconds(const std::string& key, double initial) const {
        const toml::node* const node = table_.get(key);
        if (!node) return initial;
        const auto value = node->is_number() ? node->value<double>() : std::nullopt;
        if (!value || !(*value >= 0.01 && *value <= 3600))
            refuse(*node, key + " is no time from 0.01 to 3600 s");
        return *value;
    }

    bool yes(const std::string& key) const {
        const toml::node* const node = table_.get(key);
        if (node != nullptr && !node->is_boolean()) refuse(*node, key + " is neither true nor false");
        return node != nullptr && node->as_boolean()->get();
    }

    std::vector<std::string> texts(const std::string& key, const std::string& what,
                                   bool (*good)(const std::string&)) const {
        std::vector<std::string> result;
        const toml::node* const node = table_.get(key);
        if (!node) return result;
        if (!node->is_array()) refuse(*node, key + " is no list");
        std::set<std::string> seen;
        for (const toml::node& element : *node->as_array()) {
            const auto text = element.value<std::string>();
            if (!text || !good(*text))
                refuse(element,
                       key + ": " + (text ? "'" + *text + "' is " : "an element is ") + "no " + what);
            if (!seen.insert(*text).second) refuse(element, key + ": '" + *text + "' is there twice");
            result.push_back(*text);
        }
        return result;
    }

    // A table of former names of instances, by their names now.
    std::map<std::string, std::string> former_names(const std::string& key,
                                                    const RetainSettings& settings) const {
        std::map<std::string, std::string> result;
        const toml::node* const node = table_.get(key);
        if (!node) return result;
        if (!node->is_table()) refuse(*node, key + " is no table: write { \"name\" = \"former name\" }");
        std::set<std::string> seen;
        for (const auto& [now, element] : *node->as_table()) {
            const std::string name(now.str());
            const auto former = element.value<std::string>();
            if (!former || !hal_name(*former))
                refuse(element, key + ": the former name of '" + name + "' is no name of an instance");
            if (!settings.keeps(name)) refuse(element, key + ": nothing of '" + name + "' is kept");
            if (settings.keeps(*former)) refuse(element, key + ": '" + *former + "' is still kept");
            if (!seen.insert(*former).second) refuse(element, key + ": '" + *former + "' is there twice");
            result[name] = *former;
        }
        return result;
    }

    const toml::node& need(const std::string& key) const {
        const toml::node* const node = table_.get(key);
        if (!node) refuse(table_, "there is no " + key);
        return *node;
    }

    void refuse_all_but(const std::set<std::string>& known) const {
        for (const auto& [key, node] : table_)
            if (!known.count(std::string(key.str())))
                retain_settings::refuse(file_, key.source(), "unknown key '" + std::string(key.str()) + "'");
    }

    [[noreturn]] void refuse(const toml::node& node, const std::string& why) const {
        retain_settings::refuse(file_, node.source(), why);
    }

private:
    const std::filesystem::path& file_;
    toml::table& table_;
};

inline bool absolute(const std::string& path) {
    return !path.empty() && path.front() == '/';
}

}  // namespace retain_settings

inline RetainSettings RetainSettings::read(const std::filesystem::path& file) {
    using namespace retain_settings;
    toml::table table;
    try {
        table = toml::parse(hal::RegularFile(file, O_RDONLY).read(), file.string());
    } catch (const toml::parse_error& error) {
        refuse(file, error.source(), std::string(error.description()));
    }
    const Reader reader(file, table);
    reader.refuse_all_but({"machine", "store", "every", "pins", "records", "program", "formerly", "bound"});
    RetainSettings settings;
    reader.need("machine");
    settings.machine = reader.text("machine");
    settings.store = reader.text("store");
    if (settings.store.empty())
        settings.store = std::filesystem::path(file).replace_extension(".retained");
    else if (!settings.store.is_absolute())
        reader.refuse(reader.need("store"), "store: '" + settings.store.string() + "' is no absolute path");
    settings.every = reader.seconds("every", settings.every);
    settings.pins = reader.texts("pins", "name of a pin", hal_name);
    settings.records = reader.texts("records", "name of a component's instance", hal_name);
    settings.program = reader.texts("program", "absolute path", absolute);
    settings.formerly = reader.former_names("formerly", settings);
    settings.bound = reader.yes("bound");
    return settings;
}

}  // namespace plumb
