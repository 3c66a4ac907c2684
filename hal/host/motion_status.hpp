// SPDX-License-Identifier: GPL-2.0-or-later
// LinuxCNC's task reads the status of motion from shared memory at any instant. motion-command-handler echoes
// a command there, and motion-controller, later in the period, the motion that begins with it. If task reads
// the status between the two, it takes the command for done before it has begun: a program ends with "Queue
// is not empty after probing". So the status of a period that takes a command is marked as incomplete until
// motion-controller completes it; task waits for a complete one.
// Task does not wait when it looks for the end of the move: after three incomplete statuses it goes on with the
// one that it read before its command. So from the next period on the status of a move is always complete.
#pragma once

#include <cstddef>

namespace plumb::host {

using HalFunction = void (*)(void* argument, long period);
using SegmentOfSize = void* (*)(std::size_t size);  // address of shared memory, or nullptr

// The function to call in the place of this one, which is exported under this name.
HalFunction marking_status(const char* name, HalFunction function, SegmentOfSize segment);

// Whether motion has taken a command since the last call.
bool motion_took_command();

}  // namespace plumb::host
