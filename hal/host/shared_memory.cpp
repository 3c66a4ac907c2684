// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/shared_memory.hpp"

#include <sched.h>
#include <sys/shm.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>

#include "hal/host/leftovers.hpp"
#include "hal/host/messages.hpp"

namespace plumb::host {

namespace {

// LinuxCNC's layout of the segment that identities are drawn from: a lock, whose lowest bit is set while it
// is held, and the last number.
struct Identities {
    unsigned long lock;
    int last;
};

}  // namespace

struct SharedMemory::Segment {
    int key = 0;
    int system_id = -1;
    int users = 0;  // 0: the place is free
    void* memory = nullptr;
    std::size_t size = 0;
};

SharedMemory& shared_memory() {
    // Never destroyed, and not on the heap: sched_yield() may be called ever so late, and by the allocator.
    alignas(SharedMemory) static char place[sizeof(SharedMemory)];
    static auto& the_memory = *new (place) SharedMemory;
    return the_memory;
}

SharedMemory::SharedMemory() = default;
SharedMemory::~SharedMemory() = default;

int SharedMemory::attach(int key, std::size_t size) {
    for (std::size_t i = 0; i < segments_.size(); ++i) {
        if (segments_[i].users > 0 && segments_[i].key == key) {
            ++segments_[i].users;
            return static_cast<int>(i);
        }
    }
    auto place = std::find_if(segments_.begin(), segments_.end(),
                              [](const Segment& segment) { return segment.users == 0; });
    if (place == segments_.end()) {
        if (segments_.size() == most_segments) {
            std::fprintf(stderr, "plumb-host: more than %d shared memory segments\n", most_segments);
            return -ENOMEM;
        }
        place = segments_.insert(place, Segment{});
    }
    const int system_id = shmget(key, size, IPC_CREAT | 0600);
    if (system_id < 0) {
        const int error = errno;
        std::fprintf(stderr, "plumb-host: shared memory 0x%08x of %zu bytes: %s\n",
                     static_cast<unsigned>(key), size, std::strerror(error));
        return -error;
    }
    // Its key is known to all: another user may have been faster, and would write into HAL.
    shmid_ds state{};
    if (shmctl(system_id, IPC_STAT, &state) == 0 && state.shm_perm.cuid != geteuid() &&
        state.shm_perm.cuid != 0) {
        char text[120];
        std::snprintf(text, sizeof text, "shared memory 0x%08x is user %u's: remove it (ipcrm -M 0x%08x)\n",
                      static_cast<unsigned>(key), state.shm_perm.cuid, static_cast<unsigned>(key));
        print_message(text, true);
        return -EACCES;
    }
    void* const memory = shmat(system_id, nullptr, 0);
    if (memory == reinterpret_cast<void*>(-1)) {
        const int error = errno;
        std::fprintf(stderr, "plumb-host: cannot attach shared memory 0x%08x: %s\n",
                     static_cast<unsigned>(key), std::strerror(error));
        return -error;
    }
    leftovers().add_segment(system_id);
    *place = Segment{key, system_id, 1, memory, size};
    return static_cast<int>(place - segments_.begin());
}

int SharedMemory::detach(int handle) {
    if (address(handle) == nullptr) return -EINVAL;
    Segment& segment = segments_[static_cast<std::size_t>(handle)];
    if (--segment.users > 0) return 0;
    shmid_ds state{};
    const bool detached = shmdt(segment.memory) == 0;
    const bool removed = shmctl(segment.system_id, IPC_STAT, &state) == 0 &&
                         (state.shm_nattch > 0 || shmctl(segment.system_id, IPC_RMID, nullptr) == 0);
    segment = Segment{};
    return detached && removed ? 0 : -EINVAL;
}

void* SharedMemory::address(int handle) const {
    if (handle < 0 || static_cast<std::size_t>(handle) >= segments_.size()) return nullptr;
    return segments_[static_cast<std::size_t>(handle)].memory;
}

void* SharedMemory::address_of_key(int key) const {
    for (const Segment& segment : segments_)
        if (segment.users > 0 && segment.key == key) return segment.memory;
    return nullptr;
}

void* SharedMemory::address_of_size(std::size_t size) const {
    for (const Segment& segment : segments_)
        if (segment.users > 0 && segment.size == size) return segment.memory;
    return nullptr;
}

int SharedMemory::take_identity() {
    identity_handle_ = attach(identity_memory_key, sizeof(Identities));
    if (identity_handle_ < 0) return -EINVAL;
    auto& identities = *static_cast<Identities*>(address(identity_handle_));
    while (__atomic_fetch_or(&identities.lock, 1UL, __ATOMIC_ACQUIRE) & 1UL) sched_yield();
    const int identity = ++identities.last;
    __atomic_fetch_and(&identities.lock, ~1UL, __ATOMIC_RELEASE);
    return identity;
}

void SharedMemory::give_identity_back() {
    detach(identity_handle_);
}

}  // namespace plumb::host
