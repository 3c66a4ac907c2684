// SPDX-License-Identifier: GPL-2.0-or-later
// HAL's lists are guarded by a lock in shared memory that a killed program takes with it: stock LinuxCNC then
// hangs until it is restarted. The host takes such a lock back.
#pragma once

#include <chrono>

namespace plumb::host {

// Looks at HAL's lock and at the lock of its identities, which their owners hold for microseconds, and opens one
// that was never found open for `patience`, with a message. Call it every 0.1 s or so while somebody may wait
// for a lock; code in this process that does wait for one looks by itself, for a second.
void watch_hal_lock(std::chrono::seconds patience);

}  // namespace plumb::host
