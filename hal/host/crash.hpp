// SPDX-License-Identifier: GPL-2.0-or-later
// A module's bug kills the host. The host names the module first.
#pragma once

namespace plumb::host {

// From now on, a fatal signal prints the module in whose code it happened, and then kills as before. A
// build with AddressSanitizer is left as it is: its report has more.
void explain_crashes();

}  // namespace plumb::host
