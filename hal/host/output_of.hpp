// SPDX-License-Identifier: GPL-2.0-or-later
// Where another process prints.
#pragma once

#include <sys/types.h>

namespace plumb::host {

// While it lives, modules print where a process prints, and not where the host does, if the system lets the
// host look: with stock rtapi_app, what a module says while it is loaded goes where its loader prints, which
// may be a file of its own.
class OutputOf {
public:
    explicit OutputOf(pid_t process);
    ~OutputOf();
    OutputOf(const OutputOf&) = delete;

private:
    int output_;  // -1 when it is the host's own
    int error_;
};

}  // namespace plumb::host
