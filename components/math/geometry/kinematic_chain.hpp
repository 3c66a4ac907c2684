// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/axis_chain.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace plumb {

// Rz(EC) Ry(EB) Rx(EA) of the angles (EA, EB, EC), in rad.
inline Eigen::Matrix3d rotation(const Eigen::Vector3d& angles) noexcept {
    const double ca = std::cos(angles.x()), sa = std::sin(angles.x());
    const double cb = std::cos(angles.y()), sb = std::sin(angles.y());
    const double cc = std::cos(angles.z()), sc = std::sin(angles.z());
    Eigen::Matrix3d r;
    r << cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa,  //
        sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa,   //
        -sb, cb * sa, cb * ca;
    return r;
}

// The vector ω of a rotation whose angles change at these rates: d/dt rotation(angles) = [ω]×
// rotation(angles).
inline Eigen::Vector3d angular_rate(const Eigen::Vector3d& angles, const Eigen::Vector3d& rates) noexcept {
    const double cb = std::cos(angles.y()), sb = std::sin(angles.y());
    const double cc = std::cos(angles.z()), sc = std::sin(angles.z());
    return {cc * cb * rates.x() - sc * rates.y(), sc * cb * rates.x() + cc * rates.y(),
            rates.z() - sb * rates.x()};
}

// Of ISO 230-1, for an axis A: (EXA, EYA, EZA) in mu and (EAA, EBA, ECA) in rad.
struct RigidBodyError {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    Eigen::Vector3d angles = Eigen::Vector3d::Zero();
};

// Rigid-body error of an axis near a position of it: best the one where the correction takes it.
struct AxisError {
    double position = 0;    // mu
    RigidBodyError value;   // there
    RigidBodyError slope;   // its change per mu
    RigidBodyError half{};  // its change with the direction of motion, from 0 to 1

    RigidBodyError at(double coordinate) const noexcept {
        const double distance = coordinate - position;
        return {value.translation + slope.translation * distance, value.angles + slope.angles * distance};
    }
};

// A tilt turns the axis itself, the end (the tool or the work), and
//  - component: all that the axis carries (the rail, and so the saddle, turns with it);
//  - axis_direction: only the axes parallel to it (the saddle stays level).
enum class TiltReading { component, axis_direction };

// The datum of the tilt of an axis that rides on a parallel one: the rail that carries it, or the bed.
// Against the bed it replaces the tilt of the rail, for that axis and all that it carries.
enum class TiltDatum { rail, bed };

struct AxisTilt {
    Eigen::Vector3d angles = Eigen::Vector3d::Zero();  // rad, (EA0, EB0, EC0) of ISO 230-1
    bool end_follows = true;                           // false: tool or work were set up square
};

// One value for each axis, in the order of a position; axes that the chain does not have are ignored.
template <typename T>
using PerAxis = std::array<T, 4>;

// The place of a rotary axis: a point of it, and the errors of the machine against the drawing. A, B, C in
// this order.
struct RotaryPlace {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();   // mu, nominal, with X, Y and Z at 0
    Eigen::Vector3d error = Eigen::Vector3d::Zero();   // mu, (EX0, EY0, EZ0)
    Eigen::Vector3d angles = Eigen::Vector3d::Zero();  // rad, (EA0, EB0, EC0)
};
using RotaryPlaces = std::array<RotaryPlace, 3>;

// The axes of one side of a chain, and which of them each tilt turns. A rotary axis goes with the end, and
// its tilt turns all that it carries.
class TiltedBranch {
public:
    TiltedBranch(const AxisBranch& axes, const PerAxis<AxisTilt>& tilts, TiltReading reading, TiltDatum datum,
                 const RotaryPlaces& places = {}) noexcept
        : axes_(axes.members) {
        for (int i = 0; i < size(); ++i) {
            const bool turns_all = rotary(axis(i)) || reading == TiltReading::component;
            const AxisTilt tilt =
                rotary(axis(i)) ? AxisTilt{places[static_cast<std::size_t>(direction(axis(i)))].angles, true}
                                : tilts[static_cast<std::size_t>(coordinate(axis(i)))];
            if (tilt.angles.isZero(0)) continue;
            Member& member = members_[static_cast<std::size_t>(i)];
            member.rotation = rotation(tilt.angles);
            for (int k = i; k <= size(); ++k) {
                const bool follows = k == size() ? tilt.end_follows
                                     : k > i && rotary(axis(k))
                                         ? turns_all || tilt.end_follows
                                         : turns_all || k == i || parallel(axis(i), axis(k));
                const bool replaced = datum == TiltDatum::bed && rider(i) <= k;
                member.turns[static_cast<std::size_t>(k)] = follows && !replaced;
            }
        }
    }

    int size() const noexcept { return axes_.size; }
    bool has(Axis axis) const noexcept { return std::find(axes_.begin(), axes_.end(), axis) != axes_.end(); }
    Axis axis(int i) const noexcept { return axes_.axes[static_cast<std::size_t>(i)]; }

    // Whether the tilt of member i turns member k, or the end as k = size.
    bool turns(int i, int k) const noexcept {
        return members_[static_cast<std::size_t>(i)].turns[static_cast<std::size_t>(k)];
    }
    const Eigen::Matrix3d& tilt(int i) const noexcept {
        return members_[static_cast<std::size_t>(i)].rotation;
    }

    Eigen::Matrix3d end_rotation() const noexcept {
        Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
        for (int i = 0; i < size(); ++i)
            if (turns(i, size())) result = (result * tilt(i)).eval();
        return result;
    }

private:
    struct Member {
        Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
        std::array<bool, 8> turns{};
    };

    // The first member that rides on member i, parallel to it; beyond the end if there is none.
    int rider(int i) const noexcept {
        int k = i + 1;
        while (k < size() && !parallel(axis(i), axis(k))) ++k;
        return k < size() ? k : size() + 1;
    }

    AxisList<7> axes_;
    std::array<Member, 7> members_;
};

// Position of X, Y, Z and the axis parallel to one of them, from the pivot where tilts displace no axis. In
// mu.
using AxisPosition = Eigen::Vector4d;
// Change of a vector X, Y, Z with the position.
using PositionSlopes = Eigen::Matrix<double, 3, 4>;
// And with the angles of A, B and C, in mu per deg.
using RotarySlopes = Eigen::Matrix3d;

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
//
//     transform of a rotary axis = move by P + E0 · R(tilt) · translation by (EX, EY, EZ) · R(EA, EB, EC) ·
//     R(q) · move by -P
//
// P is a point of the axis on an ideal machine. On the work's side q, (EX, EY, EZ) and the angle about the
// axis itself are negated. Errors have the directions of the machine at any q.
class KinematicChain {
public:
    struct Settings {
        AxisChain axes;
        PerAxis<AxisTilt> tilts;
        TiltReading reading = TiltReading::component;
        TiltDatum datum = TiltDatum::rail;
        RotaryPlaces places{};
    };

    struct Tip {
        Eigen::Vector3d place;  // mu, in the work
        PositionSlopes slopes;
        PositionSlopes by_direction = PositionSlopes::Zero();  // its change with the directions of motion, mu
        RotarySlopes by_rotary = RotarySlopes::Zero();
    };

    explicit KinematicChain(const Settings& s) noexcept
        : work_(s.axes.work, s.tilts, s.reading, s.datum, s.places),
          tool_(s.axes.tool, s.tilts, s.reading, s.datum, s.places),
          places_(s.places) {
        rotary_ = s.axes.rotary();
        linear_ = !rotary_;
        for (const AxisBranch& branch : {s.axes.work, s.axes.tool})
            for (const Axis axis : branch) ideal_slopes_(direction(axis), coordinate(axis)) = 1;
        end_rotation_ = work_.end_rotation().transpose() * tool_.end_rotation();
        tilted_slopes_ = by_all_members(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes;
    }

    // In force until the next one; none at first.
    void set_error(Axis axis, const AxisError& error) noexcept {
        Source& its = errors_[static_cast<std::size_t>(coordinate(axis))];
        its = {true, error};
        linear_ = false;
        if (rotary(axis)) {
            if (!work_.has(axis)) return;
            its.error.value.angles[direction(axis)] *= -1;
            its.error.slope.angles[direction(axis)] *= -1;
            return;
        }
        directed_ = directed_ || !error.half.translation.isZero(0) || !error.half.angles.isZero(0);
    }

    // Where A, B or C stands, in deg, until the next one.
    void set_angle(Axis axis, double angle) noexcept {
        angles_[static_cast<std::size_t>(direction(axis))] = angle;
    }
    bool has_rotary() const noexcept { return rotary_; }

    // Tilts alone: the tip is linear in the position.
    bool linear() const noexcept { return linear_; }
    // An error differs by the direction of motion.
    bool directed() const noexcept { return directed_; }

    const PositionSlopes& ideal_slopes() const noexcept { return ideal_slopes_; }

    Eigen::Vector3d ideal_tip(const AxisPosition& q, const Eigen::Vector3d& tool) const noexcept {
        return rotary_ ? ideal_by_all_members(q, tool).place : Eigen::Vector3d(ideal_slopes_ * q + tool);
    }

    // With slopes.
    Tip ideal(const AxisPosition& q, const Eigen::Vector3d& tool) const noexcept {
        if (rotary_) return ideal_by_all_members(q, tool);
        return {ideal_slopes_ * q + tool, ideal_slopes_};
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
    static constexpr double degree = 0.017453292519943295;  // rad

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

    struct Errors {
        PerAxis<Error> linear;
        std::optional<std::array<Error, 3>> rotary;  // of a chain that has such axes
    };

    // On the work's side an axis turns the work the other way.
    double sign_of(const TiltedBranch& branch) const noexcept { return &branch == &work_ ? -1 : 1; }

    static Eigen::Matrix3d spun(Axis axis, double angle) noexcept {
        return Eigen::AngleAxisd(angle * degree, Eigen::Vector3d::Unit(direction(axis))).toRotationMatrix();
    }

    // Turns a vector that A, B or C carries, by sign times its angle.
    void spin(Axis axis, double sign, Tip& v) const noexcept {
        const int r = direction(axis);
        turn(spun(axis, sign * angles_[static_cast<std::size_t>(r)]), v);
        v.by_rotary.col(r) += sign * degree * Eigen::Vector3d::Unit(r).cross(v.place);
    }

    Tip ideal_by_all_members(const AxisPosition& q, const Eigen::Vector3d& tool) const noexcept {
        Tip tip = {tool, PositionSlopes::Zero()};
        const auto pass = [&](Axis axis) {
            if (rotary(axis)) {
                const Eigen::Vector3d& point = places_[static_cast<std::size_t>(direction(axis))].point;
                tip.place -= point;
                spin(axis, 1, tip);
                tip.place += point;
            } else {
                tip.place[direction(axis)] += q[coordinate(axis)];
                tip.slopes(direction(axis), coordinate(axis)) += 1;
            }
        };
        for (int i = tool_.size(); i-- > 0;) pass(tool_.axis(i));
        for (int i = 0; i < work_.size(); ++i) pass(work_.axis(i));
        return tip;
    }

    // The place of rotary member k, to the sum of travels: there before it turns, and back as it has turned.
    void add_place(const TiltedBranch& branch, int k, const Errors& errors, Tip& sum) const noexcept {
        const RotaryPlace& its = places_[static_cast<std::size_t>(direction(branch.axis(k)))];
        Tip there = {its.point + its.error, PositionSlopes::Zero()},
            back = {-its.point, PositionSlopes::Zero()};
        turn_to_bed(branch, k, errors, there, Part::before);
        turn_to_bed(branch, k, errors, back, Part::behind);
        const double sign = sign_of(branch);
        for (const Tip& part : {there, back}) {
            sum.place += sign * part.place;
            sum.slopes += sign * part.slopes;
            sum.by_direction += sign * part.by_direction;
            sum.by_rotary += sign * part.by_rotary;
        }
    }

    Tip by_all_members(const AxisPosition& q, const Eigen::Vector3d& tool) const noexcept {
        const Errors errors = errors_at(q);
        Tip sum = {tool, PositionSlopes::Zero()};
        turn_to_bed(tool_, tool_.size(), errors, sum);
        for (const TiltedBranch* branch : {&tool_, &work_}) {
            for (int i = 0; i < branch->size(); ++i) {
                Tip travel = travel_of(branch->axis(i), q, errors);
                turn_to_bed(*branch, i, errors, travel);
                sum.place += travel.place;
                sum.slopes += travel.slopes;
                if (directed_) sum.by_direction += travel.by_direction;
                if (!rotary_) continue;
                sum.by_rotary += travel.by_rotary;
                if (rotary(branch->axis(i))) add_place(*branch, i, errors, sum);
            }
        }
        turn_from_bed(work_, errors, sum);
        return sum;
    }

    static const Error& of(const Errors& errors, Axis axis) noexcept {
        if (rotary(axis)) return (*errors.rotary)[static_cast<std::size_t>(direction(axis))];
        return errors.linear[static_cast<std::size_t>(coordinate(axis))];
    }

    Errors errors_at(const AxisPosition& q) const noexcept {
        Errors result;
        for (std::size_t i = 0; i < 4; ++i)
            take_error(errors_[i], q[static_cast<Eigen::Index>(i)], result.linear[i]);
        if (!rotary_) return result;
        result.rotary.emplace(std::array<Error, 3>{});
        for (std::size_t i = 0; i < 3; ++i) take_error(errors_[i + 4], angles_[i], (*result.rotary)[i]);
        return result;
    }

    void take_error(const Source& source, double position, Error& result) const noexcept {
        if (!source.given) return;
        const RigidBodyError now = source.error.at(position);
        const RigidBodyError& slope = source.error.slope;
        result = {true, now.translation, slope.translation, rotation(now.angles),
                  angular_rate(now.angles, slope.angles)};
        if (!directed_) return;
        result.translation_half = source.error.half.translation;
        result.rotation_half = angular_rate(now.angles, source.error.half.angles);
    }

    // On the work's side too: the tip moves against the work.
    static Tip travel_of(Axis axis, const AxisPosition& q, const Errors& errors) noexcept {
        if (rotary(axis)) {
            Tip travel = {of(errors, axis).translation, PositionSlopes::Zero()};
            travel.by_rotary.col(direction(axis)) = of(errors, axis).translation_slope;
            return travel;
        }
        const Eigen::Vector3d e = Eigen::Vector3d::Unit(direction(axis));
        Tip travel = {q[coordinate(axis)] * e + of(errors, axis).translation, PositionSlopes::Zero()};
        travel.slopes.col(coordinate(axis)) = e + of(errors, axis).translation_slope;
        travel.by_direction.col(coordinate(axis)) = of(errors, axis).translation_half;
        return travel;
    }

    void turn(const Eigen::Matrix3d& rotation, Tip& tip) const noexcept {
        tip.place = (rotation * tip.place).eval();
        tip.slopes = (rotation * tip.slopes).eval();
        if (directed_ || rotary_) turn_rest(rotation, tip);
    }
    void turn_rest(const Eigen::Matrix3d& rotation, Tip& tip) const noexcept {
        if (directed_) tip.by_direction = (rotation * tip.by_direction).eval();
        if (rotary_) tip.by_rotary = (rotation * tip.by_rotary).eval();
    }

    // The part of member k that a vector goes with: the guide that its tilt turns, the members that carry it,
    // or the members that it carries.
    enum class Part { guide, before, behind };

    // A vector that goes with member k, or with the end as k = size: turned as the members before it turn it.
    void turn_to_bed(const TiltedBranch& branch, int k, const Errors& errors, Tip& v,
                     Part part = Part::guide) const noexcept {
        for (int i = part == Part::before ? k - 1 : k; i >= 0; --i) {
            if (i == branch.size()) continue;
            const Error& error = of(errors, branch.axis(i));
            const bool carried = i < k || part == Part::behind;
            if (carried && rotary(branch.axis(i))) spin(branch.axis(i), sign_of(branch), v);
            if (carried && error.given) {
                turn(error.rotation, v);
                change_rotation(branch.axis(i), error, 1, v);
            }
            if (branch.turns(i, k)) turn(branch.tilt(i), v);
        }
    }

    // A vector as the end of the branch sees it.
    void turn_from_bed(const TiltedBranch& branch, const Errors& errors, Tip& v) const noexcept {
        for (int i = 0; i < branch.size(); ++i) {
            if (branch.turns(i, branch.size())) turn(branch.tilt(i).transpose(), v);
            const Axis axis = branch.axis(i);
            const Error& error = of(errors, axis);
            if (error.given) {
                change_rotation(axis, error, -1, v);
                turn(error.rotation.transpose(), v);
            }
            if (rotary(axis)) spin(axis, -sign_of(branch), v);
        }
    }

    // The error of an axis turns a vector, or turns it back with sign -1: this changes the vector's slopes.
    void change_rotation(Axis axis, const Error& error, double sign, Tip& v) const noexcept {
        if (rotary(axis)) {
            v.by_rotary.col(direction(axis)) += sign * error.rotation_slope.cross(v.place);
            return;
        }
        v.slopes.col(coordinate(axis)) += sign * error.rotation_slope.cross(v.place);
        if (directed_) v.by_direction.col(coordinate(axis)) += sign * error.rotation_half.cross(v.place);
    }

    TiltedBranch work_, tool_;
    RotaryPlaces places_;
    std::array<double, 3> angles_{};  // deg, of A, B and C
    std::array<Source, 7> errors_;
    bool linear_ = true, directed_ = false, rotary_ = false;
    PositionSlopes ideal_slopes_ = PositionSlopes::Zero();
    PositionSlopes tilted_slopes_;  // of tilts alone
    Eigen::Matrix3d end_rotation_;  // of the tool as the work sees it, of tilts alone
};

}  // namespace plumb
