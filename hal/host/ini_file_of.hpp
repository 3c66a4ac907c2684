// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdlib>
#include <fstream>
#include <string>

namespace plumb::host {

// LinuxCNC's rtapi_app has the environment of the halcmd that starts it, and modules find the name of the INI
// file in there. The host was started before: it takes the name from the process that asks for a module.
inline void take_over_ini_file(pid_t process) {
    const std::string name = "INI_FILE_NAME";
    std::ifstream environment("/proc/" + std::to_string(process) + "/environ");
    for (std::string entry; std::getline(environment, entry, '\0');)
        if (entry.compare(0, name.size() + 1, name + "=") == 0)
            setenv(name.c_str(), entry.c_str() + name.size() + 1, 1);
}

}  // namespace plumb::host
