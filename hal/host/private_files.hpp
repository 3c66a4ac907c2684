// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps the programs of a host in a mount namespace of its own away from hardware, and from the files that
// LinuxCNC has under fixed names, one of each on a computer.
//
// /dev has only harmless devices: null, zero, random numbers, terminals, the graphics card. /dev/shm begins
// empty. /tmp becomes a folder of the run's own that shows the content of the real /tmp at the start, but
// no lock file of LinuxCNC; files that programs add to its top level are brought to the real /tmp at the
// end. ~/.tool.mmap, the tool table that LinuxCNC's programs share, is the run's own.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/host/leftovers.hpp"

namespace plumb::host {

class PrivateFiles {
public:
    // With `devices`, /dev stays the computer's. Throws std::runtime_error when the namespace allows no
    // mounts.
    explicit PrivateFiles(bool devices);

    // Makes the real /tmp visible again.
    ~PrivateFiles();
    PrivateFiles(const PrivateFiles&) = delete;

    // Brings new files to the real /tmp, when the programs have ended. Writes to stderr which ones it
    // cannot bring. Returns whether it brought all.
    bool bring_back() const;

private:
    void furnish_devices();
    void furnish_terminals();
    void furnish_tmp();
    void hide_tool_table();
    std::filesystem::path real_tmp() const;

    int real_tmp_;                   // a descriptor
    std::vector<std::string> seen_;  // names in /tmp that come from the real one
    std::string tool_table_;
    std::optional<Placeholder> placeholder_;  // under the cover of the tool table
};

}  // namespace plumb::host
