// SPDX-License-Identifier: GPL-2.0-or-later
// The folder of a host's socket, in a folder in which every user can make others.
#pragma once

#include <string>

namespace plumb::host {

// This user's alone, in TMPDIR or /tmp. Its host holds a lock of it: so the next host knows whether its owner
// is alive.
class HostFolder {
public:
    // Throws std::runtime_error when there is no place for it.
    HostFolder();

    // Removes it, with the socket in it.
    ~HostFolder();
    HostFolder(const HostFolder&) = delete;

    const std::string& path() const { return path_; }

private:
    std::string path_;
    int lock_ = -1;
};

// Removes the folders of this user's hosts that were killed together with their keepers. A folder stays if a
// host holds its lock, answers at its socket, or has other files in it; so does one of another user, and a
// link. Returns whether there was any.
bool remove_folders_of_killed_hosts();

}  // namespace plumb::host
