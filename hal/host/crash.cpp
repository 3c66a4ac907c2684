// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/crash.hpp"

#include <dlfcn.h>
#include <signal.h>
#include <ucontext.h>
#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "hal/host/scheduler.hpp"

namespace plumb::host {

#ifdef __SANITIZE_ADDRESS__

void explain_crashes() {}

#else

namespace {

constexpr std::size_t stack_size = 1 << 16;

const void* place_of(const void* context) {
    [[maybe_unused]] const auto& registers = static_cast<const ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
    return reinterpret_cast<const void*>(registers.gregs[REG_RIP]);
#elif defined(__aarch64__)
    return reinterpret_cast<const void*>(registers.pc);
#else
    return nullptr;
#endif
}

void explain(int number, siginfo_t* information, void* context) {
    static bool explained = false;  // abort() fails a second time
    if (explained) return;
    explained = true;
    Dl_info place{};
    const bool known = dladdr(place_of(context), &place) != 0 && place.dli_fname != nullptr;
    const bool stack_used_up = number == SIGSEGV && scheduler().guards(information->si_addr);
    char text[512];
    const int length = std::snprintf(text, sizeof text, "plumb-host: %s%s%s%s%s\n", strsignal(number),
                                     stack_used_up ? " (a realtime thread has used up its stack)" : "",
                                     known ? " in " : "", known ? place.dli_fname : "",
                                     scheduler().running() >= 0 ? ", in a realtime function" : "");
    if (write(STDERR_FILENO, text, static_cast<std::size_t>(length)) < 0) return;
    // The handler is gone by SA_RESETHAND: the failed instruction fails again, and kills.
}

}  // namespace

void explain_crashes() {
    // A stack of its own: the stack of the thread may be used up.
    stack_t stack{};
    stack.ss_sp = std::malloc(stack_size);
    stack.ss_size = stack_size;
    if (stack.ss_sp == nullptr || sigaltstack(&stack, nullptr) != 0) return;
    struct sigaction action {};
    action.sa_sigaction = explain;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK | static_cast<int>(SA_RESETHAND);
    for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) sigaction(number, &action, nullptr);
}

#endif

}  // namespace plumb::host
