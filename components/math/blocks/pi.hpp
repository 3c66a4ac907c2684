// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

inline constexpr double pi = 3.14159265358979323846;

}  // namespace plumb
