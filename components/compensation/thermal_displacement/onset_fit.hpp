// SPDX-License-Identifier: GPL-2.0-or-later
// One rise of a load, fitted to evenly spaced samples, from the newest to the oldest.
//
// 1. OnsetFit finds the moment of the rise, for a given time constant.
// 2. ResidualNoise, CutRipple and OnsetShape take what that fit has left: how much of it is noise, how much
//    comes from the teeth, and whether another time constant or a kink explains the rest.
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// Sums over the samples from one on, with e = exp(-(t - that sample's t) / τ), weights and loads.
struct OnsetSums {
    double n = 0, e = 0, ee = 0, y = 0, ey = 0;

    // From the sample before it on; q = exp(-spacing / τ).
    OnsetSums before(double q, double weight, double load) const noexcept {
        return {n + weight, q * e + weight, q * q * ee + weight, y + weight * load, q * ey + weight * load};
    }
};

// Least squares of a load that rises behind a first-order lag τ from a moment t0 on,
//
//     y = b                                t < t0
//     y = b + P (1 - exp(-(t - t0) / τ))   t ≥ t0
//
// for a given τ, with b, P and t0 free, over evenly spaced samples of weight 0 or 1. They are taken from the
// newest to the oldest: then the sums for an onset at each sample follow from those for the sample after it.
// Between two samples the model is linear in b, P and P exp(t0 / τ), and the best onset has a closed form.
class OnsetFit {
public:
    // Sums over all samples that will be taken.
    struct Total {
        double n = 0;  // weights
        double y = 0;
        double yy = 0;
    };

    void begin(const Total& total, double spacing, double time_constant) noexcept {
        *this = OnsetFit();
        total_ = total;
        q_ = std::exp(-spacing / time_constant);
    }

    void take(double weight, double y) noexcept {
        const OnsetSums later = sums_;
        sums_ = later.before(q_, weight, y);
        propose(sums_, 1, taken_++);
        if (first_ == taken_ - 1) later_ = later;
    }

    // After the oldest sample: the onset may lie on either side of the best sample.
    void finish() noexcept {
        const OnsetSums best = best_;
        const int first = first_;
        propose(best, best_share(best), first);
        propose(later_, best_share(later_), first - 1);
        const Rise r = rise(best_, c_);
        gain_ = r.fy / r.ff;
        baseline_ = (total_.y - gain_ * r.f) / total_.n;
        const double e = c_ * best_.e, ee = c_ * c_ * best_.ee;
        const double fe = e - ee - r.f * e / total_.n;
        information_ = ee - e * e / total_.n - fe * fe / r.ff;
    }

    double q() const noexcept { return q_; }                  // exp(-spacing / τ)
    double explained() const noexcept { return explained_; }  // part of the sum of squares about the mean

    // Valid after finish(), if found: there is a rise, before which and after which there are samples.
    bool found() const noexcept { return gain_ > 0 && information_ > 0 && std::isfinite(baseline_); }
    int first() const noexcept { return first_; }  // number of samples newer than the first after the onset
    double share() const noexcept { return c_; }   // exp(-(time from the onset to that sample) / τ)
    double gain() const noexcept { return gain_; }
    double baseline() const noexcept { return baseline_; }
    // White noise of variance s² in y gives the onset the variance s² (τ / P)² / information.
    double information() const noexcept { return information_; }

private:
    // Sums of f = 1 - c e, and of its products with itself and y about their means.
    struct Rise {
        double f, ff, fy;
    };

    Rise rise(const OnsetSums& s, double c) const noexcept {
        const double f = s.n - c * s.e;
        return {f, s.n - 2 * c * s.e + c * c * s.ee - f * f / total_.n,
                s.y - c * s.ey - f * total_.y / total_.n};
    }

    void propose(const OnsetSums& s, double c, int first) noexcept {
        if (!(c >= q_ && c <= 1)) return;
        const Rise r = rise(s, c);
        if (!(r.fy * r.fy > explained_ * r.ff && r.fy > 0 && r.ff > 0)) return;
        explained_ = r.fy * r.fy / r.ff;
        best_ = s;
        c_ = c;
        first_ = first;
    }

    // The c that explains most, even outside 0 to 1.
    double best_share(const OnsetSums& s) const noexcept {
        const double mean = total_.y / total_.n;
        const double y = s.y - s.n * mean, ey = s.ey - s.e * mean;
        const double oo = s.n - s.n * s.n / total_.n, oe = s.e - s.n * s.e / total_.n,
                     ee = s.ee - s.e * s.e / total_.n;
        return (ey * oo - y * oe) / (ey * oe - y * ee);
    }

    Total total_;
    double q_ = 0;
    int taken_ = 0;
    OnsetSums sums_;          // from the sample that was taken last on
    OnsetSums best_, later_;  // from the best one on, and from the one after it
    double explained_ = 0;
    double c_ = 1;
    int first_ = -1;
    double gain_ = 0, baseline_ = 0, information_ = 0;
};

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

// The noise in a load, by the residuals of a fit: squares of them as they are, and summed up through the
// exponential by which noise shifts an onset; and the same sums for white noise of variance 1.
class ResidualNoise {
public:
    // From the newest sample to the oldest, of weight 0 or 1; q = exp(-spacing / τ).
    void take(double weight, double residual, double q) noexcept {
        sum_ = weight * residual + q * sum_;
        white_ = weight + q * q * white_;
        squares_ += weight * residual * residual;
        sum_squares_ += weight * sum_ * sum_;
        white_sum_ += weight * white_;
    }

    // Variance of the white noise that would shift the onset as much as this noise. The fit has taken part
    // of the slow noise out of the residuals: the more, the fewer time constants there are. Simulations of
    // white noise and of 1/f noise gave the two factors. `n`: the sum of the weights; `length`: the time
    // constant as a part of the record.
    double variance(double n, int unknowns, double length) const noexcept {
        const double white_lost = 1 + 8 * length, slow_lost = 1 + 19 * length;
        const double white = squares_ / std::max(n - unknowns, 1.0);
        const double seen = white_lost * sum_squares_ / white_sum_;
        return white + std::max(seen - white, 0.0) * slow_lost / white_lost;
    }

private:
    double squares_ = 0, sum_ = 0, sum_squares_ = 0, white_ = 0, white_sum_ = 0;
};

// The load of the teeth. It begins with the contact, at any phase, and shifts the onset by its integral up to
// there. Behind the filter τ the teeth leave the residuals y = load - fit, so with u = y + τ y' before it
//
//     variance of the onset = (τ² variance(y) + variance(∫ y dt)) / P²
//
// of which as much is noise as there is before the contact.
class CutRipple {
public:
    // From the newest sample to the oldest.
    void take(double residual, bool in_cut) noexcept { (in_cut ? cut_ : idle_).take(residual); }

    // Standard deviation of the onset, in s % of load: for a time constant and samples every `interval` s.
    double shift(double time_constant, double interval) const noexcept {
        if (cut_.n < 4 || idle_.n < 4) return 0;
        const double chance = std::sqrt(2 / cut_.n + 2 / idle_.n), slow = 3 * cut_.n / idle_.n;
        const double level2 = cut_.variance() - (1 + chance) * idle_.variance();
        const double path2 = cut_.path_variance() - slow * idle_.path_variance();
        return std::hypot(time_constant * std::sqrt(std::max(level2, 0.0)),
                          interval * std::sqrt(std::max(path2, 0.0)));
    }

private:
    struct Sums {
        double n = 0, yy = 0, path = 0, paths = 0, path2 = 0, n_path = 0;

        void take(double residual) noexcept {
            ++n;
            yy += residual * residual;
            path += residual;
            paths += path;
            path2 += path * path;
            n_path += n * path;
        }
        double variance() const noexcept { return (yy - path * path / n) / (n - 1); }
        double path_variance() const noexcept {  // about a straight line
            const double slope = n_path - 0.5 * (n + 1) * paths;
            return (path2 - paths * paths / n - slope * slope * 12 / (n * (n * n - 1))) / n;
        }
    };

    Sums cut_, idle_;
};

}  // namespace plumb
