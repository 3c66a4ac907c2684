// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/guest_offset.hpp"
#include "hal/component.hpp"

#include <cmath>

namespace plumb {

// The pins of axis.L.eoffset-* as the guest knows them.
struct GuestPins final : hal::Group {
    using Group::Group;

    hal::In<std::int32_t> counts{this, "guest-counts", 0,
                                 "Counts of the guest: instead of axis.L.eoffset-counts."};
    hal::In<double> scale{this, "guest-scale", 0, "mu",
                          "Offset of one count of the guest: instead of axis.L.eoffset-scale."};
    hal::In<bool> enable{this, "guest-enable", true,
                         "Follow the guest's counts; false: the guest's offset holds."};
    hal::In<bool> clear{this, "guest-clear", false, "Take the guest's offset back at once."};

    hal::Out<double> request{this, "guest-request", "mu",
                             "Offset that the guest asks for: instead of axis.L.eoffset-request."};
    hal::Out<double> applied{this, "guest-applied", "mu",
                             "Part of the offset in force that is the guest's: instead of axis.L.eoffset."};
    hal::Out<bool> active{this, "guest-active",
                          "The guest's offset is not 0: instead of motion.eoffset-active."};

    GuestOffset::Given read() const noexcept { return {counts, scale, enable, clear}; }

    // `grain` is the smallest offset that there can be.
    void show(double asked_for, double in_force, double grain) noexcept {
        request = asked_for;
        applied = in_force;
        active = std::abs(in_force) > grain;
    }
};

}  // namespace plumb
