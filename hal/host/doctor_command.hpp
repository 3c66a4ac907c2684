// SPDX-License-Identifier: GPL-2.0-or-later
// plumb doctor: says what is here, what is missing, and the command that mends it.
#pragma once

#include "hal/host/command_manual.hpp"

namespace plumb::host {

CommandPage doctor_page();

// Prints its findings. Returns the exit status: 0, or 1 when something must be mended.
int doctor();

}  // namespace plumb::host
