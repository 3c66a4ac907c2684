// SPDX-License-Identifier: GPL-2.0-or-later
// plumb squareness: from what is set or measured of tilted axes to the settings of `squareness`.
#pragma once

#include "hal/host/squareness_arguments.hpp"

namespace plumb::host {

// Prints settings, the lines for the .hal file and the test moves. Returns 0. Throws std::runtime_error and
// std::invalid_argument.
int squareness(const SquarenessOptions& options);

}  // namespace plumb::host
