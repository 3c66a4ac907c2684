// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/corner.hpp"
#include "components/math/geometry/kinematic_chain.hpp"
#include "components/math/geometry/tilt.hpp"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace plumb {

// A quantity such as EC0Y, of one axis.
struct SquarenessQuantity {
    Axis axis = Axis::Y;
    int rotation = 2;                   // 0, 1 or 2: A, B or C
    double angle = 0;                   // rad
    std::optional<double> uncertainty;  // rad, standard; of a setting none

    bool is_of(Axis its_axis, int its_rotation) const noexcept {
        return axis == its_axis && rotation == its_rotation;
    }
};

// The quantities of all tilted axes such that the machine has the measured corners. In a plane, the axis
// that comes first in `order` has its true direction, or the one in `settings`; each other axis has the
// direction by its corner, less the tilt of the axes that carry it. `settings` are known quantities. To the
// first order; angles multiply to less than 1e-8.
class SquarenessOfChain {
public:
    SquarenessOfChain(const AxisChain& axes, TiltReading reading, TiltDatum datum, std::vector<Axis> order)
        : axes_(axes), reading_(reading), datum_(datum), order_(std::move(order)) {}

    // Each corner once.
    std::vector<SquarenessQuantity> quantities(const std::vector<Corner>& corners,
                                               const std::vector<SquarenessQuantity>& settings) const {
        const Angles angles = angles_of(corners, settings);
        std::vector<SquarenessQuantity> result = settings;
        const Angles directions = directions_of(corners, angles);  // of which axes there are any
        for (const Axis axis : order_) {
            for (int rotation = 0; rotation < 3; ++rotation) {
                const double angle = at(angles, axis)[rotation];
                if (std::isnan(at(directions, axis)[rotation])) continue;
                const double variance = variance_of(corners, axis, rotation);
                if (variance > 0) result.push_back({axis, rotation, angle, std::sqrt(variance)});
            }
        }
        return result;
    }

private:
    using Angles = PerAxis<Eigen::Vector3d>;  // by axis; NaN: open

    static Eigen::Vector3d& at(Angles& angles, Axis axis) {
        return angles[static_cast<std::size_t>(coordinate(axis))];
    }
    static const Eigen::Vector3d& at(const Angles& angles, Axis axis) {
        return angles[static_cast<std::size_t>(coordinate(axis))];
    }

    // How the direction of each axis is turned; `starts` gives the direction of a datum.
    Angles directions_of(const std::vector<Corner>& corners, const Angles& starts) const {
        Angles turned;
        turned.fill(Eigen::Vector3d::Constant(std::nan("")));
        for (std::size_t late = 1; late < order_.size(); ++late) {
            for (std::size_t early = 0; early < late; ++early) {
                for (const Corner& corner : corners) {
                    const Axis a = order_[early], b = order_[late];
                    if (!corner.is_of(a, b)) continue;
                    const int rotation = 3 - direction(a) - direction(b);
                    const double step = (turning(b, {ideal(a), -1, 0}) * corner.opening)[rotation];
                    double& of_a = at(turned, a)[rotation];
                    double& of_b = at(turned, b)[rotation];
                    if (std::isnan(of_a)) of_a = std::isnan(of_b) ? at(starts, a)[rotation] : of_b - step;
                    of_b = of_a + step;
                }
            }
        }
        return turned;
    }

    static Axis ideal(Axis axis) { return static_cast<Axis>(direction(axis)); }

    Angles angles_of(const std::vector<Corner>& corners,
                     const std::vector<SquarenessQuantity>& settings) const {
        PerAxis<AxisTilt> tilted;
        for (AxisTilt& tilt : tilted) tilt.angles = Eigen::Vector3d::Constant(1e-6);  // any
        Angles angles, starts;
        angles.fill(Eigen::Vector3d::Zero());
        starts.fill(Eigen::Vector3d::Zero());
        for (std::size_t round = 0; round <= order_.size(); ++round) {  // finds the carriers of a set axis
            const Angles directions = directions_of(corners, starts);
            for (const AxisBranch& axes : {axes_.work, axes_.tool}) {
                const TiltedBranch branch(axes, tilted, reading_, datum_);
                for (int k = 0; k < branch.size(); ++k) {
                    Eigen::Vector3d carried = Eigen::Vector3d::Zero();
                    Eigen::Vector3d& start = at(starts, branch.axis(k));
                    start.setZero();
                    for (int i = 0; i < k; ++i) {
                        if (!branch.turns(i, k)) continue;
                        carried += at(angles, branch.axis(i));
                        for (const SquarenessQuantity& s : settings)
                            if (s.axis == branch.axis(i)) start[s.rotation] += s.angle;
                    }
                    Eigen::Vector3d& own = at(angles, branch.axis(k));
                    own = at(directions, branch.axis(k)) - carried;
                    for (int rotation = 0; rotation < 3; ++rotation)
                        if (std::isnan(own[rotation])) own[rotation] = 0;
                    for (const SquarenessQuantity& s : settings) {
                        if (s.axis != branch.axis(k)) continue;
                        own[s.rotation] = s.angle;
                        start[s.rotation] = s.angle + carried[s.rotation];
                    }
                }
            }
        }
        return angles;
    }

    // All corners are independent, and the angles linear in them.
    double variance_of(const std::vector<Corner>& corners, Axis axis, int rotation) const {
        double variance = 0;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            std::vector<Corner> one = corners;
            for (Corner& corner : one) corner.opening = 0;
            one[i].opening = corners[i].uncertainty;
            variance += std::pow(at(angles_of(one, {}), axis)[rotation], 2);
        }
        return variance;
    }

    AxisChain axes_;
    TiltReading reading_;
    TiltDatum datum_;
    std::vector<Axis> order_;
};

// By how much the angle between the + ends of two axes is more than 90 deg. In rad.
inline double opening_of(const KinematicChain& machine, Axis a, Axis b) {
    const PositionSlopes slopes = machine.tip(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes;
    return -std::asin(slopes.col(coordinate(a)).normalized().dot(slopes.col(coordinate(b)).normalized()));
}

// By how much the tip moves to the + end of X, Y or Z as another axis moves by `travel`. In mu.
inline double indicator_on_table(const KinematicChain& machine, Axis moved, Axis towards, double travel) {
    const PositionSlopes slopes = machine.tip(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes;
    return travel * slopes.col(coordinate(moved))[direction(towards)];
}

// By how much an indicator in the spindle reads more when an axis has moved by `travel`, its plunger pointing
// to the + end of `base`, on the blade of a true square whose base lies along that axis. In mu.
inline double indicator_on_square(const KinematicChain& machine, Axis moved, Axis base, double travel) {
    const PositionSlopes slopes = machine.tip(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes;
    return travel * slopes.col(coordinate(moved)).dot(slopes.col(coordinate(base)).normalized());
}

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
