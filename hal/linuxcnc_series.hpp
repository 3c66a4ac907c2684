// SPDX-License-Identifier: GPL-2.0-or-later
// For which LinuxCNC this is compiled: 2.10 has names that 2.9 has not.
#pragma once

#include <hal.h>

#ifdef HAL_REAL
#define PLUMB_LINUXCNC_2_10
#endif

namespace plumb::hal {

#ifdef PLUMB_LINUXCNC_2_10
inline constexpr const char* linuxcnc_series = "2.10";
#else
inline constexpr const char* linuxcnc_series = "2.9";
#endif

}  // namespace plumb::hal
