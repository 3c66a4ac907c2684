// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <initializer_list>

namespace plumb::hal {

// A code, and whether it applies.
template <class E>
struct Applies {
    bool when;
    E code;
};

// The first code that applies; 0 for none.
template <class E>
E first(std::initializer_list<Applies<E>> codes) noexcept {
    for (const Applies<E>& each : codes)
        if (each.when) return each.code;
    return E{};
}

}  // namespace plumb::hal
