// SPDX-License-Identifier: GPL-2.0-or-later
// Where another process prints.
#pragma once

#include <sys/types.h>

namespace plumb::host {

// While it lives, modules print where a process prints, and not where the host does, if the system lets the
// host look. With stock rtapi_app, messages of a module at load go to the output of its loader, which may
// be a file of its own.
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
