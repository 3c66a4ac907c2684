// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/output_of.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include "hal/host/messages.hpp"

namespace plumb::host {

namespace {

// A descriptor of another process, as one of this, with the same place in a file; opening the file again by
// way of /proc would not share the place.
int descriptor_of(int process, int descriptor) {
    return static_cast<int>(syscall(SYS_pidfd_getfd, process, descriptor, 0));
}

}  // namespace

OutputOf::OutputOf(pid_t process) : output_(-1), error_(-1) {
    const int handle = static_cast<int>(syscall(SYS_pidfd_open, process, 0));
    if (handle < 0) return;
    output_ = descriptor_of(handle, STDOUT_FILENO);
    error_ = descriptor_of(handle, STDERR_FILENO);
    close(handle);
    set_message_files(output_, error_);
}

OutputOf::~OutputOf() {
    set_message_files(-1, -1);
    if (output_ >= 0) close(output_);
    if (error_ >= 0) close(error_);
}

}  // namespace plumb::host
