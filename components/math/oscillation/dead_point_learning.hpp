// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"

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
// are remembered.
class DeadPointLearning {
public:
    static constexpr double slow = 0.2;  // of the speed, in the beginning

    struct Settings {
        double inset = 0;        // mu, of a stroke that is not learned
        double gain = 0.7;       // above 0, below 1
        double most = 0;         // mu, the largest correction either way
        double tolerance = 0;    // mu, of a learned dead point
        double most_beyond = 0;  // mu, beyond a dead point
    };

    // What a correction holds for.
    struct Stroke {
        double lower = 0, upper = 0, speed = 0, acceleration = 0;
        int sections = 0;  // a number that changes with them, and with dwells

        bool operator==(const Stroke& other) const noexcept {
            return lower == other.lower && upper == other.upper && speed == other.speed &&
                   acceleration == other.acceleration && sections == other.sections;
        }
    };

    // What was learned for a stroke. Offsets are outward: lower, upper.
    struct Learned {
        Stroke stroke;
        std::array<double, 2> offset{}, first_offset{};  // mu, now, and when it was first learned
        double reversal = 0;                             // mu/s2, the acceleration at the dead points

        // False for NaN too.
        bool valid() const noexcept {
            const auto within = [](double x, double most) { return std::abs(x) <= most; };
            return within(stroke.lower, 1e6) && within(stroke.upper, 1e6) && stroke.lower < stroke.upper &&
                   stroke.speed > 0 && within(stroke.speed, 1e6) && stroke.acceleration > 0 &&
                   within(stroke.acceleration, 1e9) && within(offset[0], 1e3) && within(offset[1], 1e3) &&
                   within(first_offset[0], 1e3) && within(first_offset[1], 1e3) && reversal > 0 &&
                   within(reversal, 1e9);
        }
    };

    static constexpr int most_strokes = 8;  // that are remembered

    // Takes up a stroke: one that it remembers with its corrections, any other one from the beginning.
    void select(const Stroke& stroke, const Settings& settings) noexcept {
        settings_ = settings;
        if (stroke == stroke_ && used_) return;
        stroke_ = stroke;
        used_ = true;
        restart();
        const int place = place_of(stroke);
        if (place == count_) return;
        const Learned& known = strokes_[static_cast<std::size_t>(place)];
        offset_ = {bounded(known.offset[0], settings.most), bounded(known.offset[1], settings.most)};
        first_offset_ = known.first_offset;
        reference_ = known.reversal;
        has_first_ = true;
        factor_ = 1;
    }

    // From the beginning, for the selected stroke.
    void restart() noexcept {
        offset_ = {-settings_.inset, -settings_.inset};
        reference_ = 0;
        factor_ = slow;
        known_ = {false, false};
        settling_ = true;
        cycles_ = good_ = beyond_ = 0;
        has_first_ = false;
    }

    void forget() noexcept {
        count_ = oldest_ = 0;
        restart();
    }

    // What is remembered; 0 <= i < size().
    int size() const noexcept { return count_; }
    const Learned& operator[](int i) const noexcept { return strokes_[static_cast<std::size_t>(i)]; }

    // Remembers a stroke that was learned before; false if it is impossible. It is not that in progress.
    bool restore(const Learned& learned) noexcept {
        if (!learned.valid() || place_of(learned.stroke) != count_ || count_ == most_strokes) return false;
        strokes_[static_cast<std::size_t>(count_++)] = learned;
        return true;
    }

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

    // A measured dead point: its error (positive beyond the dead point), the offset that its stroke had, and
    // the acceleration of the reversal, of strokes at the present speed factor.
    void measured(bool upper, double error, double used, double acceleration) noexcept {
        error_[upper] = error;
        excess_[upper] = error - used;
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
    double drift() const noexcept {
        return has_first_ ? std::max(std::abs(offset_[0] - first_offset_[0]),
                                     std::abs(offset_[1] - first_offset_[1]))
                          : 0;
    }
    // A correction is at its bound, and the dead point is not reached.
    bool weak() const noexcept {
        const auto at_bound = [&](std::size_t i) {
            return offset_[i] >= settings_.most && error_[i] < -settings_.tolerance;
        };
        return cycles_ > 0 && (at_bound(0) || at_bound(1));
    }
    int beyond() const noexcept { return beyond_; }  // dead points that the axis has passed by too much

private:
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
        const int place = place_of(stroke_);
        if (!has_first_) first_offset_ = place < count_ ? (*this)[place].first_offset : offset_;
        has_first_ = true;
        remember();
    }

    // The inset takes the growth of the overshoot, with a reserve of 30 %.
    void rise() noexcept {
        const double overshoot = std::max({excess_[0], excess_[1], 0.0});
        for (std::size_t i = 0; i < 2; ++i)
            offset_[i] = bounded(-settings_.inset - std::max(excess_[i], 0.0), settings_.most);
        const double room = overshoot > 0 ? std::sqrt(1 + settings_.inset / (1.3 * overshoot)) : fastest_rise;
        factor_ = std::min(factor_ * std::min(room, fastest_rise), 1.0);
        if (factor_ > 0.98) factor_ = 1;
        settling_ = true;
    }

    // Of a stroke that is not remembered, size().
    int place_of(const Stroke& stroke) const noexcept {
        int i = 0;
        while (i < count_ && !((*this)[i].stroke == stroke)) ++i;
        return i;
    }

    // In the place of the oldest one where all are taken.
    void remember() noexcept {
        int place = place_of(stroke_);
        if (place == most_strokes) {
            place = oldest_;
            oldest_ = (oldest_ + 1) % most_strokes;
        } else {
            count_ = std::max(count_, place + 1);
        }
        strokes_[static_cast<std::size_t>(place)] = {stroke_, offset_, first_offset_, reference_};
    }

    static constexpr double fastest_rise = 2.5;

    Settings settings_;
    Stroke stroke_;
    bool used_ = false, settling_ = true, has_first_ = false;
    std::array<Learned, most_strokes> strokes_{};
    int count_ = 0, oldest_ = 0;
    std::array<double, 2> offset_{}, first_offset_{}, error_{}, excess_{};
    std::array<bool, 2> known_{};
    double reference_ = 0, factor_ = slow;
    int cycles_ = 0, good_ = 0, beyond_ = 0;
};

}  // namespace plumb
