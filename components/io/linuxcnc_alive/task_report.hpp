// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

// What LinuxCNC's task reports of itself, once in each of its cycles.
struct TaskReport {
    std::uint64_t cycles;
    bool program_runs;       // or an MDI command; or is paused
    bool part_program_runs;  // or is paused
};

}  // namespace plumb
