// SPDX-License-Identifier: GPL-2.0-or-later
// The threads of HAL and their functions, as a realtime module sees them. LinuxCNC has no call for this, so
// the layouts of the lists in HAL's memory of LinuxCNC 2.9 and 2.10 stand here; any other is not read.
#pragma once

#include "hal/linuxcnc_series.hpp"
#include "hal/value.hpp"

#include <dlfcn.h>
#include <rtapi_mutex.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

extern "C" __attribute__((weak)) char* hal_shmem_base;  // of hal_lib

namespace plumb::hal {

struct ListedFunction {
    std::string name;
    const void* code;
    bool used;  // by a thread
};

struct ListedThread {
    std::string name;
    int task;                            // of rtapi
    std::vector<std::size_t> functions;  // in the order of its calls, as indices
};

struct ThreadList {
    std::vector<ListedFunction> functions;
    std::vector<ListedThread> threads;
};

namespace layout {

using Offset = std::intptr_t;  // from the beginning of the memory, 0 for nothing
using Name = std::array<char, HAL_NAME_LEN + 1>;

inline constexpr int most = 10000;  // elements of a list, so that a damaged one has an end

#ifdef PLUMB_LINUXCNC_2_10
inline constexpr int version = 0x14;
inline constexpr Offset size = 2 * 256 * 4096;

// A thread may take it again while it has it.
struct RecursiveLock {
    unsigned long go_on;  // its lowest bit lets one that waits go on
    int takers, depth, thread;
    std::int32_t bytes_left;  // of HAL's memory: it stands where the structure would end in padding

    bool try_take() {
        int none = 0;
        if (!__atomic_compare_exchange_n(&takers, &none, 1, false, __ATOMIC_ACQUIRE, __ATOMIC_RELAXED))
            return false;
        thread = nobody_elses;
        depth = 1;
        return true;
    }
    void give() {
        depth = 0;
        thread = 0;
        if (__atomic_sub_fetch(&takers, 1, __ATOMIC_ACQ_REL) > 0)
            __atomic_fetch_or(&go_on, 1UL, __ATOMIC_RELEASE);
    }

    static constexpr int nobody_elses = -1;  // no thread has this number
};
using Lock = RecursiveLock;
using Number = void*;  // a handle
using Longest = void*;
using Flag = void*;
#else
inline constexpr int version = 0x10;
inline constexpr Offset size = 256 * 4096;

struct BitLock {
    unsigned long taken;
    std::int32_t bytes_left;

    bool try_take() { return rtapi_mutex_try(&taken) == 0; }
    void give() { rtapi_mutex_give(&taken); }
};
using Lock = BitLock;
using Number = std::int32_t*;
using Longest = std::int32_t;
using Flag = bool;
#endif

struct Head {
    int version;
    Lock lock;
    void* constructor;
    Name prefix, argument;
    int bottom, top;
    Offset components, pins, signals, parameters, functions, threads;  // and more
};

#ifdef PLUMB_LINUXCNC_2_10
static_assert(offsetof(Head, components) == 160 && offsetof(Head, threads) == 200);  // as in its hal_priv.h
#endif

struct Function {
    Offset next;
    int floating_point;
    Offset owner;
    int reentrant, users;
    void* argument;
    void (*code)(void*, long);
    Number time;
    Longest longest_time;
    Flag longer;
    Name name;
};

struct Links {
    Offset next, previous;
};

struct Entry {
    Links links;
    void* argument;
    void (*code)(void*, long);
    Offset function;
};

struct Thread {
    Offset next;
    int floating_point;
    long period;
    int priority, task;
    Number time;
    Longest longest_time;
#ifdef PLUMB_LINUXCNC_2_10
    void* beat;
    std::int64_t beats;
#endif
    Links functions;
#ifdef PLUMB_LINUXCNC_2_10
    Links first_functions;  // run once, before the first period
    int first_done;
#endif
    Name name;
};

// The variable of hal_lib; null without it. A program that has loaded hal_lib itself asks for it.
inline char** memory() {
    return &hal_shmem_base ? &hal_shmem_base : static_cast<char**>(dlsym(RTLD_DEFAULT, "hal_shmem_base"));
}

template <class T>
const T* at(Offset offset) {
    const bool inside = offset > 0 && offset <= size - static_cast<Offset>(sizeof(T));
    return inside ? reinterpret_cast<const T*>(*memory() + offset) : nullptr;
}

inline std::string text(const Name& name) {
    return {name.data(), strnlen(name.data(), name.size())};
}

inline ThreadList read(const Head& head) {
    ThreadList result;
    std::vector<const Function*> known;
    int left = most;
    for (auto one = at<Function>(head.functions); one && left-- > 0; one = at<Function>(one->next)) {
        known.push_back(one);
        result.functions.push_back(
            {text(one->name), reinterpret_cast<const void*>(one->code), one->users > 0});
    }
    for (auto one = at<Thread>(head.threads); one && left-- > 0; one = at<Thread>(one->next)) {
        ListedThread& thread = result.threads.emplace_back(ListedThread{text(one->name), one->task, {}});
        auto entry = at<Entry>(one->functions.next);
        // The list ends where it began, in the thread.
        for (; entry && &entry->links != &one->functions && left-- > 0; entry = at<Entry>(entry->links.next))
            for (std::size_t i = 0; i < known.size(); ++i)
                if (known[i] == at<Function>(entry->function)) thread.functions.push_back(i);
    }
    return result;
}

}  // namespace layout

// What `read` makes of HAL's lists. Nothing if another program changes them this moment, or HAL is of an
// unknown kind. Waits for nobody.
template <class List>
std::optional<List> list_of_hal(List (*read)(const layout::Head&)) {
    char** const memory = layout::memory();
    auto* const head = memory ? reinterpret_cast<layout::Head*>(*memory) : nullptr;
    if (!head || head->version != layout::version || !head->lock.try_take()) return std::nullopt;
    struct Guard {
        layout::Lock& lock;
        ~Guard() { lock.give(); }
    } const guard{head->lock};
    return read(*head);
}

inline std::optional<ThreadList> list_threads() {
    return list_of_hal(layout::read);
}

}  // namespace plumb::hal
