// SPDX-License-Identifier: GPL-2.0-or-later
// Models of a machine's drivers, for plumb run --models and plumb bench --models.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace plumb::commands {

// Writes the list of models of the machine that these words load (.ini and .hal files among them), in the
// user's folder of caches, and returns its path. Prints what has a model. Throws std::runtime_error if it
// cannot be written.
std::string models_of(const std::vector<std::string>& words);

// The machine of an INI file, as LinuxCNC's script loads its realtime side.
struct IniMachine {
    std::string ini;     // for the values in its HAL files
    std::string folder;  // where all of it runs
    std::map<std::string, std::string> environment;
    std::vector<std::vector<std::string>> commands;  // of halcmd, in this order
    std::string models;                              // the list of models
};

// Without `models` only LinuxCNC's own programs have models: their pins are there, and rest. Throws
// std::runtime_error.
IniMachine machine_of(const std::string& ini, bool models);

}  // namespace plumb::commands
