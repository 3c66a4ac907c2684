// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace plumb {

// How fast an axis strokes that has not shown yet how much force its drive has. The plan of the full speed is
// stretched in time by a factor, so that all its accelerations go with the square of the factor, the level.
//
// A stroke accelerates by a new level, and brakes by one that the axis has shown. Each end is left with the
// inward force that the next stroke to this end needs for its braking; friction hinders the first and helps
// the second. A drive that saturates falls behind while it accelerates, and passes no dead point.
//
// Without a measurement, and where less than expected was shown, the level rises by a factor r such that a
// drive that saturates overshoots by no more than a given room: S (r - 1)^2 / (4 r), S the stroke.
class Climb {
public:
    static constexpr double slow = 0.2;     // of the speed, in the beginning
    static constexpr double fastest = 1.6;  // rise of the level, where the axis has shown its force

    // From a level, of which the axis has shown a part: it brakes by that.
    void begin(double level, double brakes) noexcept {
        brakes_ = before_ = std::min(brakes, ceiling_);
        level_ = std::min({level, fastest * brakes_, ceiling_});
        cautious_ = false;
        reference_level_ = 0;
        known_ = {false, false};
    }

    // The last good level ends.
    void open() noexcept {
        ceiling_ = 1;
        weak_ = false;
    }

    double factor() const noexcept { return std::sqrt(level_); }
    // The part of the acceleration by which a stroke brakes.
    double braking() const noexcept { return brakes_ / level_; }
    double level() const noexcept { return level_; }
    double turning() const noexcept { return (level_ + brakes_) / 2; }  // the level of a reversal
    bool complete() const noexcept { return level_ >= ceiling_ && brakes_ >= level_; }
    bool capped() const noexcept { return ceiling_ < 1; }
    double ceiling() const noexcept { return ceiling_; }  // a level
    bool weak() const noexcept { return weak_; }          // the drive has shown its largest force

    // Of a stroke that left an end: the largest acceleration of its command and of the axis in its
    // accelerating half, measured in the same way.
    void shown(bool upper, double commanded, double done) noexcept {
        if (!(commanded > 0)) return;
        ratio_[upper] = done / commanded;
        known_[upper] = true;
    }
    // Whether the strokes from both ends have shown their force.
    bool proves() const noexcept {
        return !complete() && known_[0] && known_[1] &&
               std::min(ratio_[0], ratio_[1]) >= enough * expected_ratio();
    }

    // The part of the full acceleration that the axis has shown before; 0: unknown.
    void expect(double its) noexcept {
        reference_ = std::clamp(its, 0.2, 1.0);
        reference_level_ = its > 0 ? 1 : 0;
    }

    // After a cycle at this level whose dead points were good. `growth` is the largest rise of the level that
    // the overshoot permits; length and room are in mu.
    void rise(double growth, double length, double room) noexcept {
        const double q = 2 * room / length, careful = 1 + q + std::sqrt(q * (q + 2));
        const bool shown = known_[0] && known_[1];
        const double its = std::min(ratio_[0], ratio_[1]), expected = expected_ratio();
        known_ = {false, false};
        if (shown) shown_ = level_ * its;
        if (!shown) {
            before_ = brakes_;
            brakes_ = std::min(brakes_ * std::min(careful, growth), ceiling_);
            level_ = std::max(level_, brakes_);
        } else if (its < enough * expected) {
            weaken(level_ * its);
        } else {
            if (!cautious_ && brakes_ < level_) {  // a stroke that brakes as it accelerates shows more
                reference_ = std::clamp(its, 0.2, 1.0);
                reference_level_ = level_;
            }
            before_ = brakes_;
            brakes_ = level_;
            level_ = std::min(level_ * std::min(cautious_ ? careful : fastest, growth), ceiling_);
        }
    }

    // The axis has fallen behind a stroke at this level, which was given up.
    void fall_behind() noexcept {
        known_ = {false, false};
        weaken(brakes_ < level_ ? brakes_ : spare * level_);
    }

    // A level that was good stays until open().
    void cap(double level) noexcept {
        ceiling_ = std::clamp(level, 1e-4, ceiling_);
        begin(ceiling_, ceiling_);
    }
    void cap_before() noexcept { cap(before_ < level_ ? before_ : spare * level_); }

private:
    // The axis has shown less than its level: it brakes by what it has shown, and rises carefully. The second
    // time this is the largest force of its drive.
    void weaken(double shown) noexcept {
        if (cautious_) {
            weak_ = true;
            cap(spare * std::min(brakes_, shown_));
            return;
        }
        cautious_ = true;
        level_ = std::clamp(shown, std::min(brakes_, spare * level_), level_);
        brakes_ = level_;
    }

    // The amplitude of a loop falls with 1 / (1 + k w^2), and w^2 goes with the level.
    double expected_ratio() const noexcept {
        if (reference_level_ <= 0) return level_ > 0.5 && brakes_ < level_ ? least_shown : 0;
        return 1 / (1 + (1 / reference_ - 1) * level_ / reference_level_);
    }

    static constexpr double enough = 0.93;       // of the acceleration that is expected
    static constexpr double least_shown = 0.85;  // of the first rise near full speed
    static constexpr double spare = 0.93;        // of the level at which the drive saturates

    double level_ = slow * slow, brakes_ = slow * slow, before_ = slow * slow, ceiling_ = 1;
    double shown_ = slow * slow;  // the last level that was shown
    double reference_ = 1,
           reference_level_ = 0;  // the part of an acceleration that was shown; at which level
    std::array<double, 2> ratio_{};
    std::array<bool, 2> known_{};
    bool cautious_ = false, weak_ = false;
};

// The acceleration of a way to the end position. An axis stands there, and no stroke has shown how far it
// goes beyond where its command stops. So the first way has a small part of the acceleration of the strokes,
// and less where the axis turned far beyond the ends of these. The next ones rise as the strokes do, while
// the axis does not go beyond. How far it goes is in proportion to the acceleration.
class EndApproach {
public:
    struct Strokes {
        double demand = 0, level = 1;  // mu/s2 at full speed, and the part of it now
        double overshoot = 0;          // s2, how far the axis turns beyond its command, for each acceleration
    };

    // Nothing is known of the axis.
    void begin() noexcept { learned_ = 0; }

    // Mu/s2. The axis may go beyond by `room`, mu.
    double acceleration(const Strokes& its, double room) const noexcept {
        const double first = std::clamp(within(room, its.overshoot), least * its.demand,
                                        Climb::slow * Climb::slow * its.demand);
        return std::min(learned_ > 0 ? learned_ : first, largest * its.demand * its.level);
    }

    // After a way with this acceleration, by which the axis went so far beyond, mu. Where its scale reads
    // another place than its motor, no way is slow enough.
    void ended(const Strokes& its, double acceleration, double beyond, double room) noexcept {
        const double next = std::min(Climb::fastest * acceleration, within(room, beyond / acceleration));
        learned_ = std::max(next, least * its.demand);
    }

private:
    // Mu/s2, by which an axis with this overshoot stays within the room.
    static double within(double room, double overshoot) noexcept {
        return overshoot > 0 ? room / (reserve * overshoot) : std::numeric_limits<double>::infinity();
    }

    static constexpr double largest = 0.25, least = 0.004;  // of the acceleration of the strokes
    static constexpr double reserve = 2;

    double learned_ = 0;  // mu/s2; 0: nothing
};

}  // namespace plumb
