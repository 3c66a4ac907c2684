// SPDX-License-Identifier: GPL-2.0-or-later
// How fast time passes: for a component that watches programs, which follow the computer's clock.
#pragma once

// Exported by the virtual-time host; null everywhere else.
extern "C" __attribute__((weak)) double plumb_host_clock_speed() noexcept;

namespace plumb::hal {

// How many times as fast as the computer's clock time passes: the speed of plumb run, 1 elsewhere.
inline double clock_speed() noexcept {
    return plumb_host_clock_speed != nullptr ? plumb_host_clock_speed() : 1;
}

}  // namespace plumb::hal
