// SPDX-License-Identifier: GPL-2.0-or-later
// Holds its thread for a time of the computer's clock, as a computer does that gives the processor to others
// in the middle of a period.
#include "hal/component.hpp"

#include <chrono>

namespace plumb {

struct BusyFunction final : hal::Component {
    static constexpr hal::About about{"busy_function", "holds its thread for a time of the computer's clock",
                                      "See above."};

    using Component::Component;

    hal::In<double> hold{this, "hold", 0, "s", "Time of the computer's clock in each period."};
    hal::Function run{this, "update", &BusyFunction::update, "anywhere"};

    void update(double) noexcept {
        using Clock = std::chrono::steady_clock;
        const auto begin = Clock::now();
        const std::chrono::duration<double> time(hold);
        while (Clock::now() - begin < time) continue;
    }
};

hal::Model hal::model() {
    return model_of<BusyFunction>();
}

}  // namespace plumb
