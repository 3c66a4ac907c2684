// SPDX-License-Identifier: GPL-2.0-or-later
// HAL's lists are guarded by a lock in shared memory that a killed program takes with it: stock LinuxCNC then
// hangs until it is restarted. The host takes such a lock back.
#pragma once

namespace plumb::host {

// Looks at HAL's lock, which its owners hold for microseconds, and opens it when it was never found open for
// a second. Call it every 0.1 s or so while somebody may wait for the lock; code in this process that does
// wait for it looks by itself.
void watch_hal_lock();

}  // namespace plumb::host
