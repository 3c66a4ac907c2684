// SPDX-License-Identifier: GPL-2.0-or-later
// The contents of the words between interlock and a stage; see the manual page of interlock for their bits.
#pragma once

#include <cstdint>

namespace plumb::hal {

struct Permit {
    bool enable = false;       // the stage may apply its offset
    bool arm = false;          // a cycle runs, or a trial of this stage
    bool hold = false;         // another stage is on trial: nothing moves here
    std::uint32_t source = 0;  // that alone acts in a trial, counted from 1; 0: all but that of a trial
    double trial = 0;          // mu, the offset of a trial; 0 without one

    static constexpr std::uint32_t of_trial = 5;  // the pin trial

    constexpr std::uint32_t content() const noexcept {
        return (enable ? 1U : 0) | (arm ? 2U : 0) | (hold ? 4U : 0) | source << 3;
    }
    static constexpr Permit of(std::uint32_t content) noexcept {
        return {(content & 1) != 0, (content & 2) != 0, (content & 4) != 0, content >> 3 & 7, 0};
    }
};

struct StageState {
    bool in_force = false;         // an offset
    bool ramping = false;          // ... which still changes
    bool uncompensated = false;    // the axis lacks its offset
    bool probing_refused = false;  // a probing move began with an offset in force
    bool fault = false;
    bool limited = false;  // a limit prevents the full offset

    static constexpr int bits = 6;

    constexpr std::uint32_t content() const noexcept {
        return (in_force ? 1U : 0) | (ramping ? 2U : 0) | (uncompensated ? 4U : 0) |
               (probing_refused ? 8U : 0) | (fault ? 16U : 0) | (limited ? 32U : 0);
    }
};

}  // namespace plumb::hal
