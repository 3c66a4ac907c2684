// SPDX-License-Identifier: GPL-2.0-or-later
// The law of an axis, corrected by a bore or surface that is fixed to the machine, and that a probe touches.
//
// probe() once for each touch, step() in each period, take_over() between two parts; corrected() is applied.
// count_from_zero() once for each work zero that is set.
//
// 1. On the cold machine a touch is the reference: growth and law count from there. A work zero contains the
//    error that the law has by then: the touch before it is the new reference, and the correction in force
//    stays as an offset. Without such a touch the law goes on without corrections.
// 2. Warm, the drift M since the reference is compared with the drift L by the law. Two touches that agree
//    within their uncertainty count as one reading, their mean.
// 3. Three explanations compete. The law is right; or it has an error that is another one at each reading; or
//    it is wrong by an offset o that fades and a scale s: M = s L + o. A Kalman filter finds o and s; s moves
//    only where L exceeds least_drift and five uncertainties, within 0.5 to 1.5.
// 4. Each reading changes their probabilities, equal at first, by the likelihoods of its errors. The
//    correction is that of the third explanation times its probability.
// 5. If all touches since the reference, two or more, are worse with the law than without, by more than two
//    sigma of the law, the law of this axis is revoked: the growth counts as that of the reference.
// 6. If two touches do not agree, or nothing explains them, bore or probe have moved: nothing changes.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb::axis_growth {

enum class Probing : std::int32_t {
    none,
    reference,
    no_reference,
    first,
    corrected,
    moved,
    revoked,
    not_now
};

class ProbedReference {
public:
    struct Settings {
        double uncertainty = 0.002;  // mu, of a touch, standard
        double law_sigma = 0.005;    // mu, by which the law is wrong beside its scale
        double least_drift = 0.010;  // mu, of the law, below which the scale stays
        double fading = 7200;        // s, time constant of the offset
    };

    static constexpr double scale_sigma = 0.35, least_scale = 0.5, most_scale = 1.5;

    // `measured`: where the probe touched, with all growth in it; `law`: the growth there by the law, mu.
    Probing probe(double measured, double law, bool cold, const Settings& settings) noexcept {
        if (cold) return refer(measured, law, settings);
        if (!referred_) {
            measured_cold_ = measured;
            first_law_ = law - law_cold_;
            touched_ = true;
            return Probing::no_reference;
        }
        if (revoked_) return Probing::revoked;
        const double drift = measured - measured_cold_, by_law = law - law_cold_;
        const double u = settings.uncertainty * std::sqrt(2.0);  // of the reference, too
        const double left = drift - force_.of(by_law);
        worse_by_ += left * left - drift * drift - 4 * (settings.law_sigma * settings.law_sigma + u * u);
        if (++touches_ >= 2 && worse_by_ > 0) {
            revoked_ = true;
            return Probing::revoked;
        }
        const double change = scale_sigma * (by_law - first_law_);
        const double apart = (drift - first_drift_) - found_.scale * (by_law - first_law_);
        const double mean_drift = (drift + first_drift_) / 2, mean_law = (by_law + first_law_) / 2;
        const bool had_first = first_, agrees = std::abs(apart) <= 2 * std::hypot(u, change);
        first_ = !(had_first && agrees);
        first_drift_ = drift;
        first_law_ = by_law;
        touched_ = !had_first || (agrees && learn(mean_drift, mean_law, settings));
        return !had_first ? Probing::first : touched_ ? Probing::corrected : Probing::moved;
    }

    // A work zero was set, at this growth by the law. The last touch belongs to it if the law has not grown
    // by more than half of least_drift since.
    void count_from_zero(double law, const Settings& settings) noexcept {
        if (revoked_) return;
        const double by_law = law_cold_ + first_law_;
        ProbedReference its;
        if (touched_ && std::abs(law - by_law) <= settings.least_drift / 2)
            its.refer(measured_cold_ + first_drift_, by_law, settings);
        else
            its.law_cold_ = law;
        its.kept_ = corrected(law) - law;
        *this = its;
    }

    // The offset fades, and the law gets another one.
    void step(double dt, const Settings& settings) noexcept {
        if (!referred_) return;
        const double rest = std::exp(-dt / settings.fading);
        found_.offset *= rest;
        covariance_.row(0) *= rest;
        covariance_.col(0) *= rest;
        covariance_(0, 0) += settings.law_sigma * settings.law_sigma * (1 - rest * rest);
    }

    // Between two parts: the correction that is wanted comes in force.
    void take_over() noexcept {
        force_ = wanted();
        force_revoked_ = revoked_;
    }
    void forget() noexcept { *this = ProbedReference(); }

    // Growth to apply for a growth by the law: scale() law + shift().
    double corrected(double law) const noexcept { return of(law, force_, force_revoked_); }
    double scale() const noexcept { return force_revoked_ ? 0 : force_.scale; }
    double shift() const noexcept { return corrected(0); }
    // Standard uncertainty of that growth; `without`: without touches. The explanations that compete add the
    // distance between them, and a change that is not in force adds itself.
    double sigma(double law, double without) const noexcept {
        if (force_revoked_) return without;
        const double by_law = law - law_cold_, p = probability_, apart = found_.of(by_law) - by_law;
        const Eigen::RowVector2d seen(1, by_law);
        const double square = p * (seen * covariance_ * seen.transpose())(0) + (1 - p) * without * without +
                              p * (1 - p) * apart * apart;
        return std::hypot(std::sqrt(square), change(law));
    }
    // By how much take_over() would change it.
    double change(double law) const noexcept { return of(law, wanted(), revoked_) - corrected(law); }
    // Growth by the law since the reference.
    double since(double law) const noexcept { return law - law_cold_; }
    bool revoked() const noexcept { return revoked_; }
    bool referred() const noexcept { return referred_; }

private:
    static constexpr double farthest = 3;           // sigma of a reading that can be explained
    static constexpr double sigmas_of_a_scale = 5;  // uncertainties of a touch
    static constexpr double freedom = 3;            // parts of a growth test that law_sigma comes from

    struct Correction {
        double offset = 0, scale = 1;
        double of(double by_law) const noexcept { return scale * by_law + offset; }
    };

    double of(double law, const Correction& its, bool revoked) const noexcept {
        return kept_ + law_cold_ + (revoked ? 0 : its.of(law - law_cold_));
    }
    Correction wanted() const noexcept {
        return {probability_ * found_.offset, 1 + probability_ * (found_.scale - 1)};
    }

    Probing refer(double measured, double law, const Settings& settings) noexcept {
        measured_cold_ = measured;
        law_cold_ = law;
        found_.offset = first_drift_ = first_law_ = 0;
        covariance_ =
            Eigen::Vector2d(settings.law_sigma * settings.law_sigma, scale_sigma * scale_sigma).asDiagonal();
        referred_ = touched_ = true;
        first_ = false;
        worse_by_ = 0;
        touches_ = 0;
        return Probing::reference;
    }

    // Of an error, by Student's t, as a few parts of a test show law_sigma.
    static double log_likelihood(double error, double variance) noexcept {
        return -(std::log(variance) + (freedom + 1) * std::log1p(error * error / (freedom * variance))) / 2;
    }

    // `drift`: mean of two touches. False if no explanation is plausible.
    bool learn(double drift, double by_law, const Settings& settings) noexcept {
        const double u = settings.uncertainty;
        const double noise = 1.5 * u * u;  // of a mean of two, and of the reference
        const bool scales = std::abs(by_law) > std::max(settings.least_drift, sigmas_of_a_scale * u);
        const Eigen::RowVector2d seen(1, scales ? by_law : 0);
        const double left = drift - found_.of(by_law), by_right_law = drift - by_law;
        const double square = (seen * covariance_ * seen.transpose())(0) + noise;
        const double right_square = settings.law_sigma * settings.law_sigma + noise;
        if (std::min(left * left / square, by_right_law * by_right_law / right_square) > farthest * farthest)
            return false;
        weights_ += Eigen::Array3d(log_likelihood(left, square), log_likelihood(by_right_law, right_square),
                                   log_likelihood(by_right_law, noise));
        weights_ -= weights_.maxCoeff();
        probability_ = std::exp(weights_[0]) / weights_.exp().sum();
        const Eigen::Vector2d gain = covariance_ * seen.transpose() / square;
        found_.offset += gain[0] * left;
        found_.scale = std::clamp(found_.scale + gain[1] * left, least_scale, most_scale);
        covariance_ = (Eigen::Matrix2d::Identity() - gain * seen) * covariance_;
        return true;
    }

    bool touched_ = false;  // the last touch may be a reference
    bool referred_ = false, first_ = false, revoked_ = false, force_revoked_ = false;
    double measured_cold_ = 0, law_cold_ = 0, first_drift_ = 0, first_law_ = 0;
    double kept_ = 0;  // correction that the work zero contains
    // Squares of what the law left since the reference, less those of the drift and of what it may leave
    double worse_by_ = 0;
    int touches_ = 0;  // since the reference
    Correction found_, force_;
    Eigen::Matrix2d covariance_ = Eigen::Matrix2d::Identity();  // of offset and scale
    // Logarithms, of an error that lasts, of another one at each reading, and of none
    Eigen::Array3d weights_ = Eigen::Array3d::Zero();
    double probability_ = 0;  // of an error that lasts
};

}  // namespace plumb::axis_growth
