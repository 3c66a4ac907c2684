// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/rigid_body_error.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>

namespace plumb {

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

}  // namespace plumb
