// SPDX-License-Identifier: GPL-2.0-or-later
// For LD_PRELOAD: the allocation number FAIL_ALLOCATION fails, counted from the begin of main() in the
// program named FAIL_PROGRAM alone. FAIL_REPORT is a file that is there once it has failed.
#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace {

std::atomic<long> left{0};  // 0: none fails
const char* report = nullptr;

using Main = int (*)(int, char**, char**);
Main real_main = nullptr;

// For dlsym(), which may itself allocate.
alignas(std::max_align_t) char early[1 << 16];
std::size_t used = 0;

bool is_early(const void* memory) {
    return memory >= early && memory < early + sizeof early;
}

void* take_early(std::size_t size) {
    constexpr std::size_t unit = alignof(std::max_align_t);
    const std::size_t at = used;
    used += (size + unit - 1) / unit * unit;
    return used > sizeof early ? nullptr : early + at;
}

// The function that would be called without this library; null while it is looked for.
template <class Function>
Function real(Function& known, const char* name) {
    static thread_local bool looking = false;
    if (known == nullptr && !looking) {
        looking = true;
        known = reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
        looking = false;
    }
    return known;
}

void* (*real_malloc)(std::size_t) = nullptr;
void* (*real_calloc)(std::size_t, std::size_t) = nullptr;
void* (*real_realloc)(void*, std::size_t) = nullptr;
void* (*real_memalign)(std::size_t, std::size_t) = nullptr;
void (*real_free)(void*) = nullptr;

int counted_main(int argc, char** argv, char** environment) {
    const char* const number = std::getenv("FAIL_ALLOCATION");
    const char* const name = std::getenv("FAIL_PROGRAM");
    report = std::getenv("FAIL_REPORT");
    if (number != nullptr && name != nullptr && std::strcmp(name, program_invocation_short_name) == 0)
        left = std::atol(number);
    return real_main(argc, argv, environment);
}

bool fails() {
    if (left.load(std::memory_order_relaxed) == 0 || --left != 0) return false;
    if (report != nullptr) {
        const int file = open(report, O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
        if (file >= 0) close(file);
    }
    errno = ENOMEM;
    return true;
}

void* allocate(std::size_t size) {
    if (fails()) return nullptr;
    const auto next = real(real_malloc, "malloc");
    return next == nullptr ? take_early(size) : next(size);
}

void* allocate_zeros(std::size_t count, std::size_t size) {
    if (fails()) return nullptr;
    const auto next = real(real_calloc, "calloc");
    return next == nullptr ? take_early(count * size) : next(count, size);
}

void* aligned(std::size_t alignment, std::size_t size) {
    if (fails()) return nullptr;
    const auto next = real(real_memalign, "memalign");
    return next == nullptr ? nullptr : next(alignment, size);
}

}  // namespace

extern "C" {

int __libc_start_main(Main main, int argc, char** argv, void (*begin)(), void (*end)(), void (*loader_end)(),
                      void* stack) {
    real_main = main;
    using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
    const auto start = reinterpret_cast<Start>(dlsym(RTLD_NEXT, "__libc_start_main"));
    return start(counted_main, argc, argv, begin, end, loader_end, stack);
}

void* malloc(std::size_t size) {
    return allocate(size);
}

void* calloc(std::size_t count, std::size_t size) {
    return allocate_zeros(count, size);
}

void* realloc(void* memory, std::size_t size) {
    if (fails()) return nullptr;
    const auto next = real(real_realloc, "realloc");
    if (next != nullptr && !is_early(memory)) return next(memory, size);
    void* const other = allocate(size);
    if (other != nullptr && memory != nullptr) {
        const auto rest = static_cast<std::size_t>(early + sizeof early - static_cast<char*>(memory));
        std::memcpy(other, memory, size < rest ? size : rest);
    }
    return other;
}

void free(void* memory) {
    if (memory == nullptr || is_early(memory)) return;
    if (const auto next = real(real_free, "free")) next(memory);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return aligned(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
    void* const got = aligned(alignment, size);
    if (got == nullptr) return ENOMEM;
    *memory = got;
    return 0;
}

// plumb-host has a malloc() of its own, which calls these.
void* __libc_malloc(std::size_t size) {
    return allocate(size);
}
void* __libc_calloc(std::size_t count, std::size_t size) {
    return allocate_zeros(count, size);
}
}
