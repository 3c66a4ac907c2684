// SPDX-License-Identifier: GPL-2.0-or-later
// Watches realtime functions for forbidden acts: to allocate or release memory, to print, or to call the
// system. All of it still happens, and is noted with the function's name. Only functions that are exported
// after enable_guard() are watched; without it there is no watch and no cost.
//
// Memory is watched by the malloc family, which this executable exports before the C library's, or in a
// build with AddressSanitizer by its hooks; system calls by the kernel's dispatch to a signal, which x86-64
// alone has, since Linux 5.11. Elsewhere they are not watched, and stderr gets a message.
#pragma once

#include <string>
#include <vector>

namespace plumb::host {

// A forbidden act of a function; each kind is noted once.
struct Misdeed {
    std::string function;
    std::string what;  // "allocated 16 bytes", "released memory", "printed a message", "system call 39"
};

// Begins to watch. Writes to stderr if system calls cannot be watched. Throws std::runtime_error if memory
// cannot be watched.
void enable_guard();

bool guard_enabled();

// In the order in which they were noted; no more than 1000.
std::vector<Misdeed> misdeeds();

// Notes that the running function prints, and lets it go unwatched for as long as this lives: the host
// passes messages on, not the function.
class Printing {
public:
    Printing();
    ~Printing();
    Printing(const Printing&) = delete;

private:
    const void* watched_;
};

}  // namespace plumb::host
