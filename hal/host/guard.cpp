// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/guard.hpp"

#include <dlfcn.h>
#include <hal.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <deque>
#include <stdexcept>

#include "hal/host/motion_status.hpp"
#include "hal/host/shared_memory.hpp"

#ifdef __SANITIZE_ADDRESS__
// gcc has this function, and no header that declares it.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*allocated)(const volatile void*, std::size_t),
                                                         void (*released)(const volatile void*));
#endif

#ifndef PR_SET_SYSCALL_USER_DISPATCH
#define PR_SET_SYSCALL_USER_DISPATCH 59
#define PR_SYS_DISPATCH_ON 1
#endif

namespace plumb::host {

namespace {

using Function = void (*)(void* argument, long period);

// A function of a module, and the one that is called in its place.
struct Watched {
    std::string name;
    Function function;
    void* argument;
};

enum class Deed : int { allocated, released, printed, called_system };

struct Note {
    const Watched* function;
    Deed deed;
    unsigned long detail;  // bytes, or the number of the system call
};

// The value that the kernel reads before each system call.
constexpr char allow = 0;
constexpr char block = 1;
volatile char system_calls = allow;

bool enabled = false;
thread_local const Watched* running = nullptr;

// Filled in the middle of realtime functions and signal handlers: no container.
std::array<Note, 1000> notes;
std::size_t note_count = 0;

void note(Deed deed, unsigned long detail) {
    const Note* const end = notes.data() + note_count;
    const bool known = std::any_of(static_cast<const Note*>(notes.data()), end, [&](const Note& each) {
        return each.function == running && each.deed == deed && each.detail == detail;
    });
    if (!known && note_count < notes.size()) notes[note_count++] = {running, deed, detail};
}

void call_watched(void* watched, long period) {
    const auto& self = *static_cast<const Watched*>(watched);
    running = &self;
    system_calls = block;
    self.function(self.argument, period);
    system_calls = allow;
    running = nullptr;
}

std::deque<Watched>& all_watched() {
    static std::deque<Watched> the_functions;  // addresses stay
    return the_functions;
}

std::string text_of(const Note& each) {
    switch (each.deed) {
        case Deed::allocated: return "allocated " + std::to_string(each.detail) + " bytes";
        case Deed::released: return "released memory";
        case Deed::printed: return "printed a message";
        case Deed::called_system: break;
    }
    return "system call " + std::to_string(each.detail);
}

#ifdef __x86_64__

// The return from the signal is itself a system call, which must pass while the others are dispatched: the
// kernel lets calls from this piece of code through.
extern "C" void plumb_host_return_from_signal();
extern "C" const char plumb_host_return_from_signal_end;
asm(R"(
    .text
    .globl plumb_host_return_from_signal, plumb_host_return_from_signal_end
    .type plumb_host_return_from_signal, @function
plumb_host_return_from_signal:
    mov $15, %rax
    syscall
    ud2
plumb_host_return_from_signal_end:
)");

// The kernel's own form of sigaction: the C library's has another way back.
struct KernelAction {
    void (*handler)(int, siginfo_t*, void*);
    unsigned long flags;
    void (*restorer)();
    unsigned long mask;
};

void on_system_call(int, siginfo_t*, void* context) {
    constexpr int length_of_syscall_instruction = 2;
    system_calls = allow;
    const int saved_errno = errno;
    greg_t* const registers = static_cast<ucontext_t*>(context)->uc_mcontext.gregs;
    const long number = registers[REG_RAX];
    note(Deed::called_system, static_cast<unsigned long>(number));
    if (number == SYS_clone || number == SYS_clone3 || number == SYS_fork || number == SYS_vfork) {
        // A new process must not begin in here: the function makes this call again, unwatched from here on.
        registers[REG_RIP] -= length_of_syscall_instruction;
    } else {
        register long r10 asm("r10") = registers[REG_R10];
        register long r8 asm("r8") = registers[REG_R8];
        register long r9 asm("r9") = registers[REG_R9];
        long result = 0;
        asm volatile("syscall"
                     : "=a"(result)
                     : "a"(number), "D"(registers[REG_RDI]), "S"(registers[REG_RSI]), "d"(registers[REG_RDX]),
                       "r"(r10), "r"(r8), "r"(r9)
                     : "rcx", "r11", "memory");
        registers[REG_RAX] = result;
        system_calls = block;
    }
    errno = saved_errno;
}

// Empty, or why they cannot be watched.
std::string dispatch_system_calls() {
    constexpr unsigned long sa_restorer = 0x04000000;
    const KernelAction action{on_system_call, SA_SIGINFO | SA_NODEFER | sa_restorer,
                              plumb_host_return_from_signal, 0};
    const auto* const begin = reinterpret_cast<const char*>(plumb_host_return_from_signal);
    if (syscall(SYS_rt_sigaction, SIGSYS, &action, nullptr, sizeof action.mask) != 0 ||
        prctl(PR_SET_SYSCALL_USER_DISPATCH, PR_SYS_DISPATCH_ON, begin,
              &plumb_host_return_from_signal_end - begin, &system_calls) != 0)
        return std::string("this kernel refuses to dispatch them (") + std::strerror(errno) + ")";
    return "";
}

#else

std::string dispatch_system_calls() {
    return "on this kind of processor Linux does not dispatch them";
}

#endif

}  // namespace

void enable_guard() {
    const std::string not_watched = dispatch_system_calls();
    if (!not_watched.empty())
        std::fprintf(stderr, "plumb-host: the guard watches memory and messages, but not system calls: %s\n",
                     not_watched.c_str());
#ifdef __SANITIZE_ADDRESS__
    const auto allocated = [](const volatile void*, std::size_t size) {
        if (running != nullptr) note(Deed::allocated, size);
    };
    const auto released = [](const volatile void* memory) {
        if (running != nullptr && memory != nullptr) note(Deed::released, 0);
    };
    if (__sanitizer_install_malloc_and_free_hooks(allocated, released) == 0)
        throw std::runtime_error("AddressSanitizer takes no more hooks to watch allocations");
#endif
    enabled = true;
}

bool guard_enabled() {
    return enabled;
}

std::vector<Misdeed> misdeeds() {
    std::vector<Misdeed> found;
    for (std::size_t i = 0; i < note_count; ++i)
        found.push_back({notes[i].function->name, text_of(notes[i])});
    return found;
}

Printing::Printing() : watched_(running) {
    if (running == nullptr) return;
    system_calls = allow;
    note(Deed::printed, 0);
    running = nullptr;
}

Printing::~Printing() {
    if (watched_ == nullptr) return;
    running = static_cast<const Watched*>(watched_);
    system_calls = block;
}

}  // namespace plumb::host

// Stands before hal_lib's function of the same name, and calls it.
extern "C" int hal_export_funct(const char* name, void (*function)(void*, long), void* argument, int uses_fp,
                                int reentrant, int component) {
    auto* const next = reinterpret_cast<decltype(&hal_export_funct)>(dlsym(RTLD_NEXT, "hal_export_funct"));
    if (next == nullptr) return -EINVAL;
    function = plumb::host::marking_status(
        name, function, [](std::size_t size) { return plumb::host::shared_memory().address_of_size(size); });
    if (!plumb::host::guard_enabled()) return next(name, function, argument, uses_fp, reentrant, component);
    auto& watched = plumb::host::all_watched().emplace_back(plumb::host::Watched{name, function, argument});
    return next(name, plumb::host::call_watched, &watched, uses_fp, reentrant, component);
}

#ifndef __SANITIZE_ADDRESS__

// The C library's own allocator under its other names. Functions that the host does not replace keep using
// the same heap.
extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* memory);

static void note_allocation(std::size_t size) {
    if (plumb::host::running != nullptr) plumb::host::note(plumb::host::Deed::allocated, size);
}

void* malloc(std::size_t size) {
    note_allocation(size);
    return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
    note_allocation(count * size);
    return __libc_calloc(count, size);
}

void* realloc(void* memory, std::size_t size) {
    note_allocation(size);
    return __libc_realloc(memory, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
    note_allocation(size);
    return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return memalign(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
    if (alignment % sizeof(void*) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0) return EINVAL;
    void* const allocated = memalign(alignment, size);
    if (allocated == nullptr) return ENOMEM;
    *memory = allocated;
    return 0;
}

void free(void* memory) {
    if (memory != nullptr && plumb::host::running != nullptr)
        plumb::host::note(plumb::host::Deed::released, 0);
    __libc_free(memory);
}

}  // extern "C"

#endif
