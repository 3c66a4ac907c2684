// SPDX-License-Identifier: GPL-2.0-or-later
// What a write to an input moves, declared once:
//
//     hal::Effects at_once{this, hal::Effect::at_once, angle, pivot};
//
// takes pins and rows of pins. An input that is in none moves nothing when it is written. Screens announce
// a move by it, and refuse the write while a program runs; a test compares it with the motion.
#pragma once

#include "hal/owner.hpp"
#include "hal/registrar.hpp"

namespace plumb::hal {

enum class Effect {
    at_once,      // the offset goes to where the new value wants it
    next_cycle,   // ... when the next cycle of the program begins
    in_no_cycle,  // it moves nothing, but must not change while a program runs
    applies,      // true lets the offset follow; false returns it to 0 at once
    withholds,    // true returns the offset to 0 at once; false lets it follow
};

constexpr const char* name(Effect effect) {
    switch (effect) {
        case Effect::at_once: return "at once";
        case Effect::next_cycle: return "at the next cycle";
        case Effect::in_no_cycle: return "refused while a cycle runs";
        case Effect::applies: return "applies";
        default: return "withholds";
    }
}

class Effects {
public:
    template <class... Pins>
    Effects(Owner owner, Effect effect, const Pins&... pins) {
        (add(owner, effect, pins, 0), ...);
    }
    Effects(const Effects&) = delete;
    Effects& operator=(const Effects&) = delete;

private:
    template <class Pin>
    static auto add(Owner owner, Effect effect, const Pin& pin, int) -> decltype(pin.name(), void()) {
        owner.registrar().add(EffectInfo{pin.name(), name(effect)});
    }
    template <class Row>
    static void add(Owner owner, Effect effect, const Row& row, long) {
        for (const auto& pin : row) owner.registrar().add(EffectInfo{pin.name(), name(effect)});
    }
};

}  // namespace plumb::hal
