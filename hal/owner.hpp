// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/registrar.hpp"

#include <cctype>
#include <cstddef>
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
    char axis() const { return axis_; }  // 0 without one

    // In names of pins % is the letter of the axis; in sentences it is the capital, but in %-position, a
    // name.
    std::string name(std::string text) const {
        for (char& c : text)
            if (c == '%' && axis_) c = axis_;
        return text;
    }
    std::string sentence(std::string text) const {
        for (std::size_t i = 0; i < text.size(); ++i)
            if (text[i] == '%' && axis_)
                text[i] = i + 1 < text.size() && text[i + 1] == '-'
                              ? axis_
                              : static_cast<char>(std::toupper(static_cast<unsigned char>(axis_)));
        return text;
    }

private:
    Registrar* registrar_;
    char axis_ = 0;
};

}  // namespace plumb::hal
