// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/authority.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/contact/growth_estimator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {

// Why less than the whole growth is applied, or why it may be wrong. DisplacementStatus has the sentences.
enum class Doubt : std::int32_t {
    none,
    load,
    missed,
    old,
    contradiction,
    program_event,
    shift,
    poor_reference,
    prediction,
    uncertain,
    held_back,
    unknown,
    origin,
    shift_by_feed,
};

// The growth that may be applied: that of the last contacts and, as far as it is certain, the change that the
// model adds to it. Only a part of an uncertain growth is applied: see allowed(). In a cycle a loss of
// certainty holds it as it is.
class GrowthAuthority {
public:
    struct Settings {
        double floor = 0.015;      // mu, standard deviation from which a prediction counts for nothing
        double hold = 1800;        // s without a contact that counted
        double tolerance = 0.010;  // mu, of the work: an error to expect beyond it is a doubt
    };

    struct Evidence {
        double held = 0, predicted = 0;     // mu, at the last accepted contact and now
        double sigma = 0, since_sigma = 0;  // mu, of `predicted`, and of its change since that contact
        std::array<GrowthEstimator::Possible, GrowthEstimator::most> possible{};  // growths now
        double apart = 0;            // mu, standard deviation by which a cut differs from the gauges
        double spread = 0;           // mu, of the gate
        double reference_sigma = 0;  // mu
        bool predicts = true;        // the model is asked for
        bool load_valid = true;
        bool barren = false;  // contacts should have come, and none has counted
        bool program_event = false;
        bool compared = true;                     // a contact has come since the reference or the start
        Shift shift = Shift::none;                // that is large enough to matter
        bool origin = false;                      // of the program has changed without a reason
        bool in_cycle = false, accepted = false;  // in this period
    };

    // Once a period of dt > 0, in s, while a growth is known.
    void step(const Evidence& e, const Settings& settings, double dt) noexcept {
        const bool silent = e.barren || !e.load_valid;
        age_ = silent ? age_ + dt : 0;
        const double certain = silent || !e.predicts
                                   ? 0
                                   : Authority::rising(-e.since_sigma, -settings.floor, -settings.floor / 3);
        if (e.accepted) base_ = e.held;
        if (silence_.rises(silent)) base_ = growth_;
        const bool holds = e.in_cycle && !e.accepted && certain < trusted_;
        if (!holds) {
            trusted_ = certain;
            growth_ = base_ + bounded(trusted_ * (e.predicted - base_), e.spread);
        }
        sigma_ = std::hypot(e.sigma, e.apart, silent ? 0 : growth_ - e.predicted);
        const double before = part_;
        const double most = allowed(growth_, e, settings.floor / 3);
        if (!silent) damp(growth_ == 0 ? 0 : std::min(most / std::abs(growth_), 1.0));
        const double wanted =
            std::clamp(played_, 0.0, 1.0) * Authority::rising(-age_, -2 * settings.hold, -settings.hold);
        part_ = e.in_cycle ? std::max(part_, wanted) : wanted;
        if (!holds || part_ > before) offset_ = part_ * growth_;
        judge(e, certain, settings);
    }

    // A correction c does more harm than h where the growth is below (c - h) / 2. For none of the growths
    // that are possible, g with a standard deviation and a weight, shall that be more frequent than one cut
    // in 700, which is three standard deviations for the only one, and fewer for a less likely one. Up to h
    // no harm is noticeable; there the growth must be larger than its own uncertainty. Returns the largest c.
    static double allowed(double growth, const Evidence& e, double harmless) noexcept {
        constexpr double rare = 3;  // standard deviations
        double most = std::numeric_limits<double>::infinity(), least = 0;
        for (const GrowthEstimator::Possible& its : e.possible) {
            if (!(its.weight > 0)) continue;
            const double likely = rare * rare + 2 * std::log(its.weight);
            const double g = its.growth * (growth < 0 ? -1 : 1);
            const double sigma = std::hypot(its.sigma, e.apart);
            if (!std::isfinite(g) || !(sigma <= 1e6)) return 0;
            if (likely > 0) most = std::min(most, harmless + 2 * (g - std::sqrt(likely) * sigma));
            least += its.weight * harmless * Authority::rising(g / sigma, 1, 2);
        }
        return std::isfinite(most) ? std::max(most, least) : 0;
    }

    double offset() const noexcept { return offset_; }  // mu, to be applied
    double part() const noexcept { return part_; }      // of the growth
    double age() const noexcept { return age_; }        // s without a contact that counted
    Doubt doubt() const noexcept { return doubt_; }

    void forget() noexcept { *this = GrowthAuthority(); }

private:
    void judge(const Evidence& e, double certain, const Settings& settings) noexcept {
        const double unapplied = std::abs(growth_ - offset_);
        const double expected = std::hypot(sigma_, unapplied);
        doubtful_ = expected > (doubtful_ ? 0.8 : 1) * settings.tolerance;
        doubt_ = !e.load_valid                                          ? Doubt::load
                 : age_ > settings.hold                                 ? Doubt::old
                 : e.origin                                             ? Doubt::origin
                 : e.shift == Shift::one_tool                           ? Doubt::contradiction
                 : e.shift == Shift::all || e.shift == Shift::only_tool ? Doubt::shift
                 : e.shift == Shift::by_feed                            ? Doubt::shift_by_feed
                 : e.program_event                                      ? Doubt::program_event
                 : e.barren                                             ? Doubt::missed
                 : !doubtful_                                           ? Doubt::none
                 : !e.compared                                          ? Doubt::unknown
                 : unapplied > 0.5 * expected                           ? Doubt::held_back
                 : e.reference_sigma > 0.7 * expected                   ? Doubt::poor_reference
                 : e.predicts && certain < 0.5                          ? Doubt::prediction
                                                                        : Doubt::uncertain;
    }

    // Noise of the certainty does not move the offset to and fro.
    void damp(double part) noexcept {
        constexpr double play = 0.05;
        const double wide = (1 + 2 * play) * part - play;
        played_ = std::clamp(played_, wide - play, wide + play);
    }

    double part_ = 0, played_ = 0;
    double base_ = 0, growth_ = 0, sigma_ = 0, offset_ = 0;
    double trusted_ = 0, age_ = 0;
    Edge silence_;
    bool doubtful_ = false;
    Doubt doubt_ = Doubt::none;
};

}  // namespace plumb
