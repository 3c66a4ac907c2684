// SPDX-License-Identifier: GPL-2.0-or-later
// A control request as it comes from a client: a line with a JSON object that has the key "do".
#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "hal/host/time.hpp"

namespace plumb::host {

class Request {
public:
    using Json = nlohmann::json;

    // Throws std::runtime_error when the line is no request, or nested too deeply.
    explicit Request(const std::string& line);

    const std::string& what() const { return what_; }  // the value of "do"

    // The value under `key`. Throws std::runtime_error when it is missing or has another type.
    template <typename Value>
    Value required(const char* key) const {
        const auto found = object_.find(key);
        if (found == object_.end()) refuse("needs", key);
        try {
            return found->get<Value>();
        } catch (const Json::exception&) {
            refuse("cannot take " + shown(*found) + " as", key);
        }
    }

    // The same, or `otherwise` when it is missing or null.
    template <typename Value>
    Value optional(const char* key, Value otherwise) const {
        const auto found = object_.find(key);
        return found == object_.end() || found->is_null() ? otherwise : required<Value>(key);
    }

    // A span of time. Throws std::runtime_error unless it is whole, at least `least`, and at most 146 years.
    Nanoseconds span(const char* key, Nanoseconds least) const;

    // The beginning of a value, as JSON.
    static std::string shown(const Json& value);

private:
    [[noreturn]] void refuse(const std::string& why, const char* key) const;

    Json object_;
    std::string what_;
};

}  // namespace plumb::host
