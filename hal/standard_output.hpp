// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

namespace plumb {

// The exit status of a program that would end with `status`: 1, after a message, if its output could not be
// written, as on a full disk. The last thing that main() does.
inline int when_written(int status, const char* program) {
    errno = 0;
    std::cout.flush();
    if (std::cout && std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
    // An earlier failure has left no reason behind: one more byte gets it.
    const bool failed = errno != 0 || ::write(STDOUT_FILENO, "\n", 1) < 0;
    const char* const why = failed ? std::strerror(errno) : "not all of it could be written";
    std::fprintf(stderr, "%s: standard output: %s\n", program, why);
    return status == 0 ? 1 : status;
}

}  // namespace plumb
