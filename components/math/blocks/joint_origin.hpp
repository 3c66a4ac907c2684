// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// Homing moves the origin of motion at the switch, long before the joint is homed, and by a feedback without
// the offset. Once the offset is released, the origin would be wrong by it.
class JointOrigin {
public:
    // The joint was homed with an offset in force, and not again since.
    bool shifted() const noexcept { return shifted_; }

    // `origin`: the command for the drive without the position of the joint; the last one if it is not known.
    void step(bool homed, double origin, bool has_offset, double slack) noexcept {
        if (homed_ && !homed) shifted_ = false;
        const bool homes = !homed_ || !homed;
        if (homes && has_offset && std::abs(origin - origin_) > slack) shifted_ = true;
        origin_ = origin;
        homed_ = homed;
    }
    double last() const noexcept { return origin_; }

private:
    double origin_ = 0;
    bool homed_ = false, shifted_ = false;
};

}  // namespace plumb
