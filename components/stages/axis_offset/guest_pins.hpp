// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/guest_offset.hpp"
#include "hal/component.hpp"

#include <cmath>

namespace plumb {

// The pins of axis.L.eoffset-* as the guest knows them.
struct GuestPins final : hal::Group {
    using Group::Group;

    hal::In<std::int32_t> counts{this, "guest-counts", 0, "Counts of the guest, for axis.L.eoffset-counts."};
    hal::In<double> scale{this, "guest-scale", 0, "mu", "Offset of one count of the guest."};
    hal::In<bool> enable{this, "guest-enable", true, "Listen to the guest; else its offset holds."};
    hal::In<bool> clear{this, "guest-clear", false, "Take the guest's offset back at once."};

    hal::Out<double> request{this, "guest-request", "mu", "Offset that the guest asks for."};
    hal::Out<double> applied{this, "guest-applied", "mu",
                             "Offset of the guest that the axis has: its axis.L.eoffset."};
    hal::Out<bool> active{this, "guest-active", "It is not zero: the guest's motion.eoffset-active."};

    GuestOffset::Given read() const noexcept { return {counts, scale, enable, clear}; }

    // `grain` is the smallest offset that there can be.
    void show(double asked_for, double in_force, double grain) noexcept {
        request = asked_for;
        applied = in_force;
        active = std::abs(in_force) > grain;
    }
};

}  // namespace plumb
