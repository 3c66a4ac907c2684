// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

// Whether a thread is alive.
class Liveness {
public:
    // turns: grows while the thread is alive; dt: s since the last call.
    bool lives(std::uint32_t turns, double dt) noexcept {
        still_ = turns == turns_ ? still_ + dt : 0;
        turns_ = turns;
        return still_ < patience;
    }

private:
    static constexpr double patience = 2;  // s

    std::uint32_t turns_ = 0;
    double still_ = 0;
};

}  // namespace plumb
