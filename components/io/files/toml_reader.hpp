// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/regular_file.hpp"
#include "hal/spelling.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// A table of a TOML file, from which one key after the other is read. A key that nothing asks for is unknown.
// All refusals are std::runtime_error with the file, the line, the key and the text or number that is right.
class TomlReader {
public:
    // Throws std::runtime_error, or std::system_error if the file cannot be read.
    static toml::table parse(const std::filesystem::path& file) {
        try {
            return toml::parse(hal::RegularFile(file, O_RDONLY).read(), file.string());
        } catch (const toml::parse_error& error) {
            refuse(file, error.source(), std::string(error.description()));
        }
    }

    // Both must outlive the reader.
    TomlReader(const std::filesystem::path& file, const toml::table& table) : file_(&file), table_(&table) {}

    bool has(const std::string& key) {
        known_.insert(key);
        return table_->contains(key);
    }

    // Printable ASCII without quotes and backslashes, from 1 to `longest` characters.
    std::string text(const std::string& key, std::size_t longest = 200) {
        const toml::node& node = need(key, "a text in quotes");
        const auto* const value = node.as_string();
        if (!value) refuse(key, "is no text in quotes");
        const std::string& text = value->get();
        const auto plain = [](unsigned char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
        if (text.empty() || text.size() > longest || !std::all_of(text.begin(), text.end(), plain))
            refuse(key, "has to be 1 to " + std::to_string(longest) +
                            " characters of ASCII without quotes and backslashes");
        return text;
    }
    std::string text_or(const std::string& key, const std::string& initial, std::size_t longest = 200) {
        return has(key) ? text(key, longest) : initial;
    }

    // A part of the name of a pin: lower-case letters, digits and '-'.
    std::string pin_name(const std::string& key, std::size_t longest) {
        const std::string name = text(key, longest);
        const auto fit = [](unsigned char c) {
            return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
        };
        if (!std::all_of(name.begin(), name.end(), fit))
            refuse(key, "is '" + name + "', but names of pins are of a-z, 0-9 and '-'");
        return name;
    }

    double number(const std::string& key, double least, double largest) {
        const toml::node& node = need(key, "a number " + range(least, largest));
        const auto value = node.is_number() ? node.value<double>() : std::nullopt;
        if (!value || !(*value >= least && *value <= largest))
            refuse(key, "is no number " + range(least, largest));
        return *value;
    }
    double number_or(const std::string& key, double initial, double least, double largest) {
        return has(key) ? number(key, least, largest) : initial;
    }

    std::int64_t whole(const std::string& key, std::int64_t least, std::int64_t largest) {
        const std::string wanted =
            "whole number from " + std::to_string(least) + " to " + std::to_string(largest);
        const toml::node& node = need(key, "a " + wanted);
        const auto value = node.is_integer() ? node.value<std::int64_t>() : std::nullopt;
        if (!value || *value < least || *value > largest) refuse(key, "is no " + wanted);
        return *value;
    }
    std::int64_t whole_or(const std::string& key, std::int64_t initial, std::int64_t least,
                          std::int64_t largest) {
        return has(key) ? whole(key, least, largest) : initial;
    }

    bool flag_or(const std::string& key, bool initial) {
        if (!has(key)) return initial;
        const auto* const value = table_->get(key)->as_boolean();
        if (!value) refuse(key, "is neither true nor false");
        return value->get();
    }

    // One of several words, each with its meaning.
    template <class T>
    T choice(const std::string& key, const std::vector<std::pair<std::string, T>>& words) {
        std::string all;
        std::vector<std::string> names;
        for (const auto& [word, meaning] : words) {
            all += (all.empty() ? "" : ", ") + word;
            names.push_back(word);
        }
        need(key, "one of " + all);
        const std::string given = text(key);
        for (const auto& [word, meaning] : words)
            if (word == given) return meaning;
        refuse(key, "is '" + given + "', not one of " + all + hal::suggestion(given, names));
    }
    template <class T>
    T choice_or(const std::string& key, T initial, const std::vector<std::pair<std::string, T>>& words) {
        return has(key) ? choice(key, words) : initial;
    }

    // The tables that are written [[key]]; none if there is none.
    std::vector<TomlReader> tables(const std::string& key) {
        std::vector<TomlReader> result;
        if (!has(key)) return result;
        const toml::array* const array = table_->get(key)->as_array();
        if (!array) refuse(key, "is no list of tables: write [[" + key + "]]");
        for (const toml::node& element : *array) {
            if (!element.is_table()) refuse(element.source(), key + " has an element that is no table");
            result.emplace_back(*file_, *element.as_table());
        }
        return result;
    }

    // A table that is written { ... }.
    TomlReader table(const std::string& key) {
        const toml::node& node = need(key, "a table in braces");
        if (!node.is_table()) refuse(key, "is no table: write " + key + " = { ... }");
        return {*file_, *node.as_table()};
    }

    std::vector<std::int64_t> wholes(const std::string& key, std::int64_t least, std::int64_t largest) {
        std::vector<std::int64_t> result;
        if (!has(key)) return result;
        const toml::array* const array = table_->get(key)->as_array();
        const std::string wanted =
            "whole numbers from " + std::to_string(least) + " to " + std::to_string(largest);
        if (!array) refuse(key, "is no list of " + wanted);
        for (const toml::node& element : *array) {
            const auto value = element.is_integer() ? element.value<std::int64_t>() : std::nullopt;
            if (!value || *value < least || *value > largest) refuse(key, "is no list of " + wanted);
            result.push_back(*value);
        }
        return result;
    }

    // After the last key: refuses all that nothing has asked for.
    void end() const {
        for (const auto& [key, node] : *table_) {
            const std::string name(key.str());
            if (known_.count(name)) continue;
            refuse(key.source(), "unknown key '" + shown(name) + "'" +
                                     hal::suggestion(name, {known_.begin(), known_.end()}));
        }
    }

    [[noreturn]] void refuse(const std::string& key, const std::string& why) const {
        const toml::node* const node = table_->get(key);
        refuse(node ? node->source() : table_->source(), key + " " + why);
    }

private:
    [[noreturn]] void refuse(const toml::source_region& place, const std::string& why) const {
        refuse(*file_, place, why);
    }
    [[noreturn]] static void refuse(const std::filesystem::path& file, const toml::source_region& place,
                                    const std::string& why) {
        throw std::runtime_error(file.string() + ":" + std::to_string(place.begin.line) + ": " + why);
    }

    const toml::node& need(const std::string& key, const std::string& what) {
        if (!has(key)) refuse_other_case(key);
        if (!has(key)) refuse(key, "is missing: it is " + what);
        return *table_->get(key);
    }

    // Refuses a key that differs from this one by capital letters alone.
    void refuse_other_case(const std::string& key) const {
        for (const auto& [given, value] : *table_) {
            std::string small(given.str());
            for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            if (small == key)
                refuse(given.source(), "unknown key '" + shown(std::string(given.str())) + "': write " + key);
        }
    }

    static std::string range(double least, double largest) {
        const auto bounded = [](double bound) { return std::abs(bound) < 1e300; };
        std::ostringstream text;
        if (bounded(least)) text << "from " << least << ' ';
        if (bounded(largest)) text << "up to " << largest;
        if (!bounded(least) && !bounded(largest)) text << "that is finite";
        std::string result = text.str();
        if (!result.empty() && result.back() == ' ') result += "on";
        return result;
    }

    static std::string shown(const std::string& name) {
        std::string result;
        for (const unsigned char c : name.substr(0, 60))
            result += c >= ' ' && c <= '~' ? static_cast<char>(c) : '?';
        return result;
    }

    const std::filesystem::path* file_;
    const toml::table* table_;
    std::set<std::string> known_;
};

}  // namespace plumb
