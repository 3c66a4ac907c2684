// SPDX-License-Identifier: GPL-2.0-or-later
// A function is a method that HAL calls once per period of the thread to which `addf` adds it.
#pragma once

#include "hal/place.hpp"
#include "hal/registrar.hpp"

#include <string>
#include <utility>

namespace plumb::hal {

class Function {
public:
    // The method gets the thread period in seconds. It may not allocate, lock, print, throw, read a clock
    // or make a system call. `its_place` is its place in the order of addf, and `more` is a sentence about
    // that place which the order of Plumb's own functions does not give.
    template <class C>
    Function(C* owner, std::string its_name, void (C::*method)(double) noexcept, Place its_place,
             const std::string& more = "")
        : name(std::move(its_name)),
          place(its_place),
          sentence(joined(order_of(its_place), more)),
          owner_(owner),
          method_(static_cast<void (Component::*)(double) noexcept>(method)) {
        registrar(owner).add(*this);
    }
    // One that has no place among them: of a program, or of a test.
    template <class C>
    Function(C* owner, std::string its_name, void (C::*method)(double) noexcept, const std::string& its_order)
        : Function(owner, std::move(its_name), method, Place::none, its_order) {}
    Function(const Function&) = delete;
    Function& operator=(const Function&) = delete;

    void operator()(double dt) const noexcept { (owner_->*method_)(dt); }

    const std::string name;
    const Place place;
    const std::string sentence;  // where it belongs

private:
    static std::string joined(const std::string& first, const std::string& second) {
        return first.empty() || second.empty() ? first + second : first + ' ' + second;
    }

    Component* const owner_;
    void (Component::*const method_)(double) noexcept;
};

}  // namespace plumb::hal
