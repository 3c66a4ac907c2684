// SPDX-License-Identifier: GPL-2.0-or-later
// The beginning of HAL's memory, the same in all LinuxCNC 2.x.
#pragma once

#include <cstddef>

#include "hal/host/shared_memory.hpp"

namespace plumb::host {

struct HalMemory {
    int version;         // of the layout; hal_lib and user-space programs compare it
    unsigned long lock;  // its lowest bit is set while it is held
};
static_assert(offsetof(HalMemory, lock) == sizeof(unsigned long));  // at 8, or at 4 on 32 bit, as HAL has it

// Null while hal_lib is not loaded.
inline HalMemory* hal_memory() {
    return static_cast<HalMemory*>(shared_memory().address_of_key(hal_memory_key));
}

}  // namespace plumb::host
