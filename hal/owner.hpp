// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/registrar.hpp"

#include <cctype>
#include <string>

namespace plumb::hal {

class Group;

// The place of a declaration: a component, a group of pins in it, or the part of either that belongs to one
// axis. Converts from `this` of a component or a group; valid while the component is built.
class Owner {
public:
    Owner(Component* component) : registrar_(&hal::registrar(component)) {}
    Owner(const Group* group);
    // An owner of pins of the axis x, y, z, ...
    Owner(Owner owner, char axis) : registrar_(owner.registrar_), axis_(axis) {}

    Registrar& registrar() const { return *registrar_; }

    // In names of pins % is the letter of the axis, in sentences its capital.
    std::string name(const std::string& text) const { return with_axis(text, axis_); }
    std::string sentence(const std::string& text) const {
        return with_axis(text, static_cast<char>(std::toupper(static_cast<unsigned char>(axis_))));
    }

private:
    static std::string with_axis(std::string text, char letter) {
        for (char& c : text)
            if (c == '%' && letter) c = letter;
        return text;
    }

    Registrar* registrar_;
    char axis_ = 0;
};

}  // namespace plumb::hal
