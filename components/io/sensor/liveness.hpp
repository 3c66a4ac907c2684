// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

// A bit that changes at every call while a thread is alive: for the stock component watchdog, and interlock.
class Liveness {
public:
    // turns: grows while the thread is alive; dt: s since the last call.
    bool beat(std::uint32_t turns, double dt) noexcept {
        still_ = turns == turns_ ? still_ + dt : 0;
        turns_ = turns;
        if (still_ < patience) beat_ = !beat_;
        return beat_;
    }

private:
    static constexpr double patience = 2;  // s

    std::uint32_t turns_ = 0;
    double still_ = 0;
    bool beat_ = false;
};

}  // namespace plumb
