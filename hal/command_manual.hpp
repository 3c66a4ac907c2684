// SPDX-License-Identifier: GPL-2.0-or-later
// Writes a command's manual page from its options, as declared for the command line, and a few texts.
#pragma once

#include <CLI/App.hpp>

#include <string>
#include <utility>
#include <vector>

namespace plumb::hal {

struct CommandPage {
    std::string name;                                           // of the page: plumb-bench
    std::string synopsis;                                       // after the command's words
    std::vector<std::pair<std::string, std::string>> sections;  // heading and text, after the description
    std::string see_also;                                       // halcmd(1), plumb(1)
};

// In man(7) markup, section 1. The summary and the options come from the command.
std::string command_manual(const CLI::App& command, const CommandPage& page);

// Adds the option that prints a command's manual page.
void add_manual(CLI::App& command, CommandPage (*page)());

}  // namespace plumb::hal
