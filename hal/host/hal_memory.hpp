// SPDX-License-Identifier: GPL-2.0-or-later
// The beginning of HAL's memory, the same in all LinuxCNC 2.x.
#pragma once

#include <cstdint>

#include "hal/host/shared_memory.hpp"

namespace plumb::host {

struct HalMemory {
    std::int32_t version;           // of the layout; hal_lib and user-space programs compare it
    alignas(8) unsigned long lock;  // its lowest bit says that it is held
};

// Null while hal_lib is not loaded.
inline HalMemory* hal_memory() {
    return static_cast<HalMemory*>(shared_memory().address_of_key(hal_memory_key));
}

}  // namespace plumb::host
