// SPDX-License-Identifier: GPL-2.0-or-later
// Work of a module beside realtime, for example reading a table again. LinuxCNC runs it on a thread of its
// own. Here the module registers it, and the host runs it to completion between two periods, so that runs
// stay equal.
#pragma once

namespace plumb::host {

// Does all registered background work, in the order of registration.
void work_in_background();

// Whether there is any registered work.
bool has_background_work();

}  // namespace plumb::host

extern "C" {

// For modules, which declare it as a weak symbol: it is there only in this host. `work` is called between
// periods, for as long as it is registered.
void plumb_host_register_background(void (*work)(void* argument), void* argument);

// Undoes one registration of the same two values.
void plumb_host_unregister_background(void (*work)(void* argument), void* argument);
}
