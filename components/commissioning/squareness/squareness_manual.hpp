// SPDX-License-Identifier: GPL-2.0-or-later
// The texts of plumb-squareness(1).
#pragma once

#include "hal/command_manual.hpp"

namespace plumb::commissioning {

hal::CommandPage squareness_page();

}  // namespace plumb::commissioning
