// SPDX-License-Identifier: GPL-2.0-or-later
// How HAL stores a value.
//
// The only file that knows, with hal/any_value.hpp. LinuxCNC 2.9 hands out pointers to cells in its shared
// memory and moves the pointer when a pin is netted; 2.10 hands out opaque handles with getters and setters.
// Port it here.
#pragma once

#include <hal.h>

#include <cstdint>
#include <new>
#include <string>

namespace plumb::hal {

// The types that a pin of ours may have.
enum class Type { bit, integer, word, real };

template <class T>
struct TypeOf;
template <>
struct TypeOf<bool> {
    static constexpr Type value = Type::bit;
};
template <>
struct TypeOf<std::int32_t> {
    static constexpr Type value = Type::integer;
};
template <>
struct TypeOf<std::uint32_t> {
    static constexpr Type value = Type::word;
};
template <>
struct TypeOf<double> {
    static constexpr Type value = Type::real;
};
template <class T>
inline constexpr Type type_of = TypeOf<T>::value;  // does not compile for any other type

// The name of a type in manuals.
inline const char* type_name(Type type) {
    switch (type) {
        case Type::bit: return "bit";
        case Type::integer: return "s32";
        case Type::word: return "u32";
        default: return "float";
    }
}

inline hal_type_t hal_type(Type type) {
    switch (type) {
        case Type::bit: return HAL_BIT;
        case Type::integer: return HAL_S32;
        case Type::word: return HAL_U32;
        default: return HAL_FLOAT;
    }
}

// Where a pin's value is found; stays valid as long as the pin.
class Slot {
public:
    explicit Slot(void** cell) : cell_(cell) {}

    template <class T>
    T read() const noexcept {
        return *static_cast<volatile T*>(*cell_);
    }
    template <class T>
    void write(T value) const noexcept {
        *static_cast<volatile T*>(*cell_) = value;
    }

private:
    void* const* cell_;
};

// Creates a pin in HAL. Returns its slot, or throws std::bad_alloc when HAL's memory is used up; any other
// refusal of HAL is left in `result` as a negative errno.
inline Slot new_pin(int component, const std::string& name, Type type, bool output, int& result) {
    auto** cell = static_cast<void**>(hal_malloc(sizeof(void*)));  // HAL re-points it when the pin is netted
    if (!cell) throw std::bad_alloc();
    result = hal_pin_new(name.c_str(), hal_type(type), output ? HAL_OUT : HAL_IN, cell, component);
    return Slot(cell);
}

}  // namespace plumb::hal
