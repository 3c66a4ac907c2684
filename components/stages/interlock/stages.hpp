// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/component.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace plumb {

// The stages that bring offsets into the axes, as they report it.
struct Stages : hal::Group {
    static constexpr std::size_t number = 17;  // a joint each, and an axis

    // Numbered from 0 to 16: names of the first ten are those of when there were no more.
    class Row {
    public:
        Row(Stages* owner, const std::string& stem, bool initial, const std::string& doc)
            : Row(std::make_index_sequence<number>{}, owner, stem, initial, doc) {}

        hal::In<bool>* begin() noexcept { return pins_; }
        hal::In<bool>* end() noexcept { return pins_ + number; }

    private:
        template <std::size_t... I>
        Row(std::index_sequence<I...> /*numbers*/, Stages* owner, const std::string& stem, bool initial,
            const std::string& doc)
            : pins_{hal::In<bool>(owner, stem + "-" + std::to_string(I), initial, doc)...} {}

        hal::In<bool> pins_[number];
    };

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
