// SPDX-License-Identifier: GPL-2.0-or-later
// A load that rises twice about a contact.
//
// 1. TwoStepSearch tries pairs of moments on a grid, for one time constant or several.
// 2. TwoStepFit improves the best pair by Gauss and Newton.
// 3. EarlierStep compares that with one rise, and reports by how much the contact comes later.
#pragma once

#include "components/compensation/thermal_displacement/onset_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plumb {

// A load that rises twice behind one first-order lag τ: by coolant, or as a dip ends, and then by the
// contact,
//
//     y = b + P1 (1 - exp(-(t - t1) / τ)) + P (1 - exp(-(t - t0) / τ))      each term from its own moment on
//
// P1 < 0 begins a dip.
struct TwoSteps {
    double time_constant = 0;  // s
    double first = 0;          // s from t1 to the newest sample
    double first_gain = 0;     // P1
    double onset = 0;          // s from t0 to the newest sample
    double gain = 0;           // P
    double explained = 0;      // part of the sum of squares about the mean; 0 if there are none

    bool found() const noexcept { return explained > 0; }
};

// Its least squares for a given τ, where t1 and about t0 are nodes, which lie some samples apart. The sums of
// OnsetFit, kept at the nodes, give the fit for each pair of nodes in a few steps.
class TwoStepSearch {
public:
    // Contacts from `earliest` to `latest` count, in s before the newest sample, earliest > latest; so do
    // first steps that come at least `apart` s before.
    void begin(const OnsetFit::Total& total, double spacing, double time_constant, double earliest,
               double latest, double apart) noexcept {
        total_ = total;
        stride_ = std::max(1, static_cast<int>(std::ceil(node_spacing / spacing - 1e-9)));
        between_ = stride_ * spacing;
        time_constant_ = time_constant;
        q_ = std::exp(-spacing / time_constant);
        q_node_ = std::exp(-between_ / time_constant);
        taken_ = nodes_ = 0;
        sums_ = {};
        apart_ = std::max(1, static_cast<int>(std::ceil(apart / between_ - 1e-9)));
        contact_ = std::max(1, static_cast<int>(latest / between_));
        last_contact_ = static_cast<int>(std::ceil(earliest / between_));
        best_ = {};
    }

    // From the newest sample to the oldest, of weight 0 or 1.
    void take(double weight, double y) noexcept {
        sums_ = sums_.before(q_, weight, y);
        if (taken_++ % stride_ == 0 && nodes_ < capacity) node_[nodes_++] = sums_;
    }

    // After the oldest sample: tries one node as the contact, with each node before it as the first step.
    // False when that was the last.
    bool search() noexcept {
        if (contact_ > last_contact_ || contact_ + apart_ + 1 >= nodes_) return false;
        const OnsetSums& s = node_[contact_];
        const double n = total_.n, mean = total_.y / n;
        // Products of u = 1 and v = e, from the contact on, with each other and y about their means.
        const double uu = s.n - s.n * s.n / n, uv = s.e - s.n * s.e / n, vv = s.ee - s.e * s.e / n;
        const double uy = s.y - s.n * mean, vy = s.ey - s.e * mean;
        const double determinant = uu * vv - uv * uv;
        if (determinant > 1e-9 * uu * vv) {
            const double u = (uy * vv - vy * uv) / determinant, v = (vy * uu - uy * uv) / determinant;
            double decay = std::pow(q_node_, apart_);  // of the first step, to the contact
            for (int i = contact_ + apart_; i + 1 < nodes_; ++i, decay *= q_node_) {
                const OnsetSums& f = node_[i];
                const double level = f.n - f.e;
                const double uf = s.n - decay * s.e - level * s.n / n;
                const double vf = s.e - decay * s.ee - level * s.e / n;
                const double ff = f.n - 2 * f.e + f.ee - level * level / n;
                const double along_u = (uf * vv - vf * uv) / determinant;
                const double along_v = (vf * uu - uf * uv) / determinant;
                const double rest = ff - along_u * uf - along_v * vf;
                if (!(rest > 1e-6 * ff)) continue;
                const double first = (f.y - f.ey - level * mean - u * uf - v * vf) / rest;
                const double explained = u * uy + v * vy + first * first * rest;
                const double gain = u - first * along_u, share = -(v - first * along_v) / gain;
                if (!(explained > best_.explained && gain > 0 && share >= q_node_ && share <= 1)) continue;
                best_ = {time_constant_, i * between_,
                         first,          contact_ * between_ - time_constant_ * std::log(share),
                         gain,           explained};
            }
        }
        return ++contact_ <= last_contact_;
    }

    const TwoSteps& best() const noexcept { return best_; }

private:
    static constexpr double node_spacing = 0.005;  // s, or a sample if that is more
    static constexpr int capacity = 128;

    OnsetFit::Total total_;
    double q_ = 0, q_node_ = 0, time_constant_ = 1, between_ = 1;
    int stride_ = 1, taken_ = 0, nodes_ = 0;
    int contact_ = 0, last_contact_ = 0, apart_ = 1;  // in nodes
    OnsetSums sums_;
    std::array<OnsetSums, capacity> node_{};
    TwoSteps best_;
};

// Gauss and Newton from there, with τ free too if asked. Each pass over the samples, from the newest to the
// oldest, is a step.
class TwoStepFit {
public:
    void begin(const TwoSteps& from, bool free) noexcept {
        now_ = best_ = from;
        best_.explained = 0;
        unknowns_ = free ? 5 : 4;
    }

    void begin_pass(double spacing) noexcept {
        const double tau = now_.time_constant;
        spacing_ = spacing;
        growth_ = std::exp(spacing / tau);
        first_ = std::exp(-now_.first / tau);
        onset_ = std::exp(-now_.onset / tau);
        age_ = 0;
        sums_ = {};
    }

    void take(double weight, double y) noexcept {
        if (weight > 0) {
            const double tau = now_.time_constant;
            const double e1 = age_ <= now_.first ? first_ : 1, e = age_ <= now_.onset ? onset_ : 1;
            const double d1 = age_ <= now_.first ? first_ : 0, d = age_ <= now_.onset ? onset_ : 0;
            const double s1 = (now_.first - age_) / tau, s = (now_.onset - age_) / tau;
            // 1, by P1, by t1 / τ, by P, by t0 / τ, by log τ, and the residual with b = 0
            const std::array<double, columns> row{1,
                                                  1 - e1,
                                                  now_.first_gain * d1,
                                                  1 - e,
                                                  now_.gain * d,
                                                  -(now_.first_gain * s1 * d1 + now_.gain * s * d),
                                                  y - now_.first_gain * (1 - e1) - now_.gain * (1 - e)};
            for (int i = 0, k = 0; i < columns; ++i)
                for (int j = 0; j <= i; ++j, ++k) sums_[k] += row[i] * row[j];
        }
        age_ += spacing_;
        first_ *= growth_;
        onset_ *= growth_;
    }

    // After a pass. `all`: sum of squares about the mean. False if there is nothing to gain by another.
    bool end_pass(double all) noexcept {
        const double n = at(0, 0);
        const double explained = all - (at(last, last) - at(last, 0) * at(last, 0) / n);
        if (!(explained > best_.explained)) return false;
        best_ = now_;
        best_.explained = explained;
        baseline_ = at(last, 0) / n;
        std::array<double, columns> step{};
        if (!solve(step)) return false;
        now_.first_gain += step[1];
        now_.first += std::clamp(step[2], -most, most) * now_.time_constant;
        now_.gain += step[3];
        now_.onset += std::clamp(step[4], -most, most) * now_.time_constant;
        now_.time_constant *= std::exp(std::clamp(step[5], -most, most));
        return now_.gain > 0 && now_.first > now_.onset;
    }

    const TwoSteps& best() const noexcept { return best_; }
    double baseline() const noexcept { return baseline_; }

private:
    static constexpr int columns = 7, last = columns - 1;
    static constexpr double most = 0.3;  // of a time constant, in a step

    double at(int i, int j) const noexcept { return sums_[i * (i + 1) / 2 + j]; }

    // The normal equations of the columns but the constant, by Cholesky's method.
    bool solve(std::array<double, columns>& x) const noexcept {
        std::array<std::array<double, columns>, columns> l{};
        const auto centred = [&](int i, int j) { return at(i, j) - at(i, 0) * at(j, 0) / at(0, 0); };
        for (int i = 1; i <= unknowns_; ++i)
            for (int j = 1; j <= i; ++j) {
                double sum = centred(i, j);
                for (int k = 1; k < j; ++k) sum -= l[i][k] * l[j][k];
                if (i > j)
                    l[i][j] = sum / l[j][j];
                else if (sum > 1e-9 * centred(i, i))
                    l[i][i] = std::sqrt(sum);
                else
                    return false;
            }
        for (int i = 1; i <= unknowns_; ++i) {
            double sum = centred(last, i);
            for (int k = 1; k < i; ++k) sum -= l[i][k] * x[k];
            x[i] = sum / l[i][i];
        }
        for (int i = unknowns_; i >= 1; --i) {
            double sum = x[i];
            for (int k = i + 1; k <= unknowns_; ++k) sum -= l[k][i] * x[k];
            x[i] = sum / l[i][i];
        }
        return true;
    }

    TwoSteps now_, best_;
    int unknowns_ = 4;
    double spacing_ = 1, growth_ = 1, first_ = 0, onset_ = 0, age_ = 0, baseline_ = 0;
    std::array<double, columns*(columns + 1) / 2> sums_{};
};

// Whether the load rises twice about a contact: coolant comes on, or a dip ends, right before it. Two steps
// behind one filter must explain the load clearly better than one, and the contact must then lie clearly
// elsewhere. Passes over the samples, from the newest to the oldest, alternate with work between them.
class EarlierStep {
public:
    // The contact as one step explains it: times in s, its onset before the newest sample.
    struct Contact {
        double time_constant = 0;
        bool free = false;  // the time constant was fitted; else the reference has given it
        double onset = 0;
        double gain = 0;
        double explained = 0;  // by it, or by another filter
        double sigma = 0;      // s
        double variance = 0;   // of the noise, as its residuals show it
    };

    // `all`: the sum of the squares of the loads about their mean; `samples`: the number of all samples, of
    // weight 0 or 1; `interval`: s, between two samples of the drive.
    void begin(const Contact& contact, const OnsetFit::Total& total, double all, double spacing, int samples,
               double interval) noexcept {
        contact_ = contact;
        total_ = total;
        all_ = all;
        spacing_ = spacing;
        samples_ = samples;
        apart_ = std::max(nearest, nearest_samples * interval);
        trial_ = 0;
        best_ = {};
        shift_ = 0;
        begin_trial();
    }

    // Of each pass: a sample of weight 0 or 1.
    void take(double weight, double y) noexcept {
        switch (stage_) {
            case Stage::search: search_.take(weight, y); break;
            case Stage::fit: fit_.take(weight, y); break;
            default: take_residual(weight, y);
        }
    }

    // After a pass, once a period while it returns `between`.
    enum class Next { between, pass, end };
    Next work() noexcept {
        if (stage_ == Stage::search) {
            for (double done = 0; done < contacts_per_time * spacing_; ++done)
                if (!search_.search()) return end_trial();
            return Next::between;
        }
        if (stage_ == Stage::fit) {
            if (fit_.end_pass(all_) && ++passes_ < most_passes)
                fit_.begin_pass(spacing_);
            else
                begin_residuals();
            return Next::pass;
        }
        judge();
        return Next::end;
    }

    double shift() const noexcept { return shift_; }  // s by which the contact comes later; 0 if it does not

private:
    // s, and intervals of the drive: a nearer step belongs to the shape of the rise.
    static constexpr double nearest = 0.0175, nearest_samples = 3;
    static constexpr double far = 0.04;                  // s
    static constexpr double before = 0.01, after = 0.2;  // s about the contact: there it may be in truth
    static constexpr int trials = 6;                     // time constants, if it is free
    static constexpr double largest = 1.1, ratio = 1.5;  // of them
    static constexpr double shortest = 0.002;            // s
    static constexpr double contacts_per_time = 2000;    // 1/s: a slow thread has time for more in a period
    static constexpr int most_passes = 5;
    // By simulation: what noise, teeth and clipping make of a healthy rise.
    static constexpr double least_first = 1.0 / 12, least_contact = 1.0 / 3;  // of the other step
    static constexpr double plateau = 2.5;  // time constants between two steps, if the first is larger

    enum class Stage { search, fit, residuals };

    void begin_trial() noexcept {
        const double factor = contact_.free ? largest * std::pow(ratio, -trial_) : 1;
        const double tau = std::max(shortest, factor * contact_.time_constant);
        search_.begin(total_, spacing_, tau, contact_.onset + before, contact_.onset - after, apart_);
        stage_ = Stage::search;
    }

    Next end_trial() noexcept {
        if (search_.best().explained > best_.explained) best_ = search_.best();
        if (contact_.free && ++trial_ < trials) {
            begin_trial();
            return Next::pass;
        }
        if (!best_.found()) return Next::end;
        fit_.begin(best_, contact_.free);
        fit_.begin_pass(spacing_);
        passes_ = 0;
        stage_ = Stage::fit;
        return Next::pass;
    }

    void begin_residuals() noexcept {
        best_ = fit_.best();
        const double tau = best_.time_constant;
        q_ = std::exp(-spacing_ / tau);
        first_ = std::exp(-best_.first / tau);
        onset_ = std::exp(-best_.onset / tau);
        age_ = 0;
        noise_ = {};
        stage_ = Stage::residuals;
    }

    void take_residual(double weight, double y) noexcept {
        const double first = age_ <= best_.first ? best_.first_gain * (1 - first_) : 0;
        const double rise = age_ <= best_.onset ? best_.gain * (1 - onset_) : 0;
        noise_.take(weight, y - fit_.baseline() - first - rise, q_);
        age_ += spacing_;
        first_ /= q_;
        onset_ /= q_;
    }

    void judge() noexcept {
        const double variance =
            noise_.variance(total_.n, unknowns, best_.time_constant / (samples_ * spacing_));
        const double size = std::abs(best_.first_gain), between = best_.first - best_.onset;
        const double sigma =
            contact_.sigma * contact_.gain / best_.gain *
            std::sqrt(variance / contact_.variance * best_.time_constant / contact_.time_constant);
        const double shift = contact_.onset - best_.onset;
        // Standard deviations: by which two steps are better than one, and the contact is elsewhere.
        const double better = std::sqrt(std::max(0.0, best_.explained - contact_.explained) / variance);
        const double away = std::abs(shift) / sigma;
        const bool two = between >= apart_ && best_.gain > least_contact * best_.first_gain &&
                         size > least_first * best_.gain &&
                         (size < best_.gain || between > plateau * best_.time_constant);
        const bool clear = (better > 6 && away > 4) || (better > 10 && away > 2) ||
                           (better > 5 && away > 10 && between > far);
        if (two && clear) shift_ = shift;
    }

    static constexpr int unknowns = 5;

    Contact contact_;
    OnsetFit::Total total_;
    double all_ = 0, spacing_ = 1, apart_ = 0;
    int samples_ = 0, trial_ = 0, passes_ = 0;
    Stage stage_ = Stage::search;
    TwoStepSearch search_;
    TwoStepFit fit_;
    TwoSteps best_;
    double q_ = 0, first_ = 0, onset_ = 0, age_ = 0;
    ResidualNoise noise_;
    double shift_ = 0;
};

}  // namespace plumb
