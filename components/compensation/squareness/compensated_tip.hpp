// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/squareness/squareness_codes.hpp"
#include "components/math/geometry/contour_tip.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

// The tip that is held to the contour of G41 or G42. A radius that G40 or the other side contradicts for a
// while in motion is not used. Looks are counted, not seconds: a program that is late contradicts nothing.
struct CompensatedTip final : hal::Group {
    using Group::Group;

    static constexpr double largest = 1e4;  // mu
    static constexpr int patience = 50;     // looks, 1 s: linuxcnc_link sees the side later than motion does

    hal::In<bool> on_contour{this, "tip-on-contour", false,
                             "Correct the radius of a single-point tip that is turned to the contour; never "
                             "for a rotating cutter."};
    hal::In<double> compensation_radius{
        this, "compensation-radius", 0, "mu",
        "Radius of cutter compensation, positive with G41, negative with G42, 0 with G40."};
    hal::In<double> compensation_plane{this, "compensation-plane", 17, "1",
                                       "Plane of cutter compensation, 17, 18 or 19."};
    hal::In<std::int32_t> compensation_side{
        this, "compensation-side", 2,
        "Side in the program: 1 for G41, -1 for G42, 0 for G40, 2 for unknown."};

    hal::In<bool> compensation_heartbeat{
        this, "compensation-heartbeat", false,
        "Changes each time that compensation-side is read: linuxcnc-link.heartbeat."};

    // The inputs of one period; the velocity of the path is finite, in mu/s.
    void step(const Eigen::Vector3d& velocity, bool coordinated) noexcept {
        const bool wanted = on_contour;
        const double given_radius = compensation_radius, given_plane = compensation_plane;
        const std::int32_t side = compensation_side;
        const bool beat = compensation_heartbeat, looked = beat != beat_;
        beat_ = beat;
        const bool radius_known = std::abs(given_radius) <= largest;
        const bool plane_known = given_radius == 0 || ContourTip::is_plane(given_plane);
        if (radius_known) radius_ = given_radius;
        if (ContourTip::is_plane(given_plane)) plane_ = static_cast<int>(given_plane);
        const double radius = wanted && coordinated ? radius_ : 0;

        const bool contradicted = radius != 0 && side >= -1 && side <= 1 && side != (radius > 0 ? 1 : -1);
        if (!contradicted)
            contradictions_ = 0;
        else if (looked && !velocity.isZero(0))
            contradictions_ = std::min(contradictions_ + 1, patience);
        const bool doubtful = contradictions_ == patience;

        tip_.step(velocity, radius, plane_);
        in_use_ = radius != 0 && !doubtful;
        fault_ = !wanted                          ? Fault::none
                 : !(radius_known && plane_known) ? Fault::contour
                 : doubtful                       ? Fault::side
                                                  : Fault::none;
    }

    bool in_use() const noexcept { return in_use_; }  // in the place of radial-offset
    const Eigen::Vector3d& radial() const noexcept {
        return tip_.vector();
    }  // mu, from the tool's axis to the tip
    Fault fault() const noexcept { return fault_; }

private:
    ContourTip tip_;
    double radius_ = 0;  // mu, the last good one
    int plane_ = 17;     // the last good one
    bool beat_ = false;
    int contradictions_ = 0;  // one after the other, in motion
    bool in_use_ = false;
    Fault fault_ = Fault::none;
};

}  // namespace plumb
