// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/stages/interlock/numbered_row.hpp"
#include "hal/component.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace plumb {

// The stages that bring offsets into the axes, as they report it.
struct Stages : hal::Group {
    static constexpr std::size_t number = 17;  // a joint each, and an axis

    using Row = NumberedRow<hal::In<bool>, number>;

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
