// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <limits>

namespace plumb {

// Numbers that make no sense at any input, and that any program can write there.
inline constexpr std::array<double, 6> impossible{std::numeric_limits<double>::quiet_NaN(),
                                                  std::numeric_limits<double>::infinity(),
                                                  -std::numeric_limits<double>::infinity(),
                                                  1e308,
                                                  -1e308,
                                                  5e-324};

}  // namespace plumb
