// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/functions.hpp"

#include <dlfcn.h>
#include <hal.h>

#include <cerrno>
#include <deque>

#include "hal/host/guard.hpp"
#include "hal/host/motion_status.hpp"

namespace plumb::host {

namespace {

const Function* called = nullptr;

void call(void* function, long period) {
    const auto& self = *static_cast<const Function*>(function);
    __atomic_store_n(&called, &self, __ATOMIC_RELAXED);
    self.code(self.argument, period);
}

void call_guarded(void* function, long period) {
    const Guarded watch(*static_cast<const Function*>(function));
    call(function, period);
}

std::deque<Function>& all() {
    static std::deque<Function> the_functions;  // addresses stay
    return the_functions;
}

}  // namespace

const Function* last_called() {
    return __atomic_load_n(&called, __ATOMIC_RELAXED);
}

}  // namespace plumb::host

// Stands before hal_lib's function of the same name, and calls it.
extern "C" int hal_export_funct(const char* name, void (*function)(void*, long), void* argument, int uses_fp,
                                int reentrant, int component) {
    using namespace plumb::host;
    auto* const next = reinterpret_cast<decltype(&hal_export_funct)>(dlsym(RTLD_NEXT, "hal_export_funct"));
    if (next == nullptr) return -EINVAL;
    auto& exported = all().emplace_back(Function{name, marking_status(name, function), argument});
    return next(name, guard_enabled() ? call_guarded : call, &exported, uses_fp, reentrant, component);
}
