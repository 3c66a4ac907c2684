// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal_lock.hpp"

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <thread>

#include "shared_memory.hpp"

namespace plumb::host {

namespace {

/// The beginning of HAL's memory, the same in all LinuxCNC 2.x. The lowest bit of the lock says that it is
/// held.
struct HalMemory {
    std::int32_t version;
    alignas(8) unsigned long lock;
};

}  // namespace

void release_hal_lock_of_the_dead() {
    auto* const memory = static_cast<HalMemory*>(shared_memory().address_of_key(hal_memory_key));
    if (memory == nullptr) return;
    for (int look = 0; look < 30; ++look) {
        if ((__atomic_load_n(&memory->lock, __ATOMIC_ACQUIRE) & 1UL) == 0) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    std::fputs("plumb-host: a program was killed while it held HAL's lock; the lock is open again\n", stderr);
    __atomic_fetch_and(&memory->lock, ~1UL, __ATOMIC_RELEASE);
}

}  // namespace plumb::host
