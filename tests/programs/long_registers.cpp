// SPDX-License-Identifier: GPL-2.0-or-later
// For LD_PRELOAD with User Mode Linux. It writes the floating-point registers of a process as far as it knows
// them. Linux takes them only as a whole, and processors with AMX have more of them: the rest is left as it
// is.
#include <dlfcn.h>
#include <elf.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

#include <cstdarg>
#include <cstdint>
#include <cstring>

extern "C" long ptrace(__ptrace_request request, ...) {
    std::va_list rest;
    va_start(rest, request);
    const pid_t process = va_arg(rest, pid_t);
    void* const address = va_arg(rest, void*);
    void* const data = va_arg(rest, void*);
    va_end(rest);
    using Ptrace = long (*)(__ptrace_request, pid_t, void*, void*);
    static const auto real = reinterpret_cast<Ptrace>(dlsym(RTLD_NEXT, "ptrace"));
    if (request != PTRACE_SETREGSET || reinterpret_cast<std::uintptr_t>(address) != NT_X86_XSTATE)
        return real(request, process, address, data);
    alignas(64) static thread_local unsigned char all[1 << 15];
    iovec whole{all, sizeof all};
    const auto* const given = static_cast<const iovec*>(data);
    if (real(PTRACE_GETREGSET, process, address, &whole) != 0 || given->iov_len >= whole.iov_len)
        return real(request, process, address, data);
    std::memcpy(all, given->iov_base, given->iov_len);
    return real(request, process, address, &whole);
}
