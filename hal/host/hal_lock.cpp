// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/hal_lock.hpp"

#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>

#include "hal/host/hal_memory.hpp"

namespace plumb::host {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto patience = std::chrono::seconds(1);
constexpr auto between_looks = std::chrono::milliseconds(500);  // longer than that, and nobody has looked on

}  // namespace

void watch_hal_lock() {
    static Clock::time_point held_since{};
    static Clock::time_point last_look{};
    HalMemory* const memory = hal_memory();
    if (memory == nullptr) return;
    const auto now = Clock::now();
    const bool held = (__atomic_load_n(&memory->lock, __ATOMIC_ACQUIRE) & 1UL) != 0;
    if (!held || now - last_look > between_looks) held_since = now;
    last_look = now;
    if (now - held_since < patience) return;
    std::fputs("plumb-host: a program was killed while it held HAL's lock; the lock is open again\n", stderr);
    __atomic_fetch_and(&memory->lock, ~1UL, __ATOMIC_RELEASE);
}

}  // namespace plumb::host

// Stands before the C library's: hal_lib calls it again and again while it waits for HAL's lock.
extern "C" int sched_yield() {
    plumb::host::watch_hal_lock();
    return static_cast<int>(syscall(SYS_sched_yield));
}
