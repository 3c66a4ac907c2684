// SPDX-License-Identifier: GPL-2.0-or-later
// What a killed host would leave behind: shared memory segments, files and the folder of its socket. The host
// notes it on a page that it shares with its keeper process (see isolation.hpp), which clears it away once
// the host is gone.
#pragma once

#include <string>

namespace plumb::host {

// Name of the socket in its folder.
inline constexpr const char* socket_name = "rtapi";

class Leftovers {
public:
    // Maps the shared page; call it before the host is forked off its keeper.
    // Throws std::runtime_error when there is no memory.
    void share();

    void add_segment(int system_id);
    void set_folder(const std::string& folder);
    void add_file(const std::string& path);

    // Removes the folder with the socket in it, the files, and the segments that nobody has attached. For the
    // keeper, which must not touch `segments` of a host in an IPC namespace: there the numbers mean others,
    // and die with it.
    void clear_away(bool segments);

private:
    struct Page;
    Page* page_ = nullptr;
};

Leftovers& leftovers();

}  // namespace plumb::host
