// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/socket_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace plumb::hal {

void remove_socket_folder(const std::string& folder) {
    const int opened = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    struct stat state {};
    if (opened < 0) return;
    const bool ours = fstat(opened, &state) == 0 && state.st_uid == geteuid();
    if (ours) unlinkat(opened, socket_name, 0);
    close(opened);
    if (ours) rmdir(folder.c_str());
}

}  // namespace plumb::hal
