// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>

namespace plumb {

enum class ToolKind { end_mill, drill };

// The part of its full torque, 0 to 1, that a tool takes when it has plunged by depth > 0 into the work.
// The chip of an end mill grows over its first revolution, which advances by feed_per_revolution; a drill's
// torque grows with the square of the radius that its point, 0.3 D high, has in the work.
inline double plunge_engagement(ToolKind kind, double depth, double diameter,
                                double feed_per_revolution) noexcept {
    if (!(depth > 0)) return 0;
    if (kind == ToolKind::end_mill) return depth >= feed_per_revolution ? 1 : depth / feed_per_revolution;
    const double radius = std::min(depth / (0.3 * diameter), 1.0);
    return radius * radius;
}

}  // namespace plumb
