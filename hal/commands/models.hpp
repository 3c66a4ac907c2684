// SPDX-License-Identifier: GPL-2.0-or-later
// Models of a machine's drivers, for plumb run --models and plumb bench --models.
#pragma once

#include <string>
#include <vector>

namespace plumb::commands {

// Writes the list of models of the machine that these words load (.ini and .hal files among them), in the
// user's folder of caches, and returns its path. Prints what has a model. Throws std::runtime_error if it
// cannot be written.
std::string models_of(const std::vector<std::string>& words);

}  // namespace plumb::commands
