// SPDX-License-Identifier: GPL-2.0-or-later
// Files that LinuxCNC has under fixed names, one of each on a computer, for a host in a mount namespace of
// its own: so the LinuxCNC that runs on this host meets no file of another one.
//
// /tmp becomes a folder of its own in which everything that is in the real /tmp can be seen, but no lock file
// of LinuxCNC. What programs add to its top level is brought to the real /tmp at the end. /dev/shm begins
// empty, and ~/.tool.mmap, the tool table that LinuxCNC's programs share, is the run's own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/host/leftovers.hpp"

namespace plumb::host {

class PrivateFiles {
public:
    // Throws std::runtime_error when the namespace allows no mounts.
    PrivateFiles();

    // Brings new files to the real /tmp, and makes it visible again.
    ~PrivateFiles();
    PrivateFiles(const PrivateFiles&) = delete;

private:
    void furnish_tmp();
    void hide_tool_table();
    void bring_back() const;

    int real_tmp_;                   // descriptor of the real /tmp
    std::vector<std::string> seen_;  // names in /tmp that come from the real one
    std::string tool_table_;
    std::optional<Placeholder> placeholder_;  // under the cover of the tool table
};

}  // namespace plumb::host
