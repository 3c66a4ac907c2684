// SPDX-License-Identifier: GPL-2.0-or-later
// A box, square to the work's axes and true, with a bore through it along Z, for a touch probe.
#pragma once

#include "components/math/blocks/usable.hpp"
#include "hal/component.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace plumb {

class BoxArtifact final : public hal::Group {
public:
    using Group::Group;

    // Call it every period with the position of the tip in the work.
    void meet(const Eigen::Vector3d& tip) noexcept {
        Eigen::Vector3d size(width_, depth_, height_), inside;  // how far from each face, from the middle
        for (int i = 0; i < 3; ++i) {
            middle_[i] = usable(place_[i], 1e5, lowest_[i]);
            lowest_[i] = middle_[i];
            size[i] = last_size_[i] = usable(size[i], 1e5, last_size_[i]);
            middle_[i] += size[i] / 2;
            inside[i] = size[i] / 2 - std::abs(tip[i] - middle_[i]);
        }
        bore_diameter_ = usable(bore_, 1e5, bore_diameter_);
        radius_ = usable(ball_, 1e3, radius_);
        double gap = none;
        if (size.minCoeff() > 0) {
            gap = distance(inside, std::hypot(tip.x() - middle_.x(), tip.y() - middle_.y())) - radius_;
        }
        gap_ = gap;
        tripped_ = gap <= 0;
    }

private:
    static constexpr double none = 1e5;

    // From the surface; negative inside.
    double distance(const Eigen::Vector3d& inside, double from_axis) const noexcept {
        const double into_wall = from_axis - bore_diameter_ / 2;  // negative in the bore
        if (bore_diameter_ > 0 && into_wall < 0) return std::hypot(into_wall, std::min(inside.z(), 0.0));
        if (inside.minCoeff() < 0) return inside.cwiseMin(0.0).norm();
        return -std::min(inside.minCoeff(), bore_diameter_ > 0 ? into_wall : inside.minCoeff());
    }

    const hal::Axes<hal::In<double>, 3> place_{this, "artifact-%", 0, "mu",
                                               "Lowest % of the artifact, in the work."};
    const hal::In<double> width_{this, "artifact-width", 0, "mu",
                                 "Size of the artifact along X; 0 for no artifact."};
    const hal::In<double> depth_{this, "artifact-depth", 0, "mu",
                                 "Size of the artifact along Y; 0 for no artifact."};
    const hal::In<double> height_{this, "artifact-height", 0, "mu",
                                  "Size of the artifact along Z; 0 for no artifact."};
    const hal::In<double> bore_{this, "artifact-bore", 0, "mu",
                                "Diameter of the bore through its middle, along Z; 0 for none."};
    const hal::In<double> ball_{this, "ball-radius", 1.5, "mu",
                                "Radius of the probe's ball, its centre in the tip."};
    hal::Out<bool> tripped_{this, "probe-tripped",
                            "The ball of the probe is in the artifact, or touches it."};
    hal::Out<double> gap_{this, "truth-probe-gap", "mu",
                          "Gap between ball and artifact; negative inside, and none means 100000."};
    Eigen::Vector3d lowest_ = Eigen::Vector3d::Zero(), last_size_ = lowest_, middle_ = lowest_;
    double bore_diameter_ = 0, radius_ = 1.5;
};

}  // namespace plumb
