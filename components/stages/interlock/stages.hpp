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

        hal::In<bool>& operator[](std::size_t i) noexcept { return pins_[i]; }
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
    Row ramping{this, "stage-ramping", false, "The offset of the stage is still changing."};
    Row uncompensated{this, "stage-uncompensated", false, "The axis of the stage lacks its offset."};
    Row probing_refused{this, "stage-probing-refused", false,
                        "A probing move began with an offset in force, which its result would contain."};
    Row fault{this, "stage-fault", false, "The stage has a fault."};
    Row limited{this, "stage-limited", false, "A limit prevents the full offset of the stage."};

    // Of a period, as sums of 1, 2, 4, ...
    struct Now {
        std::int32_t in_force, ramping, uncompensated, probing_refused, fault, limited;
    };

    Now read() noexcept {
        return {sum_of(in_force),        sum_of(ramping), sum_of(uncompensated),
                sum_of(probing_refused), sum_of(fault),   sum_of(limited)};
    }

private:
    static std::int32_t sum_of(Row& bits) noexcept {
        std::int32_t sum = 0;
        for (std::size_t i = 0; i < number; ++i) sum |= bits[i] ? 1 << i : 0;
        return sum;
    }
};

// Whether one of the bits is true; each is read.
template <class Row>
bool any(Row& bits) noexcept {
    return std::count(bits.begin(), bits.end(), true) > 0;
}

}  // namespace plumb
