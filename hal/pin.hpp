// SPDX-License-Identifier: GPL-2.0-or-later
// A pin is a value with a public name, a unit and one sentence of documentation.
#pragma once

#include "hal/length_unit.hpp"
#include "hal/owner.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

namespace plumb::hal {

template <class T>
class Pin {
public:
    Pin(const Pin&) = delete;
    Pin& operator=(const Pin&) = delete;

    const std::string& name() const { return name_; }  // without the instance's name

protected:
    Pin(Owner owner, bool output, const std::string& name, T initial, const std::string& unit,
        const std::string& doc, const Setting& setting = {})
        : slot_(owner.registrar().add(PinInfo{type_of<T>, output, owner.name(name), unit,
                                              static_cast<double>(initial), owner.sentence(doc), setting,
                                              name, doc})),
          name_(owner.name(name)) {
        slot_.template write<T>(converted(owner, initial, unit));
    }

    const Slot slot_;

private:
    // A default in the unit of the machine.
    static T converted(Owner owner, T initial, const std::string& unit) {
        if constexpr (std::is_same_v<T, double>)
            if (is_length(unit)) return initial / owner.registrar().millimetres();
        return initial;
    }

    const std::string name_;
};

// An input: `setp` gives it a constant, `net` a signal; unconnected it keeps its initial value.
// Another program may write it at any time: update() reads each input once.
template <class T>
struct In final : Pin<T> {
    // A setting has a level, and the range that its component accepts.
    In(Owner owner, const std::string& name, T initial, const std::string& unit, const std::string& doc,
       const Setting& setting = {})
        : Pin<T>(owner, false, name, initial, unit, doc, setting), range_(setting.range) {}
    In(Owner owner, const std::string& name, T initial, const std::string& doc, const Setting& setting = {})
        : In(owner, name, initial, "", doc, setting) {}

    operator T() const noexcept { return this->slot_.template read<T>(); }

    bool accepts(T value) const noexcept { return range_.contains(static_cast<double>(value)); }

private:
    const Range range_;
};

// Reads settings, each once; good() is false if one of them was out of its range.
class SettingsReader {
public:
    template <class T>
    T operator()(const In<T>& setting) noexcept {
        const T value = setting;
        good_ = good_ && setting.accepts(value);
        return value;
    }
    bool good() const noexcept { return good_; }

private:
    bool good_ = true;
};

// An output: write-only for its component, so that a public pin is never used as private state.
template <class T>
struct Out final : Pin<T> {
    Out(Owner owner, const std::string& name, const std::string& unit, const std::string& doc)
        : Pin<T>(owner, true, name, T{}, unit, doc) {}
    Out(Owner owner, const std::string& name, const std::string& doc) : Out(owner, name, "", doc) {}

    Out& operator=(T value) noexcept {
        this->slot_.template write<T>(value);
        return *this;
    }
};

// N pins of one kind:  Row<In<double>, 12> load{this, "load", 0, "W", "..."}  declares load-00 to load-11.
template <class P, std::size_t N>
class Row {
    static_assert(N >= 1 && N <= 100, "pin numbers have one or two digits");

public:
    template <class... Rest>
    Row(Owner owner, const std::string& stem, const Rest&... rest)
        : Row(std::make_index_sequence<N>{}, owner, stem, rest...) {}

    P& operator[](std::size_t i) noexcept { return pins_[i]; }
    P* begin() noexcept { return pins_; }
    P* end() noexcept { return pins_ + N; }
    const P* begin() const noexcept { return pins_; }
    const P* end() const noexcept { return pins_ + N; }

private:
    template <std::size_t... I, class... Rest>
    Row(std::index_sequence<I...>, Owner owner, const std::string& stem, const Rest&... rest)
        : pins_{P(owner, stem + "-" + numeral(I), rest...)...} {}

    static std::string numeral(std::size_t i) {
        const std::string digits = std::to_string(i);
        return N > 10 && i < 10 ? "0" + digits : digits;
    }

    P pins_[N];
};

}  // namespace plumb::hal
