// SPDX-License-Identifier: GPL-2.0-or-later
// The leftovers of a killed host and its programs. The host notes all that it makes on a page that it
// shares with its keeper process (see isolation.hpp); the keeper clears it away once the host is gone.
#pragma once

#include <memory>
#include <string>

namespace plumb::host {

// Names of a host's files in a temporary folder begin like this.
inline constexpr const char* host_file_beginning = "plumb-host-";
inline constexpr const char* host_file_template = "plumb-host-XXXXXX";

// LinuxCNC's files in /tmp: there is one lock file on a computer, and two logs of each start.
inline constexpr const char* linuxcnc_lock_file = "linuxcnc.lock";
bool is_linuxcncs_in_tmp(const std::string& name);

// Whether LinuxCNC makes a file of this name of a HALFILE with TWOPASS; it stays after an error in the HALFILE.
bool is_twopass_file(const std::string& name);

class Leftovers {
public:
    // Maps the shared page; call it before the host is forked off its keeper.
    // Throws std::runtime_error when there is no memory.
    void share();

    void add_segment(int system_id);
    void set_folder(const std::string& folder);  // of the socket
    void set_placeholder(const std::string& file);

    // The file of a user by which LinuxCNC's programs share their tool table.
    static std::string tool_table_in(const std::string& home) { return home + "/.tool.mmap"; }

    // Removes the folder with the socket in it, and the placeholder. For the keeper.
    void clear_away() const;

    // Removes the leftovers of a host in no namespace and of its programs: shared memory that nobody has
    // attached, and files of LinuxCNC and libfaketime, none of which was there when share() was called. Call
    // it when they are dead.
    void clear_machine() const;

    // Removes shared memory of LinuxCNC that nobody has attached, and of libfaketime, if its makers, which
    // were this user's, are dead: as after a kill of a host, its keeper and its programs. For a host that has
    // this machine's HAL.
    static void clear_memory_of_the_dead();

private:
    struct Page;
    struct Before;
    Page* page_ = nullptr;
    std::shared_ptr<const Before> before_;
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
