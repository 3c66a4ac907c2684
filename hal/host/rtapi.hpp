// SPDX-License-Identifier: GPL-2.0-or-later
// What the host itself needs of its realtime interface (rtapi.h), beside the calls that modules know.
#pragma once

namespace plumb::host {

// Forgets the clock's period and what modules have set for messages, as a new rtapi_app would not know them.
void reset_rtapi();

}  // namespace plumb::host
