// SPDX-License-Identifier: GPL-2.0-or-later
// While a program runs on a host, looks for causes that would let it wait for ever or run on another clock.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plumb::host {

class Programs;

// A realtime of LinuxCNC's own that serves HAL beside the host, in a sentence; nothing where there is none.
// Ask it only while the host itself has no HAL library loaded.
std::optional<std::string> realtime_beside(const Programs& programs);

class RunWatch {
public:
    // Why the run is to end, in a sentence, or nothing. Call it at least once a second. `own_hal`: the host
    // has HAL.
    std::optional<std::string> look(const Programs& programs, bool own_hal);

private:
    using Clock = std::chrono::steady_clock;

    std::optional<std::string> look_for_task(const Programs& programs);

    Clock::time_point last_look_{};
    bool task_ = false;               // there was one at the last look
    std::vector<pid_t> scripts_;      // linuxcnc, when its task went
    Clock::time_point idle_since_{};  // they have done nothing
    std::uint64_t work_then_ = 0;
};

}  // namespace plumb::host
