// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace plumb {

// x if it is a number between -limit and limit, else `otherwise`.
inline double usable(double x, double limit, double otherwise) noexcept {
    return x >= -limit && x <= limit ? x : otherwise;
}

}  // namespace plumb
