// SPDX-License-Identifier: GPL-2.0-or-later
// A command that is built into plumb. The file NAME_command.cpp defines one at namespace scope; that is all.
#pragma once

#include <map>
#include <string>

namespace plumb::commands {

class Command {
public:
    // `run` gets the arguments as main() does, the name of the command as the first of them.
    Command(const char* name, const char* summary, int (*run)(int argc, char** argv));
    Command(const Command&) = delete;
    Command& operator=(const Command&) = delete;

    const char* const summary;
    int (*const run)(int argc, char** argv);

    // All commands, by name.
    static std::map<std::string, const Command*>& all();
};

}  // namespace plumb::commands
