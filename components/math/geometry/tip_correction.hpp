// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/kinematic_chain.hpp"

#include <Eigen/Core>
#include <Eigen/LU>

namespace plumb {

// The correction c of X, Y and Z that brings the tip of a machine to the tip of an ideal one:
//
//     tip(q + c) = ideal tip(q) + displacement of the reference tool
//
// The axis parallel to one of them stays where it is: it is clamped when cutting.
class TipCorrection {
public:
    // The reference tool, in mu, set the origin of the work: its error by the tilts is in there already.
    explicit TipCorrection(const KinematicChain& chain,
                           const Eigen::Vector3d& reference_tool = Eigen::Vector3d::Zero()) noexcept
        : chain_(chain), origin_(chain.tool_displacement(reference_tool)) {}

    KinematicChain& chain() noexcept { return chain_; }

    struct Correction {
        Eigen::Vector3d offset;  // mu, c of X, Y and Z
        PositionSlopes slopes;   // dc/dt = slopes · dq/dt
        Eigen::Vector3d error;   // mu, of the tip without correction
    };

    // A step of Newton from a guess; for tilts it is exact from any guess. With errors of the axes a term
    // of second order in its length remains: repeat the step from its result, with the errors there, until
    // it is short enough.
    Correction at(const AxisPosition& q, const Eigen::Vector3d& tool,
                  const Eigen::Vector3d& guess = Eigen::Vector3d::Zero()) const noexcept {
        const KinematicChain::Tip tip = chain_.tip(corrected(q, guess), tool);
        const Eigen::Matrix3d by_offset = tip.slopes.leftCols<3>();
        const Eigen::Matrix3d inverse = by_offset.inverse();
        const Eigen::Vector3d rest = tip.place - chain_.ideal_tip(q, tool) - origin_;
        return {guess - inverse * rest, inverse * (chain_.ideal_slopes() - tip.slopes),
                rest - by_offset * guess};
    }

    // The position q whose correction leads to this one.
    AxisPosition un_corrected(const AxisPosition& corrected, const Eigen::Vector3d& tool) const noexcept {
        const Eigen::Vector3d place = chain_.tip(corrected, tool).place - origin_;
        AxisPosition q = corrected;
        q.head<3>() += place - chain_.ideal_tip(corrected, tool);
        return q;
    }

    static AxisPosition corrected(AxisPosition q, const Eigen::Vector3d& c) noexcept {
        q.head<3>() += c;
        return q;
    }

private:
    KinematicChain chain_;
    Eigen::Vector3d origin_;
};

}  // namespace plumb
