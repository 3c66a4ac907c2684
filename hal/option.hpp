// SPDX-License-Identifier: GPL-2.0-or-later
// An option is a value given at load time, one per instance, or one for all:
//
//     loadrt squareness names=a,b table=/etc/a.csv,/etc/b.csv
//
// HAL cuts a value at '#' and at quotes and knows no blanks in it, and the commas are the separator: an
// option that names a file must be an absolute path without them.
#pragma once

#include "hal/registrar.hpp"

#include <charconv>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace plumb::hal {

template <class T>
class Option {
    static_assert(std::is_same_v<T, std::string> || std::is_arithmetic_v<T>,
                  "an option is a text or a number");

public:
    // others: values with which the component has other pins.
    Option(Component* owner, const std::string& name, const T& initial, const std::string& doc,
           const std::vector<Other>& others = {}, bool counts = false)
        : value_(parse(name, registrar(owner).add(OptionInfo{name, text(initial), doc, others, counts}))) {}
    Option(const Option&) = delete;
    Option& operator=(const Option&) = delete;

    operator const T&() const noexcept { return value_; }
    const T& get() const noexcept { return value_; }

private:
    static std::string text(const T& value) {
        if constexpr (std::is_same_v<T, std::string>) {
            return value;
        } else {
            char digits[32];
            return std::string(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
        }
    }

    static T parse(const std::string& name, const std::string& given) {
        if constexpr (std::is_same_v<T, std::string>) {
            return given;
        } else {
            T value{};
            const char* end = given.data() + given.size();
            const auto [rest, error] = std::from_chars(given.data(), end, value);
            if (error != std::errc{} || rest != end)
                throw std::invalid_argument(name + "=" + given + ": not a number");
            return value;
        }
    }

    const T value_;
};

// How many rows of pins an instance has: `loadrt axis_growth sensors=3`. Loading with a number that is out of
// range fails.
class Count {
public:
    Count(Component* owner, const std::string& name, int initial, int least, int most, const std::string& doc)
        : option_(owner, name, initial, doc, values(least, most), true) {
        if (option_ < least || option_ > most)
            throw std::invalid_argument(name + "=" + std::to_string(option_) + ": give " +
                                        std::to_string(least) + " to " + std::to_string(most));
    }

    operator std::size_t() const noexcept { return static_cast<std::size_t>(option_.get()); }

private:
    static std::vector<Other> values(int least, int most) {
        std::vector<Other> result;
        for (int value = least; value <= most; ++value) result.emplace_back(std::to_string(value), "");
        return result;
    }

    const Option<int> option_;
};

// The path of an option that names a file; throws when it is not absolute. Empty stays empty.
inline const std::string& absolute_path(const std::string& name, const std::string& path) {
    if (!path.empty() && path.front() != '/')
        throw std::invalid_argument(name + "=" + path +
                                    ": give an absolute path (without blank, comma, # or quote)");
    return path;
}

}  // namespace plumb::hal
