// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>
#include <cstdint>

namespace plumb {

// The offset that LinuxCNC's external offsets would be asked for by another user of an axis, its guest, which
// gives counts, scale, enable and clear as it would give them to axis.L.eoffset-*:
//
//     request += (counts - last counts) * scale
//
// while the machine is on, homed, enabled and not cleared; other steps are lost for good.  Clear makes the
// request 0.  Without enable the offset stops where it is.  Counts wrap around at 32 bits, as LinuxCNC's do.
class GuestOffset {
public:
    struct Given {
        std::int32_t counts = 0;
        double scale = 0;  // mu
        bool enable = true, clear = false;
    };

    // LinuxCNC has forgotten all offsets: the machine was turned on.
    void forget() noexcept { request_ = 0; }

    // What LinuxCNC turns out to be asked for.
    void correct(double request) noexcept { request_ = request; }

    // `takes`: LinuxCNC takes steps, as the machine is on and homed.  `applied` is the guest's part of the
    // offset in force.
    void listen(const Given& given, bool takes, double applied) noexcept {
        if (!known_) counts_ = given.counts;
        known_ = true;
        const std::int32_t steps = difference(given.counts, counts_);
        const double asked = request_ + steps * given.scale;
        const bool moves = takes && given.enable && !given.clear && steps != 0;
        good_ = !moves || (given.scale != 0 && std::abs(asked) <= largest);
        held_ = !given.enable;
        if (!good_) return;  // the step is not lost: it can be taken back, or waits for a good scale
        counts_ = given.counts;
        if (held_)
            request_ = applied;
        else if (given.clear)  // LinuxCNC clears an unhomed axis, too
            request_ = 0;
        else if (moves)
            request_ = asked;
    }

    double request() const noexcept { return request_; }
    bool held() const noexcept { return held_; }  // enable is false
    // False: a step of the counts with a scale that is 0 or invalid, or one to an offset beyond 1000.
    bool good() const noexcept { return good_; }

private:
    static constexpr double largest = 1e3;  // mu

    static std::int32_t difference(std::int32_t a, std::int32_t b) noexcept {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
    }

    double request_ = 0;
    std::int32_t counts_ = 0;
    bool known_ = false, held_ = false, good_ = true;
};

}  // namespace plumb
