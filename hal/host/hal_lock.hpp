// SPDX-License-Identifier: GPL-2.0-or-later
// HAL's lists are guarded by a lock in shared memory that a killed program takes with it: stock LinuxCNC then
// hangs until it is restarted. The host takes such a lock back.
#pragma once

namespace plumb::host {

/// Opens HAL's lock if it stays held for 0.3 s. Call it when a program was killed that may have held it.
void release_hal_lock_of_the_dead();

}  // namespace plumb::host
