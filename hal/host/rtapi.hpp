// SPDX-License-Identifier: GPL-2.0-or-later
// Parts of the realtime interface (rtapi.h) for the host itself, beside the calls that modules know.
#pragma once

namespace plumb::host {

// Forgets the clock's period and the message settings of modules, as a new rtapi_app would not know them.
void reset_rtapi();

}  // namespace plumb::host
