// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>

namespace plumb {

// Whether a counter that counts once in each period still does.  One below 0 is that of nobody, and counts as
// alive.  Any other one is dead until it is seen to change: a value that was left behind means nothing.
class LiveCounter {
public:
    // Once in each period.
    void step(std::int32_t count) noexcept {
        if (count < 0 || (last_ >= 0 && count != last_))
            silence_ = 0;
        else
            silence_ = last_ < 0 ? dead : std::min(silence_ + 1, missed_after);
        last_ = count;
    }

    bool alive() const noexcept { return silence_ < dead; }
    // Dead for so long that it is a fault, and not the first periods.
    bool missed() const noexcept { return silence_ >= missed_after; }

private:
    static constexpr int dead = 10, missed_after = 20;  // periods without a change

    std::int32_t last_ = -1;
    int silence_ = dead;
};

}  // namespace plumb
