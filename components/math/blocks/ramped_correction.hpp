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
template <int N>
class RampedCorrectionOf {
public:
    using Vector = Eigen::Matrix<double, N, 1>;

    struct Wanted {
        Vector offset = Vector::Zero();    // mu, of each axis
        Vector velocity = Vector::Zero();  // mu/s, its change by motion
        double most = 0;                   // mu, of each component, either way
    };

    // Motion alone has changed the wanted offset. All values are finite, dt above 0.
    void step(const Wanted& now, double max_rate, double dt) noexcept { step(now, now, max_rate, dt); }

    // Another cause has changed it too, from `before` to `now`.
    void step(const Wanted& now, const Wanted& before, double max_rate, double dt) noexcept {
        const Vector f = within(now.offset, now.most);
        const Vector r = rest_ + within(before.offset, before.most) - f;
        const double length = r.norm(), way = std::max(max_rate, 0.0) * dt;
        rest_ = length > way ? Vector(r - r * (way / length)) : Vector::Zero();
        velocity_ = (rest_ - r) / dt;
        limited_ = f != now.offset;
        for (Eigen::Index i = 0; i < N; ++i) {
            if (f[i] == now.offset[i]) velocity_[i] += now.velocity[i];
            const double most = std::max(now.most, std::abs(offset_[i]));
            offset_[i] = bounded(f[i] + rest_[i], most);
            if (offset_[i] == f[i] + rest_[i]) continue;
            rest_[i] = offset_[i] - f[i];
            velocity_[i] = 0;
            limited_ = true;
        }
    }

    const Vector& offset() const noexcept { return offset_; }      // mu
    const Vector& velocity() const noexcept { return velocity_; }  // mu/s
    bool ramping() const noexcept { return !rest_.isZero(0); }
    bool limited() const noexcept { return limited_; }  // `most` keeps it from the wanted offset

private:
    static Vector within(const Vector& offset, double most) noexcept {
        return offset.unaryExpr([most](double x) { return bounded(x, most); });
    }

    Vector offset_ = Vector::Zero(), velocity_ = Vector::Zero();
    Vector rest_ = Vector::Zero();
    bool limited_ = false;
};

using RampedCorrection = RampedCorrectionOf<3>;  // of X, Y and Z

}  // namespace plumb
