// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cmath>

namespace plumb {

// How a load rises about its onset in another way than the fitted rise b + P (1 - e), e = exp(-s), at s time
// constants τ after the onset: by the residuals r that the fit has left.
//
//     change of τ   d = -sum(r g') / (P sum(g'^2))          one step of Gauss and Newton
//     kink          (mean of r before the onset - mean of r after it) × width × τ / P
//
// g = s e is the derivative by τ, and g' = g - A - B e the part of it that no other P or onset explains: so a
// change d of τ moves the onset by -B d τ. Coolant or a dip of the load before the onset makes a kink, and
// another filter hardly any.
class OnsetShape {
public:
    // `width`: time constants on either side of the onset that count for the kink.
    void begin(double width) noexcept {
        *this = OnsetShape();
        width_ = width;
    }

    // A residual of weight 0 or 1; e = 0 before the onset.
    void take(double weight, double residual, double s, double e) noexcept {
        if (std::abs(s) < width_) {
            Mean& side = s < 0 ? foot_ : toe_;
            side.n += weight;
            side.sum += weight * residual;
        }
        if (s < 0) return;
        const double g = s * e;
        n_ += weight;
        e_ += weight * e;
        ee_ += weight * e * e;
        g_ += weight * g;
        eg_ += weight * e * g;
        gg_ += weight * g * g;
        r_ += weight * residual;
        re_ += weight * residual * e;
        rg_ += weight * residual * g;
    }

    // B, see above.
    double bend() const noexcept { return (n_ * eg_ - e_ * g_) / determinant(); }
    // sum(g'^2): white noise of variance v in the load gives d a variance of v / (P^2 × this). 0 if unknown.
    double information() const noexcept {
        const double rest = gg_ - level() * g_ - bend() * eg_;
        return rest > 1e-6 * gg_ ? rest : 0;
    }
    double change(double gain) const noexcept {  // as a part of τ
        return -(rg_ - level() * r_ - bend() * re_) / (gain * information());
    }
    double kink(double gain) const noexcept {  // in time constants
        return foot_.n > 0 && toe_.n > 0 ? (foot_.mean() - toe_.mean()) * width_ / gain : 0;
    }

private:
    struct Mean {
        double n = 0, sum = 0;
        double mean() const noexcept { return sum / n; }
    };

    double determinant() const noexcept { return n_ * ee_ - e_ * e_; }
    double level() const noexcept { return (g_ * ee_ - eg_ * e_) / determinant(); }  // A

    double width_ = 1;
    Mean foot_, toe_;
    double n_ = 0, e_ = 0, ee_ = 0, g_ = 0, eg_ = 0, gg_ = 0, r_ = 0, re_ = 0, rg_ = 0;
};

}  // namespace plumb
