// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace plumb {

// A correction that follows motion at once, and all other changes at a limited rate:
//
//     y = f + r      f: the offset wanted at this position by the present settings, within ±most
//     r += f before the change - f after it,   at one and the same position: nothing steps
//     r -> 0         at most at max-rate, as a vector
//
// The output stays within ±most, except while it returns at max-rate after `most` was reduced.
class RampedCorrection {
public:
    struct Wanted {
        Eigen::Vector3d offset = Eigen::Vector3d::Zero();    // mu, of X, Y and Z
        Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // mu/s, its change by motion
        double most = 0;                                     // mu, of each component, either way
    };

    // Motion alone has changed the wanted offset. All values are finite, dt above 0.
    void step(const Wanted& now, double max_rate, double dt) noexcept { step(now, now, max_rate, dt); }

    // Another cause has changed it too, from `before` to `now`.
    void step(const Wanted& now, const Wanted& before, double max_rate, double dt) noexcept {
        const Eigen::Vector3d f = within(now.offset, now.most);
        const Eigen::Vector3d r = rest_ + within(before.offset, before.most) - f;
        const double length = r.norm(), way = std::max(max_rate, 0.0) * dt;
        rest_ = length > way ? Eigen::Vector3d(r - r * (way / length)) : Eigen::Vector3d::Zero();
        velocity_ = (rest_ - r) / dt;
        limited_ = f != now.offset;
        for (Eigen::Index i = 0; i < 3; ++i) {
            if (f[i] == now.offset[i]) velocity_[i] += now.velocity[i];
            const double most = std::max(now.most, std::abs(offset_[i]));
            offset_[i] = bounded(f[i] + rest_[i], most);
            if (offset_[i] == f[i] + rest_[i]) continue;
            rest_[i] = offset_[i] - f[i];
            velocity_[i] = 0;
            limited_ = true;
        }
    }

    const Eigen::Vector3d& offset() const noexcept { return offset_; }      // mu
    const Eigen::Vector3d& velocity() const noexcept { return velocity_; }  // mu/s
    bool ramping() const noexcept { return !rest_.isZero(0); }
    bool limited() const noexcept { return limited_; }  // `most` keeps it from the wanted offset

private:
    static Eigen::Vector3d within(const Eigen::Vector3d& offset, double most) noexcept {
        return offset.unaryExpr([most](double x) { return bounded(x, most); });
    }

    Eigen::Vector3d offset_ = Eigen::Vector3d::Zero(), velocity_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d rest_ = Eigen::Vector3d::Zero();
    bool limited_ = false;
};

}  // namespace plumb
