// SPDX-License-Identifier: GPL-2.0-or-later
// plumb run: runs a LinuxCNC program with the virtual-time host as its realtime side.
#pragma once

#include <CLI/App.hpp>

#include <string>
#include <vector>

#include "hal/host/command_manual.hpp"

namespace plumb::host {

struct RunOptions {
    double speed = 1.0;
    bool free = false;
    bool network = false;
    bool devices = false;
    bool namespaces = true;
    std::vector<std::string> modules;
};

// Declares the arguments of the command, which are parsed into `options`; what follows them is the program.
void declare_run(CLI::App& command, RunOptions& options);

CommandPage run_page();

// Becomes the host that runs the program. Returns only by std::runtime_error, or the exit status 2 after it
// has said what is wrong with the command line.
int run(const RunOptions& options, const std::vector<std::string>& program);

}  // namespace plumb::host
