// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/command_manual.hpp"

namespace plumb::commissioning {

hal::CommandPage volume_page();

}  // namespace plumb::commissioning
