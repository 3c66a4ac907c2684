// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/squareness/squareness_model.hpp"
#include "components/compensation/squareness/squareness_settings.hpp"

#include <Eigen/Core>

#include <cmath>
#include <cstddef>

namespace plumb {

// The motion of the axes and the tool in force, from their pins. An invalid value keeps its last good one.
class MotionReader {
public:
    const SquarenessModel::Motion& motion() const noexcept { return motion_; }
    const Eigen::Vector3d& tool() const noexcept { return tool_; }  // mu, from the gauge point to the tip
    bool motion_known() const noexcept { return motion_known_; }
    bool tool_known() const noexcept { return tool_known_; }

    // Returns whether a position has changed faster than its axis can move within `time`.
    bool read_motion(const SquarenessSettings& settings, const AxisChain& chain, double time) noexcept {
        const double way = settings.values().max_speed * time,
                     turn = settings.values().max_rotary_speed * time;
        bool jumped = false;
        motion_known_ = true;
        for (const AxisBranch* branch : {&chain.work, &chain.tool}) {
            for (const Axis axis : *branch) {
                const SquarenessAxis& pins = settings.axes[static_cast<std::size_t>(axis)];
                const double p = pins.position, v = pins.velocity;
                double& position = motion_.position[coordinate(axis)];
                double& velocity = motion_.velocity[coordinate(axis)];
                const double last = position;
                const bool known =
                    std::abs(p) <= SquarenessAxis::farthest && std::abs(v) <= SquarenessAxis::farthest;
                motion_known_ &= known;
                position = usable(p, SquarenessAxis::farthest, position);
                velocity = known ? v : 0;
                jumped |= std::abs(position - last) > way;
            }
            for (const Axis axis : branch->members)
                if (rotary(axis)) jumped |= read_rotary(settings, direction(axis), turn);
        }
        return jumped;
    }

    template <class Offsets>
    void read_tool(const Offsets& tool_offset) noexcept {
        tool_known_ = true;
        for (int i = 0; i < 3; ++i) {
            const double offset = tool_offset[i];
            tool_known_ &= std::abs(offset) <= SquarenessSettings::longest;
            tool_[i] = -usable(offset, SquarenessSettings::longest, -tool_[i]);
        }
    }

private:
    bool read_rotary(const SquarenessSettings& settings, int r, double turn) noexcept {
        const SquarenessRotary& pins = settings.rotaries[r];
        const double sign = settings.values().rotaries[static_cast<std::size_t>(r)].reversed ? -1 : 1;
        const double angle = sign * pins.position, rate = sign * pins.velocity, last = motion_.angles[r];
        const bool known =
            std::abs(angle) <= SquarenessRotary::farthest && std::abs(rate) <= SquarenessRotary::farthest;
        motion_known_ &= known;
        motion_.angles[r] = usable(angle, SquarenessRotary::farthest, last);
        motion_.rates[r] = known ? rate : 0;
        return std::abs(motion_.angles[r] - last) > turn;
    }

    SquarenessModel::Motion motion_;
    Eigen::Vector3d tool_ = Eigen::Vector3d::Zero();
    bool motion_known_ = true, tool_known_ = true;
};

}  // namespace plumb
