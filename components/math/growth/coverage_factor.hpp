// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// The factor by which a standard uncertainty of this many degrees of freedom, above 0, covers 95.45 of 100: 2
// for many (Student's t).
double coverage_factor(double freedom);

}  // namespace plumb
