// SPDX-License-Identifier: GPL-2.0-or-later
// The pins of other components, found by their names: for programs that work for whatever is loaded.
//
// Together with hal/value.hpp the only file that knows how HAL stores a value.  A net moves the value of a
// pin, and HAL gives the memory of an unloaded component to the next one: a pin that was found is good for
// the moment, and is found anew where a wrong value would do harm.
#pragma once

#include <hal.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>

namespace plumb::hal {

// What any pin holds: a bit, an s32 or u32, or a float.
using Value = std::variant<bool, std::int64_t, double>;

class NamedPin {
public:
    // Nothing where there is no such pin, or where it holds no Value.  HAL is locked meanwhile; who is killed
    // in that moment leaves it locked: not to be called again and again without need.
    static std::optional<NamedPin> find(const std::string& name) {
        NamedPin pin;
        bool linked = false;
        if (hal_get_pin_value_by_name(name.c_str(), &pin.type_, &pin.data_, &linked) != 0)
            return std::nullopt;
        pin.linked_ = linked;
        if (!pin.type_name()) return std::nullopt;
        return pin;
    }

    bool linked() const { return linked_; }
    bool same_place(const NamedPin& other) const { return data_ == other.data_ && type_ == other.type_; }

    Value read() const {
        switch (type_) {
            case HAL_BIT: return static_cast<bool>(data_->b);
            case HAL_S32: return static_cast<std::int64_t>(data_->s);
            case HAL_U32: return static_cast<std::int64_t>(data_->u);
            default: return static_cast<double>(data_->f);
        }
    }

    // Whether the pin can hold exactly this.
    bool takes(const Value& value) const {
        const auto* const whole = std::get_if<std::int64_t>(&value);
        switch (type_) {
            case HAL_BIT: return std::holds_alternative<bool>(value);
            case HAL_S32: return whole && within<std::int32_t>(*whole);
            case HAL_U32: return whole && within<std::uint32_t>(*whole);
            default: return std::holds_alternative<double>(value);
        }
    }

    // Of what it takes.
    void write(const Value& value) const {
        switch (type_) {
            case HAL_BIT: data_->b = std::get<bool>(value); break;
            case HAL_S32: data_->s = static_cast<std::int32_t>(std::get<std::int64_t>(value)); break;
            case HAL_U32: data_->u = static_cast<std::uint32_t>(std::get<std::int64_t>(value)); break;
            default: data_->f = std::get<double>(value); break;
        }
    }

    // As halcmd calls it; null for what is no Value.
    const char* type_name() const {
        switch (type_) {
            case HAL_BIT: return "bit";
            case HAL_S32: return "s32";
            case HAL_U32: return "u32";
            case HAL_FLOAT: return "float";
            default: return nullptr;
        }
    }

private:
    template <class Whole>
    static bool within(std::int64_t value) {
        return value >= std::numeric_limits<Whole>::min() && value <= std::numeric_limits<Whole>::max();
    }

    hal_type_t type_ = HAL_TYPE_UNSPECIFIED;
    hal_data_u* data_ = nullptr;
    bool linked_ = false;
};

}  // namespace plumb::hal
