// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/onset_fit.hpp"
#include "components/math/contact/residual_noise.hpp"
#include "components/math/contact/two_step_fit.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

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
