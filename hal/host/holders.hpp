// SPDX-License-Identifier: GPL-2.0-or-later
// Who keeps a host waiting: other processes on the machine, in words for its user.
#pragma once

#include <sys/types.h>

#include <string>

namespace plumb::host {

// "process 12, halcmd, of user anna". The name of the program is the process's own choice.
std::string description_of(pid_t process);

// A sentence about the process that holds the lock of a file (flock), which is open here, and the remedy.
std::string who_holds(const std::string& path, int file);

// Words about the owner of the shared memory with this key and about the process that made it, and the
// remedy.
std::string who_has_memory(int key);

// Stopped processes that have the shared memory with this key attached, in words; "" if there is none.
std::string stopped_with_memory(int key);

}  // namespace plumb::host
