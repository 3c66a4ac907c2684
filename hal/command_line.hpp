// SPDX-License-Identifier: GPL-2.0-or-later
// The command line of a program: help, version, manual page, errors.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <functional>
#include <string>

#include "hal/command_manual.hpp"

namespace plumb::hal {

// Prepares options that every program has.
void begin_command_line(CLI::App& app, CommandPage (*page)());

// Parses the arguments and calls `work`. Returns the exit status: that of `work`, 1 with a message when it
// throws or standard output cannot be written, 2 for a wrong command line, 0 after --help and the like.
int carry_out(CLI::App& app, int argc, char** argv, const std::function<int()>& work);

}  // namespace plumb::hal
