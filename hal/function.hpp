// SPDX-License-Identifier: GPL-2.0-or-later
// A function is a method that HAL calls once per period of the thread to which `addf` adds it.
#pragma once

#include "hal/registrar.hpp"

#include <string>
#include <utility>

namespace plumb::hal {

class Function {
public:
    // The method gets the thread period in seconds. It may not allocate, lock, print, throw, read a clock
    // or make a system call. `its_place` is a sentence about its place in the order of addf.
    template <class C>
    Function(C* owner, std::string its_name, void (C::*method)(double) noexcept, std::string its_place)
        : name(std::move(its_name)),
          place(std::move(its_place)),
          owner_(owner),
          method_(static_cast<void (Component::*)(double) noexcept>(method)) {
        registrar(owner).add(*this);
    }
    Function(const Function&) = delete;
    Function& operator=(const Function&) = delete;

    void operator()(double dt) const noexcept { (owner_->*method_)(dt); }

    const std::string name;
    const std::string place;

private:
    Component* const owner_;
    void (Component::*const method_)(double) noexcept;
};

}  // namespace plumb::hal
