// SPDX-License-Identifier: GPL-2.0-or-later
// The beginning of HAL's memory, and its lock. The version tells which of two layouts it has.
#pragma once

#include <cstddef>

#include "hal/host/shared_memory.hpp"

namespace plumb::host {

struct HalMemory {
    int version;         // of the layout; hal_lib and user-space programs compare it
    unsigned long lock;  // LinuxCNC 2.9: its lowest bit is set while it is held. 2.10: it is set to let one
                         // that waits go on

    // Since LinuxCNC 2.10: a thread may take the lock again while it has it.
    int takers;  // that have the lock or wait for it, each as often as it asked
    int depth;   // how often the present thread has it
    int thread;  // 0 if none has it

    static constexpr int with_recursive_lock = 0x14;
    bool recursive() const { return version >= with_recursive_lock; }
};
static_assert(offsetof(HalMemory, lock) == sizeof(unsigned long));  // at 8, or at 4 on 32 bit, as HAL has it

// Null while hal_lib is not loaded.
inline HalMemory* hal_memory() {
    return static_cast<HalMemory*>(shared_memory().address_of_key(hal_memory_key));
}

}  // namespace plumb::host
