// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <poll.h>

#include <algorithm>
#include <vector>

namespace plumb::host {

// Whether poll() found something at the descriptor.
inline bool is_ready(const std::vector<pollfd>& seen, int descriptor) {
    return std::any_of(seen.begin(), seen.end(), [descriptor](const pollfd& each) {
        return each.fd == descriptor && each.revents != 0;
    });
}

}  // namespace plumb::host
