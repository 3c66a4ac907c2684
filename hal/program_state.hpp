// SPDX-License-Identifier: GPL-2.0-or-later
// The end of a program at the bus: one word to interlock.service-state-N, and a bit for the stock watchdog.
#pragma once

#include "hal/bus.hpp"
#include "hal/group.hpp"
#include "hal/pin.hpp"
#include "hal/service.hpp"

#include <cstdint>
#include <string>

namespace plumb::hal {

// The content of the word.
struct ProgramReport {
    bool ready = true, fault = false;

    constexpr std::uint32_t content() const noexcept { return (ready ? 1U : 0) | (fault ? 2U : 0); }
    static constexpr ProgramReport of(std::uint32_t content) noexcept {
        return {(content & 1) != 0, (content & 2) != 0};
    }
};

class ProgramState : Group {
public:
    ProgramState(Owner owner, Service service, const std::string& prefix = "")
        : Group(owner),
          service_(service),
          heartbeat_{this, prefix + "heartbeat", "Changes while the program lives, for watchdog."},
          word_{this, prefix + "state", "Beat, readiness and fault: to its service-state-N of interlock."} {}

    // Once in each period; the beat counts while the program lives.
    void report(bool lives, const ProgramReport& its) noexcept {
        if (lives) ++beat_;
        heartbeat_ = (beat_ & 1) != 0;
        word_ = BusWord::of(Party::program, Direction::to_interlock, static_cast<std::uint32_t>(service_),
                            beat_, its.content());
    }

private:
    const Service service_;
    Out<bool> heartbeat_;
    Out<std::uint32_t> word_;
    std::uint32_t beat_ = 0;
};

}  // namespace plumb::hal
