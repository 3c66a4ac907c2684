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

// A lock whose lowest bit is set while it is held.
class BitLock {
public:
    explicit BitLock(unsigned long& lock) : lock_(lock) {}
    bool held() const { return (__atomic_load_n(&lock_, __ATOMIC_ACQUIRE) & 1UL) != 0; }
    void open() { __atomic_fetch_and(&lock_, ~1UL, __ATOMIC_RELEASE); }

private:
    unsigned long& lock_;
};

// HAL's lock since LinuxCNC 2.10.
class RecursiveLock {
public:
    explicit RecursiveLock(HalMemory& memory) : memory_(memory) {}
    bool held() const { return __atomic_load_n(&memory_.takers, __ATOMIC_ACQUIRE) > 0; }
    // A program can be killed before it has counted itself as the holder: it still is one of the takers.
    void open() {
        const int depth = memory_.depth > 0 ? memory_.depth : 1;
        memory_.thread = 0;
        memory_.depth = 0;
        const int waiting = __atomic_sub_fetch(&memory_.takers, depth, __ATOMIC_ACQ_REL);
        if (waiting > 0) __atomic_fetch_or(&memory_.lock, 1UL, __ATOMIC_RELEASE);
    }

private:
    HalMemory& memory_;
};

// A lock in the memory with this key.
struct Watched {
    int key;
    const char* name;
    Clock::time_point held_since{};
    Clock::time_point last_look{};

    template <class Lock>
    void look(Lock lock, Clock::time_point now, std::chrono::seconds patience) {
        if (!lock.held() || now - last_look > between_looks) held_since = now;
        last_look = now;
        if (now - held_since < patience) return;
        const std::string stopped = stopped_with_memory(key);
        const std::string why = stopped.empty() ? "a program was killed while it held " + std::string(name)
                                                : stopped + " is stopped and held " + name;
        std::fprintf(stderr, "plumb-host: %s; the lock is open again\n", why.c_str());
        lock.open();
        held_since = now;
    }
};

}  // namespace

void watch_hal_lock(std::chrono::seconds patience) {
    static Watched hal{hal_memory_key, "HAL's lock"};
    static Watched identities{identity_memory_key, "the lock of HAL's identities"};
    const auto now = Clock::now();
    if (HalMemory* const memory = hal_memory()) {
        if (memory->recursive())
            hal.look(RecursiveLock(*memory), now, patience);
        else
            hal.look(BitLock(memory->lock), now, patience);
    }
    if (auto* const memory = static_cast<unsigned long*>(shared_memory().address_of_key(identity_memory_key)))
        identities.look(BitLock(*memory), now, patience);
}

}  // namespace plumb::host

// Stands before the C library's: hal_lib calls it again and again while it waits for HAL's lock.
extern "C" int sched_yield() {
    plumb::host::watch_hal_lock(std::chrono::seconds(1));
    return static_cast<int>(syscall(SYS_sched_yield));
}
