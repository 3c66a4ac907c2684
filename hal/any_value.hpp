// SPDX-License-Identifier: GPL-2.0-or-later
// Values whose type is known only while a program runs: pins of other components, found by their names, and
// all other values that the virtual-time host reads and writes.
//
// Together with hal/value.hpp the only file that knows how HAL stores a value. A net moves the value of a
// pin, and HAL gives the memory of an unloaded component to the next one. So a value is good for the
// moment; find it again if a wrong value could do harm.
#pragma once

#include "hal/linuxcnc_series.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>

namespace plumb::hal {

// The content of a bit, a whole number, or a float.
using Value = std::variant<bool, std::int64_t, double>;

class AnyValue {
public:
    enum class Type { bit, real, s32, u32, s64, u64, port };

    AnyValue(hal_type_t type, hal_data_u* data) : type_(type_of(type)), data_(data) {}

    Type type() const { return type_; }
    bool same_place(const AnyValue& other) const { return data_ == other.data_ && type_ == other.type_; }

    // HAL's word for the type.
    const char* type_name() const {
        switch (type_) {
            case Type::bit: return "bit";
            case Type::real: return "float";
            case Type::s32: return "s32";
            case Type::u32: return "u32";
            case Type::s64: return "s64";
            case Type::u64: return "u64";
            case Type::port: break;
        }
        return "port";
    }

    // As a double, which holds every value of every type but a port's (a handle), and of 64 bits those up to 2^53.
    double number() const {
        switch (type_) {
            case Type::bit: return as<hal_bit_t>() ? 1.0 : 0.0;
            case Type::real: return as<hal_float_t>();
            case Type::s32: return as<hal_s32_t>();
            case Type::u32: return as<hal_u32_t>();
#ifdef PLUMB_LINUXCNC_2_10
            case Type::s64: return static_cast<double>(as<hal_s64_t>());
            case Type::u64: return static_cast<double>(as<hal_u64_t>());
#endif
            default: break;
        }
        return as<hal_port_t>();
    }

    // Whether the type holds the number without a change.
    bool accepts(double number) const {
        switch (type_) {
            case Type::bit: return number == 0.0 || number == 1.0;
            case Type::real: return true;
            case Type::s32: return whole_within<std::int32_t>(number);
            case Type::u32: return whole_within<std::uint32_t>(number);
            case Type::s64: return std::trunc(number) == number && std::abs(number) <= largest_whole;
            case Type::u64: return std::trunc(number) == number && number >= 0 && number <= largest_whole;
            case Type::port: break;
        }
        return false;
    }

    // Stores a number; bits are true unless 0. Integers must be whole and fit: the caller checks it with
    // accepts().
    void set_number(double number) const {
        switch (type_) {
            case Type::bit: as<hal_bit_t>() = number != 0.0; break;
            case Type::real: as<hal_float_t>() = number; break;
            case Type::s32: as<hal_s32_t>() = static_cast<std::int32_t>(number); break;
            case Type::u32: as<hal_u32_t>() = static_cast<std::uint32_t>(number); break;
#ifdef PLUMB_LINUXCNC_2_10
            case Type::s64: as<hal_s64_t>() = static_cast<std::int64_t>(number); break;
            case Type::u64: as<hal_u64_t>() = static_cast<std::uint64_t>(number); break;
#endif
            default: break;
        }
    }

    // The same as a Value, of anything but a port.
    Value read() const {
        switch (type_) {
            case Type::bit: return number() != 0.0;
            case Type::real: return number();
            default: return static_cast<std::int64_t>(number());
        }
    }
    bool takes(const Value& value) const {
        return value.index() == read().index() && accepts(number_of(value));
    }
    void write(const Value& value) const { set_number(number_of(value)); }

private:
    static Type type_of(hal_type_t type) {
        switch (type) {
            case HAL_BIT: return Type::bit;
            case HAL_FLOAT: return Type::real;
            case HAL_S32: return Type::s32;
            case HAL_U32: return Type::u32;
#ifdef PLUMB_LINUXCNC_2_10
            case HAL_S64: return Type::s64;
            case HAL_U64: return Type::u64;
#endif
            default: return Type::port;
        }
    }

    static constexpr double largest_whole = 9007199254740992.0;  // 2^53: a double holds all whole numbers up to it

    // HAL's parameters stand where their own type may, not where the union may.
    template <class Stored>
    Stored& as() const {
        return *static_cast<Stored*>(data_);
    }

    template <class Whole>
    static bool whole_within(double number) {
        return std::trunc(number) == number && number >= std::numeric_limits<Whole>::min() &&
               number <= std::numeric_limits<Whole>::max();
    }

    static double number_of(const Value& value) {
        return std::visit([](auto content) { return static_cast<double>(content); }, value);
    }

    Type type_;
    void* data_;
};

class NamedPin : public AnyValue {
public:
    // Nothing if there is no such pin, or if it holds no Value. HAL is locked meanwhile, and a program that
    // is killed in that moment leaves it locked: do not call this more often than needed.
    static std::optional<NamedPin> find(const std::string& name) {
        hal_type_t type = HAL_TYPE_UNSPECIFIED;
        hal_data_u* data = nullptr;
        bool linked = false;
        if (hal_get_pin_value_by_name(name.c_str(), &type, &data, &linked) != 0) return std::nullopt;
        const NamedPin pin(AnyValue(type, data), linked);
        return pin.type() == Type::port ? std::nullopt : std::optional(pin);
    }

    bool linked() const { return linked_; }

private:
    NamedPin(const AnyValue& value, bool linked) : AnyValue(value), linked_(linked) {}

    bool linked_;
};

}  // namespace plumb::hal
