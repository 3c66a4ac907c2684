// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/rigid_body_error.hpp"
#include "components/math/geometry/tilted_branch.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>

namespace plumb {

// Position of X, Y, Z and the axis parallel to one of them, from the pivot where tilts displace no axis. In
// mu.
using AxisPosition = Eigen::Vector4d;
// Change of a vector X, Y, Z with the position.
using PositionSlopes = Eigen::Matrix<double, 3, 4>;

// The exact place of the tool's tip in the work, on a machine with tilted axes that have errors:
//
//     tip = W⁻¹ (transforms of the tool's side) T
//     transform of an axis = R(tilt) · translation by q e + (EX, EY, EZ) · R(EA, EB, EC)
//
// W are the transforms of the work's side, with q and (EX, EY, EZ) negated; R = Rz Ry Rx.
//
// Everything behind an axis turns with it; reading and datum give the part that its tilt turns. On either
// side a tilt is the same as an error (R - 1) q e with the angles of R. T points from the gauge point to
// the tip. Angles are below 0.1 rad.
class KinematicChain {
public:
    struct Settings {
        AxisChain axes;
        PerAxis<AxisTilt> tilts;
        TiltReading reading = TiltReading::component;
        TiltDatum datum = TiltDatum::rail;
    };

    struct Tip {
        Eigen::Vector3d place;  // mu, in the work
        PositionSlopes slopes;
        PositionSlopes by_direction = PositionSlopes::Zero();  // its change with the directions of motion, mu
    };

    explicit KinematicChain(const Settings& s) noexcept
        : work_(s.axes.work, s.tilts, s.reading, s.datum), tool_(s.axes.tool, s.tilts, s.reading, s.datum) {
        for (const AxisBranch& branch : {s.axes.work, s.axes.tool})
            for (const Axis axis : branch) ideal_slopes_(direction(axis), coordinate(axis)) = 1;
        end_rotation_ = work_.end_rotation().transpose() * tool_.end_rotation();
        tilted_slopes_ = by_all_members(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes;
    }

    // In force until the next one; none at first.
    void set_error(Axis axis, const AxisError& error) noexcept {
        errors_[static_cast<std::size_t>(coordinate(axis))] = {true, error};
        linear_ = false;
        directed_ = directed_ || !error.half.translation.isZero(0) || !error.half.angles.isZero(0);
    }

    // Tilts alone: the tip is linear in the position.
    bool linear() const noexcept { return linear_; }
    // An error differs by the direction of motion.
    bool directed() const noexcept { return directed_; }

    const PositionSlopes& ideal_slopes() const noexcept { return ideal_slopes_; }

    Eigen::Vector3d ideal_tip(const AxisPosition& q, const Eigen::Vector3d& tool) const noexcept {
        return ideal_slopes_ * q + tool;
    }

    Tip tip(const AxisPosition& q, const Eigen::Vector3d& tool) const noexcept {
        if (linear_) return {tilted_slopes_ * q + end_rotation_ * tool, tilted_slopes_};
        return by_all_members(q, tool);
    }

    // How far an axis travels along its own direction, by its own tilt and errors alone: of both sides.
    struct Travel {
        double distance;  // mu, from its pivot
        double slope;     // its change with the position
        double by_direction;
    };
    Travel own_travel(Axis axis, double position) const noexcept {
        AxisPosition q = AxisPosition::Zero();
        q[coordinate(axis)] = position;
        Tip travel = travel_of(axis, q, errors_at(q));
        for (const TiltedBranch* branch : {&tool_, &work_})
            for (int i = 0; i < branch->size(); ++i)
                if (branch->axis(i) == axis) turn(branch->tilt(i), travel);
        return {travel.place[direction(axis)], travel.slopes(direction(axis), coordinate(axis)),
                travel.by_direction(direction(axis), coordinate(axis))};
    }

    // (R - 1) T: by how much the tilts alone displace the tip of a tool. In mu.
    Eigen::Vector3d tool_displacement(const Eigen::Vector3d& tool) const noexcept {
        return end_rotation_ * tool - tool;
    }

private:
    struct Source {
        bool given = false;
        AxisError error;
    };
    // The error of an axis, at its position.
    struct Error {
        bool given = false;
        Eigen::Vector3d translation = Eigen::Vector3d::Zero();
        Eigen::Vector3d translation_slope = Eigen::Vector3d::Zero();
        Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
        Eigen::Vector3d rotation_slope = Eigen::Vector3d::Zero();  // rad/mu, ω
        Eigen::Vector3d translation_half = Eigen::Vector3d::Zero();
        Eigen::Vector3d rotation_half = Eigen::Vector3d::Zero();  // rad, ω
    };

    Tip by_all_members(const AxisPosition& q, const Eigen::Vector3d& tool) const noexcept {
        const PerAxis<Error> errors = errors_at(q);
        Tip sum = {tool, PositionSlopes::Zero()};
        turn_to_bed(tool_, tool_.size(), errors, sum);
        for (const TiltedBranch* branch : {&tool_, &work_}) {
            for (int i = 0; i < branch->size(); ++i) {
                Tip travel = travel_of(branch->axis(i), q, errors);
                turn_to_bed(*branch, i, errors, travel);
                sum.place += travel.place;
                sum.slopes += travel.slopes;
                if (directed_) sum.by_direction += travel.by_direction;
            }
        }
        turn_from_bed(work_, errors, sum);
        return sum;
    }

    static const Error& of(const PerAxis<Error>& errors, Axis axis) noexcept {
        return errors[static_cast<std::size_t>(coordinate(axis))];
    }

    PerAxis<Error> errors_at(const AxisPosition& q) const noexcept {
        PerAxis<Error> result;
        for (std::size_t i = 0; i < errors_.size(); ++i) {
            if (!errors_[i].given) continue;
            const RigidBodyError now = errors_[i].error.at(q[static_cast<Eigen::Index>(i)]);
            const RigidBodyError& slope = errors_[i].error.slope;
            result[i] = {true, now.translation, slope.translation, rotation(now.angles),
                         angular_rate(now.angles, slope.angles)};
            if (!directed_) continue;
            result[i].translation_half = errors_[i].error.half.translation;
            result[i].rotation_half = angular_rate(now.angles, errors_[i].error.half.angles);
        }
        return result;
    }

    // On the work's side too: the tip moves against the work.
    static Tip travel_of(Axis axis, const AxisPosition& q, const PerAxis<Error>& errors) noexcept {
        const Eigen::Vector3d e = Eigen::Vector3d::Unit(direction(axis));
        Tip travel = {q[coordinate(axis)] * e + of(errors, axis).translation, PositionSlopes::Zero()};
        travel.slopes.col(coordinate(axis)) = e + of(errors, axis).translation_slope;
        travel.by_direction.col(coordinate(axis)) = of(errors, axis).translation_half;
        return travel;
    }

    void turn(const Eigen::Matrix3d& rotation, Tip& tip) const noexcept {
        tip.place = (rotation * tip.place).eval();
        tip.slopes = (rotation * tip.slopes).eval();
        if (directed_) tip.by_direction = (rotation * tip.by_direction).eval();
    }

    // A vector that goes with member k, or with the end as k = size: turned as the members before it turn it.
    void turn_to_bed(const TiltedBranch& branch, int k, const PerAxis<Error>& errors, Tip& v) const noexcept {
        for (int i = k; i >= 0; --i) {
            if (i == branch.size()) continue;
            const Error& error = of(errors, branch.axis(i));
            if (i < k && error.given) {
                turn(error.rotation, v);
                v.slopes.col(coordinate(branch.axis(i))) += error.rotation_slope.cross(v.place);
                if (directed_)
                    v.by_direction.col(coordinate(branch.axis(i))) += error.rotation_half.cross(v.place);
            }
            if (branch.turns(i, k)) turn(branch.tilt(i), v);
        }
    }

    // A vector as the end of the branch sees it.
    void turn_from_bed(const TiltedBranch& branch, const PerAxis<Error>& errors, Tip& v) const noexcept {
        for (int i = 0; i < branch.size(); ++i) {
            if (branch.turns(i, branch.size())) turn(branch.tilt(i).transpose(), v);
            const Error& error = of(errors, branch.axis(i));
            if (!error.given) continue;
            v.slopes.col(coordinate(branch.axis(i))) -= error.rotation_slope.cross(v.place);
            if (directed_)
                v.by_direction.col(coordinate(branch.axis(i))) -= error.rotation_half.cross(v.place);
            turn(error.rotation.transpose(), v);
        }
    }

    TiltedBranch work_, tool_;
    PerAxis<Source> errors_;
    bool linear_ = true, directed_ = false;
    PositionSlopes ideal_slopes_ = PositionSlopes::Zero();
    PositionSlopes tilted_slopes_;  // of tilts alone
    Eigen::Matrix3d end_rotation_;  // of the tool as the work sees it, of tilts alone
};

}  // namespace plumb
