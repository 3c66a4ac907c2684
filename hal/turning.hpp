// SPDX-License-Identifier: GPL-2.0-or-later
// Settings whose sign or state turns the effect of a component round, such as an angle or radius for
// diameter:
//
//     hal::Turning turning{this, angle, x_is_radius};
//
// takes pins and rows of pins. Another sign of a number, or another state of a bit, takes commissioning back.
#pragma once

#include "hal/owner.hpp"
#include "hal/registrar.hpp"

namespace plumb::hal {

class Turning {
public:
    template <class... Pins>
    explicit Turning(Owner owner, const Pins&... pins) {
        (add(owner, pins, 0), ...);
    }
    Turning(const Turning&) = delete;
    Turning& operator=(const Turning&) = delete;

private:
    template <class Pin>
    static auto add(Owner owner, const Pin& pin, int) -> decltype(pin.name(), void()) {
        owner.registrar().add(TurningInfo{pin.name()});
    }
    template <class Row>
    static void add(Owner owner, const Row& row, long) {
        for (const auto& pin : row) owner.registrar().add(TurningInfo{pin.name()});
    }
};

}  // namespace plumb::hal
