// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps a host apart from everything else on the machine, and leaves nothing behind.
//
// The process that was started becomes the keeper: it forks the host, waits for its end and clears away the
// leftovers of a killed host. The host has IPC, PID and mount namespaces of its own (in a user namespace
// when it is not root's), so that any number of hosts run beside each other and beside LinuxCNC, and its
// programs die with it. Where the kernel forbids namespaces, a host that runs no program uses the machine's
// one HAL: one host at a time under a lock, and none while LinuxCNC runs.
#pragma once

namespace plumb::host {

// The host's knowledge about its own process.
struct Isolated {
    bool namespaces;  // false: it uses the machine's HAL
    int process;      // its number as seen from outside
};

// The wanted isolation of the host.
struct Isolation {
    // none: do not even try; required: no host without them, for its program would have the machine's devices
    enum class Namespaces { none, preferred, required };
    Namespaces namespaces = Namespaces::preferred;
    int control_descriptor = -1;  // when not negative, shows the keeper the client's end
    bool own_network = false;     // nothing but a loopback
    bool on_terminal = false;     // stays with the user's terminal, for the program that it runs
};

// Forks. The host returns from this; the keeper ends inside, with the host's exit status, or with the signal
// that killed it. Throws std::runtime_error when HAL is in use on this machine, a process cannot be made, or
// there are no namespaces and they are required.
//
// SIGTERM ends the host also when its keeper is killed; the caller has a handler for it by then, because
// the first process of a PID namespace has no default action.
Isolated isolate(const Isolation& wanted);

}  // namespace plumb::host
