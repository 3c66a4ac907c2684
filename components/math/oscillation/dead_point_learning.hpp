// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"
#include "components/math/oscillation/learned_strokes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// Learns how far the commanded ends of a stroke must lie beyond its dead points, so that the axis reaches
// these and does not pass them. Outward is positive at both ends, in mu.
//
// A new stroke begins slow, and inside the dead points by an inset. The speed rises while the overshoot that
// is predicted for it stays within the inset; the overshoot of an axis grows with the square of the speed.
// At full speed each measured error corrects its end by a part, the gain. Strokes that were learned before
// are remembered. After a restart they begin slow, too, and use their learned corrections as far as the
// axis confirms them.
class DeadPointLearning {
public:
    using Stroke = LearnedStrokes::Stroke;
    using Learned = LearnedStrokes::Learned;

    static constexpr double slow = 0.2;  // of the speed, in the beginning

    struct Settings {
        double inset = 0;        // mu, of a stroke that is not learned
        double gain = 0.7;       // above 0, below 1
        double most = 0;         // mu, the largest correction either way
        double tolerance = 0;    // mu, of a learned dead point
        double most_beyond = 0;  // mu, beyond a dead point

        bool operator==(const Settings& other) const noexcept {
            return inset == other.inset && gain == other.gain && most == other.most &&
                   tolerance == other.tolerance && most_beyond == other.most_beyond;
        }
    };

    // Takes up a stroke: one that it has learned with its corrections, any other one from the beginning.
    void select(const Stroke& stroke, const Settings& settings) noexcept {
        settings_ = settings;
        if (stroke == stroke_ && used_) return;
        stroke_ = stroke;
        used_ = true;
        begin();
        const Learned* known = strokes_.find(stroke);
        if (!known || !strokes_.proven(stroke)) return;
        for (std::size_t i = 0; i < 2; ++i) {
            offset_[i] = bounded(known->offset[i], settings.most);
            excess_[i] = -offset_[i];
        }
        excess_speed_ = {stroke.speed, stroke.speed};
        reference_ = known->reversal;
        factor_ = 1;
        drift_ = drift_from(known->first_offset);
    }

    // From the beginning, for the selected stroke: the axis is not the one that learned it.
    void restart() noexcept {
        strokes_.doubt(stroke_);
        begin(true);
    }

    void forget() noexcept {
        strokes_.forget();
        begin();
    }

    const LearnedStrokes& strokes() const noexcept { return strokes_; }

    // Remembers a stroke that was learned before a restart; false if it is impossible.
    bool restore(const Learned& learned) noexcept { return strokes_.restore(learned); }

    // The part of the full speed at which the next stroke may run.
    double speed_factor() const noexcept { return factor_; }

    // Where the end of a stroke lies, with the acceleration of its reversal and its speed. An end beyond the
    // dead point comes back with the acceleration, as the axis then follows closer. One inside goes farther
    // inside with the square of a speed above the full one, as the axis then overshoots more.
    double offset(bool upper, double acceleration, double speed) const noexcept {
        const double its = offset_[upper], faster = speed / stroke_.speed;
        if (its < 0) return faster > 1 ? its * faster * faster : its;
        return acceleration < reference_ ? its * acceleration / reference_ : its;
    }

    // Whether a measured dead point can be that of this axis: the distance from its commanded end is between
    // the last one and that times the square of the speeds, give or take a tenth of the stroke and the inset.
    bool plausible(bool upper, double error, double used, double speed) const noexcept {
        const double faster = excess_speed_[upper] > 0 ? speed / excess_speed_[upper] : 1;
        const double last = excess_[upper], grown = last * faster * faster;
        const double slack = 0.1 * (stroke_.upper - stroke_.lower) + settings_.inset, excess = error - used;
        return excess >= std::min(last, grown) - slack && excess <= std::max(last, grown) + slack;
    }

    // A measured dead point: its error (positive beyond the dead point), the offset that its stroke had, the
    // acceleration of the reversal, and the speed, of strokes at the present speed factor.
    void measured(bool upper, double error, double used, double acceleration, double speed) noexcept {
        error_[upper] = error;
        excess_[upper] = error - used;
        excess_speed_[upper] = speed;
        known_[upper] = true;
        if (factor_ == 1) {
            if (error > settings_.most_beyond) ++beyond_;
            const double gain = error > settings_.most_beyond ? 1 : settings_.gain;
            offset_[upper] = bounded(used - gain * error, settings_.most);
            reference_ = acceleration;
        }
        if (known_[0] && known_[1]) cycle();
    }

    bool learned() const noexcept { return good_ >= 2; }
    int cycles() const noexcept { return cycles_; }  // at full speed
    // Mu, since the stroke was first learned.
    double drift() const noexcept { return drift_; }
    // A correction is at its bound, and the dead point is not reached.
    bool weak() const noexcept {
        const auto at_bound = [&](std::size_t i) {
            return offset_[i] >= settings_.most && error_[i] < -settings_.tolerance;
        };
        return cycles_ > 0 && (at_bound(0) || at_bound(1));
    }
    int beyond() const noexcept { return beyond_; }  // dead points that the axis has passed by too much

private:
    void begin(bool distrusts = false) noexcept {
        distrusts_ = distrusts;
        offset_ = {-settings_.inset, -settings_.inset};
        excess_ = excess_speed_ = {};
        reference_ = 0;
        factor_ = slow;
        known_ = {false, false};
        settling_ = true;
        cycles_ = good_ = beyond_ = 0;
        drift_ = 0;
    }

    void cycle() noexcept {
        known_ = {false, false};
        if (factor_ < 1) {
            if (settling_)
                settling_ = false;
            else
                rise();
            return;
        }
        if (cycles_ < 1000000) ++cycles_;
        const bool within =
            std::abs(error_[0]) <= settings_.tolerance && std::abs(error_[1]) <= settings_.tolerance;
        good_ = within ? std::min(good_ + 1, 2) : 0;
        if (!learned()) return;
        const Learned* known = strokes_.find(stroke_);
        const std::array<double, 2> first = known ? known->first_offset : offset_;
        drift_ = drift_from(first);
        strokes_.remember({stroke_, offset_, first, reference_});
    }

    // The inset takes the growth of the overshoot, with a reserve of 30 %.
    void rise() noexcept {
        const double overshoot = std::max({excess_[0], excess_[1], 0.0}), before = factor_;
        for (std::size_t i = 0; i < 2; ++i)
            offset_[i] = bounded(-settings_.inset - std::max(excess_[i], 0.0), settings_.most);
        const double room = overshoot > 0 ? std::sqrt(1 + settings_.inset / (1.3 * overshoot)) : fastest_rise;
        factor_ = std::min(factor_ * std::min(room, fastest_rise), 1.0);
        if (factor_ > 0.98) factor_ = 1;
        settling_ = true;
        if (factor_ == 1 && !distrusts_) take_up(1 / (before * before));
    }

    // What was learned before a restart, not farther out than the axis at reduced speed predicts, with a
    // reserve of 30 %.
    void take_up(double growth) noexcept {
        const Learned* known = strokes_.find(stroke_);
        if (!known) return;
        for (std::size_t i = 0; i < 2; ++i) {
            const double predicted = growth * excess_[i] * (excess_[i] < 0 ? 0.7 : 1.3);
            offset_[i] = bounded(std::min(known->offset[i], -predicted), settings_.most);
        }
        reference_ = known->reversal;
    }

    double drift_from(const std::array<double, 2>& first) const noexcept {
        return std::max(std::abs(offset_[0] - first[0]), std::abs(offset_[1] - first[1]));
    }

    static constexpr double fastest_rise = 2.5;

    Settings settings_;
    Stroke stroke_;
    LearnedStrokes strokes_;
    bool used_ = false, settling_ = true, distrusts_ = false;
    std::array<double, 2> offset_{}, error_{};
    std::array<double, 2> excess_{}, excess_speed_{};  // of the last dead points: beyond the command; speed
    std::array<bool, 2> known_{};
    double reference_ = 0, factor_ = slow, drift_ = 0;
    int cycles_ = 0, good_ = 0, beyond_ = 0;
};

}  // namespace plumb
