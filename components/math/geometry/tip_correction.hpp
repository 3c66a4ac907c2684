// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/kinematic_chain.hpp"

#include <Eigen/Core>
#include <Eigen/LU>

#include <cmath>

namespace plumb {

// The vector T_D from the axis of a tool to its tip on the contour, under cutter radius compensation:
//
//     T_D = radius · (v_b, -v_a) / |v|      v: velocity along the first and second axis, a and b, of the
//     plane
//
// The path of the axis runs beside the contour, so the tip lies square to the path. radius is above 0 with
// G41, where the tool is left of the contour, and below 0 with G42. The axes of the planes are X and Y (G17),
// Z and X (G18), Y and Z (G19).
//
// At rest, and in motion across the plane, the last direction stays. There is none before the first motion,
// and after a radius of 0 or in another plane the next motion gives it.
class ContourTip {
public:
    static bool is_plane(double number) noexcept { return number == 17 || number == 18 || number == 19; }

    // velocity finite, in mu/s; radius finite, in mu; plane 17, 18 or 19.
    void step(const Eigen::Vector3d& velocity, double radius, int plane) noexcept {
        const int a = plane == 17 ? 0 : plane == 18 ? 2 : 1, b = (a + 1) % 3;
        if (radius == 0 || plane != plane_) right_.setZero();
        plane_ = plane;
        const double speed = std::hypot(velocity[a], velocity[b]);
        if (radius != 0 && speed > still) {
            right_.setZero();
            right_[a] = velocity[b] / speed;
            right_[b] = -velocity[a] / speed;
        }
        vector_ = radius * right_;
    }

    const Eigen::Vector3d& vector() const noexcept { return vector_; }  // mu

private:
    static constexpr double still = 1e-6;  // mu/s; below it rounding would give the direction

    int plane_ = 17;
    Eigen::Vector3d right_ = Eigen::Vector3d::Zero(), vector_ = Eigen::Vector3d::Zero();
};

// The correction c of X, Y and Z that brings the tip of a machine to the tip of an ideal one:
//
//     tip(q + c) = ideal tip(q) + displacement of the reference tool
//
// The axis parallel to one of them stays where it is, as if clamped. Or it takes its share: what its own tilt
// and errors take from its travel,
//
//     travel(w + share) = w      in its own direction
//
// and c makes up for the rest. The share depends on w alone: an axis that stands is not moved.
class TipCorrection {
public:
    // The reference tool, in mu, set the origin of the work: its error by the tilts is in there already.
    explicit TipCorrection(const KinematicChain& chain,
                           const Eigen::Vector3d& reference_tool = Eigen::Vector3d::Zero()) noexcept
        : chain_(chain), origin_(chain.tool_displacement(reference_tool)) {}

    explicit TipCorrection(const KinematicChain::Settings& settings,
                           const Eigen::Vector3d& reference_tool = Eigen::Vector3d::Zero()) noexcept
        : chain_(settings), origin_(chain_.tool_displacement(reference_tool)) {}

    KinematicChain& chain() noexcept { return chain_; }
    const KinematicChain& chain() const noexcept { return chain_; }

    struct Share {
        double offset;            // mu
        double slope;             // its change with w
        double by_direction = 0;  // its change with the direction of motion, mu
    };

    // A step of Newton from a guess: exact for a tilt alone.
    Share share(Axis axis, const AxisPosition& q, double guess = 0) const noexcept {
        const double w = q[coordinate(axis)];
        const KinematicChain::Travel travel = chain_.own_travel(axis, w + guess);
        return {guess - (travel.distance - w) / travel.slope, 1 / travel.slope - 1,
                -travel.by_direction / travel.slope};
    }

    struct Correction {
        Eigen::Vector3d offset;                                // mu, c of X, Y and Z
        PositionSlopes slopes;                                 // dc/dt = slopes · dq/dt
        Eigen::Vector3d error;                                 // mu, of the tip without correction
        PositionSlopes by_direction = PositionSlopes::Zero();  // mu, dc/dd of the directions of motion d
        RotarySlopes by_rotary = RotarySlopes::Zero();         // mu/deg, of A, B and C
        PositionSlopes error_slopes = PositionSlopes::Zero();  // of the tip, at q + c, without a correction
        RotarySlopes error_by_rotary = RotarySlopes::Zero();   // mu/deg
    };

    // A step of Newton from a guess; for tilts it is exact from any guess. With errors of the axes a term
    // of second order in its length remains: repeat the step from its result, with the errors there, until
    // it is short enough.
    Correction at(const AxisPosition& q, const Eigen::Vector3d& tool,
                  const Eigen::Vector3d& guess = Eigen::Vector3d::Zero(),
                  const Share& share = {0, 0, 0}) const noexcept {
        KinematicChain::Tip tip = chain_.tip(corrected(q, guess, share.offset), tool);
        const Eigen::Matrix3d by_offset = tip.slopes.leftCols<3>();
        const Eigen::Matrix3d inverse = by_offset.inverse();
        const KinematicChain::Tip ideal = chain_.ideal(q, tool);
        const Eigen::Vector3d rest = tip.place - ideal.place - origin_;
        const Eigen::Vector3d error = rest - by_offset * guess - tip.slopes.col(3) * share.offset;
        if (chain_.directed()) tip.by_direction.col(3) += tip.slopes.col(3) * share.by_direction;
        tip.slopes.col(3) *= 1 + share.slope;
        Correction c{guess - inverse * rest, inverse * (ideal.slopes - tip.slopes), error};
        if (chain_.directed()) c.by_direction = -inverse * tip.by_direction;
        if (chain_.has_rotary()) {
            c.by_rotary = inverse * (ideal.by_rotary - tip.by_rotary);
            c.error_slopes = tip.slopes - ideal.slopes;
            c.error_by_rotary = tip.by_rotary - ideal.by_rotary;
        }
        return c;
    }

    // The position q whose correction leads to this one.
    AxisPosition un_corrected(const AxisPosition& corrected, const Eigen::Vector3d& tool) const noexcept {
        const Eigen::Vector3d place = chain_.tip(corrected, tool).place - origin_;
        AxisPosition q = corrected;
        const KinematicChain::Tip ideal = chain_.ideal(corrected, tool);
        if (!chain_.has_rotary())
            q.head<3>() += place - ideal.place;
        else
            q.head<3>() += ideal.slopes.leftCols<3>().inverse() * (place - ideal.place);
        return q;
    }

    static AxisPosition corrected(AxisPosition q, const Eigen::Vector3d& c, double share = 0) noexcept {
        q.head<3>() += c;
        q[3] += share;
        return q;
    }

private:
    KinematicChain chain_;
    Eigen::Vector3d origin_;
};

}  // namespace plumb
