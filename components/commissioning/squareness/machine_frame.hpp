// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb::commissioning {

// How the machine stands, of which the chain says nothing.
enum class MachineFrame { any, column, portal };

inline const char* name_of(MachineFrame frame) {
    constexpr const char* names[] = {"any", "column", "portal"};
    return names[static_cast<int>(frame)];
}

}  // namespace plumb::commissioning
