// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/request.hpp"

namespace plumb::host {

namespace {

constexpr int deepest = 32;                                 // lists and objects within each other
constexpr std::size_t most_shown = 60;                      // characters of a value in a message
constexpr Nanoseconds longest_span = Nanoseconds{1} << 62;  // leaves room to add

// nlohmann's JSON calls itself for each level, as it copies a value or turns it into text.
bool too_deep(const std::string& line) {
    int depth = 0;
    bool in_text = false;
    for (std::size_t at = 0; at < line.size(); ++at) {
        const char c = line[at];
        if (in_text && c == '\\')
            ++at;
        else if (c == '"')
            in_text = !in_text;
        else if (!in_text && (c == '[' || c == '{'))
            ++depth;
        else if (!in_text && (c == ']' || c == '}'))
            --depth;
        if (depth > deepest) return true;
    }
    return false;
}

}  // namespace

Request::Request(const std::string& line) {
    if (too_deep(line))
        throw std::runtime_error("the request is nested more than " + std::to_string(deepest) + " deep");
    object_ = Json::parse(line, nullptr, false);
    if (!object_.is_object() || !object_.contains("do") || !object_["do"].is_string())
        throw std::runtime_error("a request is a JSON object with a \"do\"");
    what_ = object_["do"];
}

Nanoseconds Request::span(const char* key, Nanoseconds least) const {
    const auto found = object_.find(key);
    if (found == object_.end()) refuse("needs", key);
    const bool whole = found->is_number_integer();
    const bool fits = whole && (!found->is_number_unsigned() ||
                                found->get<std::uint64_t>() <= static_cast<std::uint64_t>(longest_span));
    if (fits && found->get<Nanoseconds>() >= least) return found->get<Nanoseconds>();
    throw std::runtime_error("'" + what_ + "': \"" + key + "\" is " + shown(*found) +
                             ", not a whole number of nanoseconds from " + std::to_string(least) + " to " +
                             std::to_string(longest_span));
}

std::string Request::shown(const Json& value) {
    const std::string text = value.dump(-1, ' ', true);
    return text.size() > most_shown ? text.substr(0, most_shown) + "..." : text;
}

void Request::refuse(const std::string& why, const char* key) const {
    throw std::runtime_error("'" + what_ + "' " + why + " \"" + key + "\"");
}

}  // namespace plumb::host
