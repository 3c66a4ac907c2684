// SPDX-License-Identifier: GPL-2.0-or-later
// A module's bug kills the host. It shall at least say which module's.
#pragma once

namespace plumb::host {

// From now on, a fatal signal prints the module in whose code it happened, and then kills as ever. A build
// with AddressSanitizer is left as it is: that tells more.
void explain_crashes();

}  // namespace plumb::host
