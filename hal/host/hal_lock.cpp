// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/hal_lock.hpp"

#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "hal/host/hal_memory.hpp"
#include "hal/host/holders.hpp"

namespace plumb::host {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto between_looks = std::chrono::milliseconds(500);  // longer than that, and nobody has looked on

// A lock whose lowest bit is set while it is held, in the memory with this key.
struct Watched {
    int key;
    const char* name;
    Clock::time_point held_since{};
    Clock::time_point last_look{};

    void look(unsigned long& lock, Clock::time_point now, std::chrono::seconds patience) {
        const bool held = (__atomic_load_n(&lock, __ATOMIC_ACQUIRE) & 1UL) != 0;
        if (!held || now - last_look > between_looks) held_since = now;
        last_look = now;
        if (now - held_since < patience) return;
        const std::string stopped = stopped_with_memory(key);
        const std::string why = stopped.empty() ? "a program was killed while it held " + std::string(name)
                                                : stopped + " is stopped and held " + name;
        std::fprintf(stderr, "plumb-host: %s; the lock is open again\n", why.c_str());
        __atomic_fetch_and(&lock, ~1UL, __ATOMIC_RELEASE);
    }
};

}  // namespace

void watch_hal_lock(std::chrono::seconds patience) {
    static Watched hal{hal_memory_key, "HAL's lock"};
    static Watched identities{identity_memory_key, "the lock of HAL's identities"};
    const auto now = Clock::now();
    if (HalMemory* const memory = hal_memory()) hal.look(memory->lock, now, patience);
    if (auto* const memory = static_cast<unsigned long*>(shared_memory().address_of_key(identity_memory_key)))
        identities.look(*memory, now, patience);
}

}  // namespace plumb::host

// Stands before the C library's: hal_lib calls it again and again while it waits for HAL's lock.
extern "C" int sched_yield() {
    plumb::host::watch_hal_lock(std::chrono::seconds(1));
    return static_cast<int>(syscall(SYS_sched_yield));
}
