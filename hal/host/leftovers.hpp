// SPDX-License-Identifier: GPL-2.0-or-later
// The leftovers of a killed host and its programs. The host notes all that it makes on a page that it
// shares with its keeper process (see isolation.hpp); the keeper clears it away once the host is gone.
#pragma once

#include <string>

#include "hal/socket_folder.hpp"

namespace plumb::host {

// Names of a host's files in a temporary folder begin like this.
inline constexpr const char* host_file_beginning = "plumb-host-";
inline constexpr const char* host_file_template = "plumb-host-XXXXXX";

// LinuxCNC's files in /tmp: there is one lock file on a computer, and two logs of each start.
inline constexpr const char* linuxcnc_lock_file = "linuxcnc.lock";
bool is_linuxcncs_in_tmp(const std::string& name);

class Leftovers {
public:
    // Maps the shared page; call it before the host is forked off its keeper.
    // Throws std::runtime_error when there is no memory.
    void share();

    void add_segment(int system_id);
    void set_folder(const std::string& folder);  // of the socket
    void set_placeholder(const std::string& file);

    // Removes the folder with the socket in it, and the placeholder. For the keeper.
    void clear_away() const;

    // Removes the leftovers of a host in no namespace and of its programs: shared memory that nobody has
    // attached, and files of LinuxCNC and libfaketime, all as young as the host. Call it when they are
    // dead.
    void clear_machine() const;

private:
    struct Page;
    Page* page_ = nullptr;
};

Leftovers& leftovers();

// A placeholder is an empty file that something else is mounted over, in the namespaces of one or more hosts.
// Each of them holds it.
class Placeholder {
public:
    // Makes the file, unless it is there. Where it cannot, nothing is held.
    explicit Placeholder(const std::string& file);

    // Removes the file, unless another host holds it or it is empty no more.
    ~Placeholder();
    Placeholder(const Placeholder&) = delete;

    bool held() const { return descriptor_ >= 0; }

    // The same for one that a killed host has held.
    static void remove(const std::string& file);

private:
    std::string file_;
    int descriptor_;
};

}  // namespace plumb::host
