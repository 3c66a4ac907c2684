// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/component.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace plumb {

// The stages that bring offsets into the axes, as they report it.
struct Stages : hal::Group {
    static constexpr std::size_t number = 10;
    using Row = hal::Row<hal::In<bool>, number>;

    using Group::Group;

    Row in_force{this, "stage-in-force", false, "The stage has an offset in force."};
    Row ramping{this, "stage-ramping", false, "Its offset is on its way, and does change."};
    Row uncompensated{this, "stage-uncompensated", false, "Its axis lacks an offset that is wanted."};
    Row probing_refused{this, "stage-probing-refused", false,
                        "Probing has begun with an offset in force that its result would contain."};
    Row fault{this, "stage-fault", false, "The stage has a fault."};
};

// Whether one of the bits is true; each is read.
template <class Row>
bool any(Row& bits) noexcept {
    return std::count(bits.begin(), bits.end(), true) > 0;
}

// The number of the first bit that is true; -1 without one.
template <class Row>
std::int32_t first_of(Row& bits) noexcept {
    const auto found = std::find(bits.begin(), bits.end(), true);
    return found == bits.end() ? -1 : static_cast<std::int32_t>(found - bits.begin());
}

}  // namespace plumb
