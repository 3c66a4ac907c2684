// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace plumb::commissioning {

// The corrections that squareness wants with different settings, for a screen that announces a move. The
// document is {"chain": "w-X-Y.b-Z-C-t", "rotary": "", "states": [{"ea0y": 0.0001, "y-position": 150, ...},
// ...]}: a state has the inputs of the component by their names. The output is {"corrections": [{"X": 0.01,
// ...}, ...]}, in machine units, without error tables. Throws std::runtime_error and std::invalid_argument.
std::string squareness_corrections(std::string_view document);

}  // namespace plumb::commissioning
