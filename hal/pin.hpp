// SPDX-License-Identifier: GPL-2.0-or-later
// A pin is a value with a public name, a unit and one sentence of documentation.
#pragma once

#include "hal/length_unit.hpp"
#include "hal/owner.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <type_traits>

namespace plumb::hal {

template <class T>
class Pin {
public:
    Pin(const Pin&) = delete;
    Pin& operator=(const Pin&) = delete;

    const std::string& name() const { return *name_; }  // without the instance's name

protected:
    Pin(Owner owner, bool output, const std::string& name, T initial, const std::string& unit,
        const std::string& doc, const Setting& setting = {})
        : slot_(owner.registrar().add(PinInfo{type_of<T>, output, owner.name(name), unit,
                                              static_cast<double>(initial), owner.sentence(doc), setting,
                                              name, doc})),
          name_(std::make_unique<const std::string>(owner.name(name))) {
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

    const std::unique_ptr<const std::string> name_;  // apart: update() reads many slots, and no name
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

// N pins of one kind:  Row<In<double>, 4> load{this, "load", 0, "W", "..."}  declares load-0 to load-3; with
// a number before the name there are so many of them, as a hal::Count says.
template <class P, std::size_t N = 0>
class Row {
public:
    template <class... Rest>
    Row(Owner owner, const std::string& stem, const Rest&... rest) : Row(owner, N, stem, rest...) {
        static_assert(N > 0, "give the number of the pins");
    }
    template <class... Rest>
    Row(Owner owner, std::size_t number, const std::string& stem, const Rest&... rest)
        : places_(std::make_unique<Place[]>(number)) {
        for (; number_ < number; ++number_)
            new (&places_[number_]) P(owner, stem + "-" + std::to_string(number_), rest...);
    }
    Row(const Row&) = delete;
    Row& operator=(const Row&) = delete;
    ~Row() {
        while (number_ > 0) (*this)[--number_].~P();
    }

    std::size_t size() const noexcept { return number_; }
    P& operator[](std::size_t i) noexcept { return begin()[i]; }
    const P& operator[](std::size_t i) const noexcept { return begin()[i]; }
    P* begin() noexcept { return std::launder(reinterpret_cast<P*>(places_.get())); }
    P* end() noexcept { return begin() + number_; }
    const P* begin() const noexcept { return std::launder(reinterpret_cast<const P*>(places_.get())); }
    const P* end() const noexcept { return begin() + number_; }

private:
    // Side by side, for update(). A pin cannot move, so no std::vector holds it.
    struct alignas(P) Place {
        unsigned char bytes[sizeof(P)];
    };
    std::unique_ptr<Place[]> places_;
    std::size_t number_ = 0;
};

}  // namespace plumb::hal
