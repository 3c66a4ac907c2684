// SPDX-License-Identifier: GPL-2.0-or-later
// The folder of a host's socket, in a folder in which every user can make others.
#pragma once

#include <string>

namespace plumb::hal {

// Name of the socket in its folder.
inline constexpr const char* socket_name = "rtapi";

// Removes such a folder, unless it is a link or another user's: once it is gone, anybody may make one of that
// name.
void remove_socket_folder(const std::string& folder);

}  // namespace plumb::hal
