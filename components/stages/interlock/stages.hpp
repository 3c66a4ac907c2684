// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/stages/stage_permit.hpp"
#include "hal/component.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumb {

// The stages that bring offsets into the axes, as their states say it.
class Stages : hal::Group {
public:
    static constexpr std::size_t most = 17;  // a joint each, and an axis

    Stages(hal::Owner owner, std::size_t number)
        : Group(owner), state_{this, number, "stage-state", 0U, "What the stage does: from its state."} {
        for (std::size_t i = 0; i < number; ++i)
            heard_.emplace_back(hal::Party::stage, hal::Direction::to_interlock,
                                static_cast<std::uint32_t>(i), 10);
    }

    std::size_t number() const noexcept { return heard_.size(); }

    // Of a period, as sums of 1, 2, 4, ... A stage that is silent has a fault, and what it said last stays.
    struct Now {
        std::int32_t in_force, ramping, uncompensated, probing_refused, fault, limited;
        std::int32_t silent, unheard;  // that do not beat now, and never did
    };

    Now read() noexcept {
        std::int32_t sums[StageState::bits]{}, missed = 0, silent = 0, unheard = 0;
        for (std::size_t i = 0; i < heard_.size(); ++i) {
            hal::BusListener& heard = heard_[i];
            heard.step(state_[i]);
            const std::uint32_t content = heard.content();
            for (int bit = 0; bit < StageState::bits; ++bit) sums[bit] |= (content >> bit & 1) << i;
            missed |= heard.missed() ? 1 << i : 0;
            silent |= heard.alive() ? 0 : 1 << i;
            unheard |= heard.heard() ? 0 : 1 << i;
        }
        return {sums[0], sums[1], sums[2], sums[3], sums[4] | missed, sums[5], silent, unheard};
    }

private:
    hal::Row<hal::In<std::uint32_t>> state_;
    std::vector<hal::BusListener> heard_;
};

}  // namespace plumb
