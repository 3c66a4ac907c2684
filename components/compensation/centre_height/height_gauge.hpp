// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_settings.hpp"
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "components/math/turning/beam_area.hpp"
#include "hal/component.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace plumb {

// A measured diameter, or the areas of a laser beam that give one.
struct HeightGauge final : hal::Group {
    using Group::Group;

    hal::In<std::int32_t> kind{this, "gauge-kind", 0, "0 diameter, 1 radius, 2 rectangular, 3 round beam."};
    hal::In<double> diameter{this, "diameter", 0, "mu", "Diameter, or radius, of the cut that was measured."};
    hal::In<double> emitted{this, "emitted-area", 0, "mu2", "Area of the beam before the work."};
    hal::In<double> received{this, "received-area", 0, "mu2", "Area of the beam behind the work."};
    hal::In<double> size{this, "beam-size", 0, "mu", "Beam along the work; the radius of a round one."};

    struct Reading {
        double diameter = 0;  // mu; NaN if there is none
        bool by_beam = false;
    };

    Reading read() noexcept {
        const std::int32_t its = kind;
        if (its == 2) return {diameter_in_rectangle(emitted, received, size), true};
        if (its == 3) return {diameter_in_circle(emitted, received, size), true};
        return {its == 1 ? 2 * diameter : its == 0 ? diameter : no_diameter, false};
    }

    // An entry is a diameter, or a radius if the gauge gives one.
    double as_diameter(double entry) noexcept { return kind == 1 ? 2 * entry : entry; }
};

// Cuts that an operator enters, for a computation without motion.
struct KeyedCuts final : hal::Group {
    using Group::Group;

    static constexpr std::size_t most = 12;

    hal::In<bool> keyed{this, "keyed", false,
                        "A compute uses cut-diameter-N, cut-x-N and cut-y-N, not the procedure."};
    hal::In<std::int32_t> count{this, "cuts", 2, "Number of cuts: of cut-N, or those that compute alone."};
    hal::In<double> travel{this, "travel", 0, "mu", "Travel of X between the first two cuts; 0: positions."};
    hal::Row<hal::In<double>, most> diameter{this, "cut-diameter", 0, "mu", "Diameter of this cut."};
    hal::Row<hal::In<double>, most> x{this, "cut-x", 0, "mu", "X of this cut, as a radius, outward."};
    hal::Row<hal::In<double>, most> y{this, "cut-y", 0, "mu", "Y of this cut, against the present one."};

    TurnedCuts read(const HeightSettings::Values& now, bool by_radius) noexcept {
        TurnedCuts cuts;
        const std::int32_t wanted = count;
        cuts.count = static_cast<std::size_t>(std::clamp<std::int32_t>(wanted, 0, most));
        cuts.travel = travel;
        for (std::size_t i = 0; i < cuts.count; ++i) {
            const double entry = diameter[i];
            cuts.cuts[i] = {x[i], y[i], now.radius_of(by_radius ? 2 * entry : entry)};
        }
        return cuts;
    }
};

}  // namespace plumb
