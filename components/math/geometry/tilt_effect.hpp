// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/axis.hpp"
#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/kinematic_chain.hpp"
#include "components/math/geometry/tilted_branch.hpp"

#include <Eigen/Core>

#include <cstddef>

namespace plumb {

// What one tilt alone does to the tip in the work, for 1 rad and to the first order.
struct TiltEffect {
    PositionSlopes travel = PositionSlopes::Zero();  // 1/rad: X, Y, Z of the tip by the position of each axis
    Eigen::Matrix3d tool = Eigen::Matrix3d::Zero();  // 1/rad: the same by the tool vector

    // It displaces the tip along a travel. If it does not, a correction moves no axis, apart from the share
    // of the tool.
    bool shows_in_travel() const noexcept { return !travel.isZero(0.5); }
    bool shows_in_tool() const noexcept { return !tool.isZero(0.5); }

    // By how much the angle between the + ends of two axes grows, per rad.
    double opening(Axis a, Axis b) const noexcept {
        return -travel(direction(a), coordinate(b)) - travel(direction(b), coordinate(a));
    }
};

// `rotation` is 0, 1 or 2: A, B or C.
inline TiltEffect effect_of_tilt(const AxisChain& axes, TiltReading reading, TiltDatum datum, Axis axis,
                                 int rotation) noexcept {
    constexpr double step = 1e-4;  // rad
    TiltEffect effect;
    for (const double angle : {step, -step}) {
        KinematicChain::Settings settings;
        settings.axes = axes;
        settings.reading = reading;
        settings.datum = datum;
        settings.tilts[static_cast<std::size_t>(coordinate(axis))].angles[rotation] = angle;
        const KinematicChain chain(settings);
        const PositionSlopes slopes = chain.tip(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes;
        effect.travel += (slopes - chain.ideal_slopes()) / (2 * angle);
        for (int i = 0; i < 3; ++i)
            effect.tool.col(i) += chain.tool_displacement(Eigen::Vector3d::Unit(i)) / (2 * angle);
    }
    // Each entry is a sum of 1 and -1; the differences leave less than 1e-7.
    effect.travel = effect.travel.array().round();
    effect.tool = effect.tool.array().round();
    return effect;
}

}  // namespace plumb
