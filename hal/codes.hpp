// SPDX-License-Identifier: GPL-2.0-or-later
// A code is an enum whose values from 1 on have a sentence each; 0 is none. The sentences stand beside the
// enum, once:
//
//     enum class Fault : std::int32_t { none, source, position };
//     constexpr const char* sentence(Fault fault) {
//         switch (fault) {
//             case Fault::source: return "A source is invalid; its last good value is used.";
//             case Fault::position: return "The position is invalid.";
//             default: return nullptr;
//         }
//     }
//     hal::Codes<Fault> fault{this, "fault"};
//
// declares the pins fault and fault-code. The manual page, reports and messages take the sentences from
// there. If the pin is not called "fault", its bit has a sentence of its own:
//
//     hal::Codes<Bound> limited{this, "limited", "A bound is active; limited-code gives it."};
//
// A code that is not a cause has a sentence of its own, too, after the one of its bit.
#pragma once

#include "hal/first.hpp"
#include "hal/pin.hpp"

#include <cstdint>
#include <string>

namespace plumb::hal {

// One pin that holds a code.
template <class E>
class Code {
public:
    Code(Owner owner, const std::string& name, const std::string& doc) : pin_{owner, name, doc} {
        CodesInfo info{pin_.name(), {}};
        for (std::int32_t number = 1; number <= largest; ++number)
            if (const char* const text = sentence(static_cast<E>(number)))
                info.sentences[number] = owner.sentence(text);
        owner.registrar().add(info);
    }

    Code& operator=(E value) noexcept {
        pin_ = static_cast<std::int32_t>(value);
        return *this;
    }

private:
    static constexpr std::int32_t largest = 99;

    Out<std::int32_t> pin_;
};

// A bit that is true while there is a code, and the code.
template <class E>
class Codes {
public:
    Codes(Owner owner, const std::string& name)
        : Codes(owner, name, "A " + name + " is active; " + name + "-code gives the cause.") {}
    Codes(Owner owner, const std::string& name, const std::string& doc,
          const std::string& doc_of_code = "Number of the cause; 0 for none.")
        : active_{owner, name, doc}, code_{owner, name + "-code", doc_of_code} {}

    Codes& operator=(E value) noexcept {
        code_ = value;
        active_ = value != E{};
        return *this;
    }

    const Out<bool>& active() const noexcept { return active_; }

private:
    Out<bool> active_;
    Code<E> code_;
};

}  // namespace plumb::hal
