// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/climb.hpp"
#include "components/math/oscillation/learned_strokes.hpp"
#include "components/math/oscillation/oscillation_settings.hpp"
#include "components/math/oscillation/turn_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace plumb {

// Learns how far the commanded ends of a stroke must lie beyond its dead points, so that the axis reaches
// these and does not pass them. Outward is positive at both ends, in mu.
//
// A new stroke begins inside the dead points by an inset, and slow where its acceleration is above the one
// that this joint has proven. The speed rises as Climb has it, while the overshoot that is predicted for it
// stays within the inset. At full speed each measured error corrects its end, by the law of its turns. The
// turns of strokes that were learned before are remembered. After a restart such a stroke begins at reduced
// speed, and rises as soon as the axis has shown the force of before.
class DeadPointLearning {
public:
    using Stroke = LearnedStrokes::Stroke;
    using Learned = LearnedStrokes::Learned;

    static constexpr double slow = Climb::slow;

    struct Settings {
        double inset = 0;                  // mu, of a stroke that is not learned
        double gain = 0.7;                 // above 0, below 1
        double most = 0;                   // mu, the largest correction either way
        double tolerance = 0;              // mu, of a learned dead point
        double most_beyond = 0;            // mu, beyond a dead point
        double demand = 0;                 // mu/s2, the largest acceleration of the stroke at full speed
        std::array<double, 2> reversal{};  // mu/s2, at the dead points at full speed
        int stretching = -1;               // the power of the length with which it goes
        // The length, to the way from the last change of speed to an end.
        std::array<double, 2> shortness{1, 1};
        bool even = true;  // without sections and waits
        int command = 0;   // a number that changes with the way from stroke to command
    };

    // What a measured dead point has brought. passed: the axis or its scale went beyond, which the next dead
    // point decides. beyond: the axis did, and learning begins again. slips: the scale has moved against the
    // joint.
    enum class Verdict { none, passed, beyond, slips };

    // Takes up a stroke: one that it has learned with its corrections, any other one from the beginning.
    void select(const Stroke& stroke, const Settings& settings) noexcept {
        if (settings.command != settings_.command) forget_turns();
        settings_ = settings;
        if (stroke == stroke_ && used_) return;
        stroke_ = stroke;
        number_ = number_ % 1000000 + 1;
        used_ = true;
        climb_.open();
        trips_ = 0;
        if (limit_ > 0 && limit_ < settings.demand) climb_.cap(limit_ / settings.demand);
        begin();
    }

    // From the beginning, for the selected stroke: the axis is not the one that learned it.
    void restart() noexcept {
        forget_turns();
        proven_ = 0;
        doubted_ = true;
        begin();
    }

    void forget() noexcept {
        strokes_.forget();
        forget_turns();
        proven_ = 0;
        open();
        begin();
    }

    // A person has decided that the axis may rise again above its last good speed.
    void open() noexcept {
        climb_.open();
        trips_ = 0;
        limit_ = 0;
        weak_drive_ = doubted_ = false;
    }

    const LearnedStrokes& strokes() const noexcept { return strokes_; }

    // Remembers a stroke that was learned before a restart; false if it is impossible.
    bool restore(const Learned& learned) noexcept { return strokes_.restore(learned); }

    // The part of the full speed at which the next stroke may run, and the part of its acceleration by which
    // it brakes.
    double speed_factor() const noexcept { return climb_.factor(); }
    double braking() const noexcept { return climb_.braking(); }
    bool at_full_speed() const noexcept { return climb_.complete() && !climb_.capped(); }
    bool rising() const noexcept { return !climb_.complete(); }
    bool capped() const noexcept { return climb_.capped(); }  // the last good speed stays
    bool weak_drive() const noexcept { return weak_drive_; }  // it has shown its largest force

    // No motion needs more acceleration than the joint has proven, or than it shows at this factor. Where no
    // correction was learned, the end lies inside by as much as the axis turns beyond, and a part of the
    // inset.
    void restrain(OscillationSettings& settings) const noexcept {
        settings.learned = number_;
        settings.end_acceleration = end_acceleration(settings.acceleration);
        if (!(settings_.demand > 0)) return;
        const double longer = 1 + std::max(offset_[0] + offset_[1], 0.0) / length();  // in the same time
        const double most = std::max(1.05 * settings_.demand * longer * climb_.level(), nearly * proven_);
        settings.acceleration = std::min(settings.acceleration, most);
        settings.braking = climb_.braking();
        if (climb_.complete())
            settings.caution = settings_.inset / 2 + std::max({-offset_[0], -offset_[1], 0.0});
    }

    // A way to the end position has ended, and the axis went so far beyond, mu. True if that is too far.
    bool ended(double beyond) noexcept {
        if (settings_.demand > 0)
            approach_.ended(strokes_now(0), end_acceleration(0), beyond, settings_.most_beyond);
        return beyond > settings_.most_beyond;
    }

    // Where the end of a stroke lies, with the acceleration of its reversal, its speed, and the distance from
    // its beginning to the dead point, 0 if it is a stroke like all others. An end beyond the dead point
    // comes back with the acceleration, as the axis then follows closer. One inside goes farther inside with
    // the square of a speed above the full one, as the axis then overshoots more. Between strokes of another
    // length it goes inward only.
    double offset(bool upper, double acceleration, double speed, double way = 0) const noexcept {
        double its = offset_[upper];
        const double faster = speed / stroke_.speed;
        if (way > 0 && lengths_[upper] > 0) {
            const double now = (way + length() + offset_[!upper]) / 2 + its;
            its -= std::max(1.5 * slopes_[upper] * (now - lengths_[upper]), 0.0);
        }
        if (its < 0) return faster > 1 ? its * faster * faster : its;
        return acceleration < reference_[upper] ? its * acceleration / reference_[upper] : its;
    }

    // Whether a measured dead point can be that of this axis: the distance from its commanded end is between
    // the last one and that times the square of the speeds, give or take a tenth of the stroke and the inset.
    // The first one of another stroke of an axis that has learned is.
    bool plausible(bool upper, double error, double used, double speed) const noexcept {
        if (proven_ > 0 && !(excess_speed_[upper] > 0)) return true;
        const double faster = excess_speed_[upper] > 0 ? speed / excess_speed_[upper] : 1;
        const double last = excess_[upper], grown = last * faster * faster;
        const double slack = 0.1 * length() + settings_.inset, excess = error - used;
        return excess >= std::min(last, grown) - slack && excess <= std::max(last, grown) + slack;
    }

    // Whether a dead point and the one before it are those of the stroke that it learns, which was selected
    // when its stroke was planned. `number` is that of restrain().
    bool has(bool upper, double bound, double before, int number) const noexcept {
        return number == number_ && bound == (upper ? stroke_.upper : stroke_.lower) &&
               before == (upper ? stroke_.lower : stroke_.upper);
    }

    // The largest accelerations of a stroke that left an end: of the command and of the axis. True if the
    // ends of the strokes to come have changed: a remembered stroke needs no measured cycle for that.
    bool shown(bool upper, double commanded, double done) noexcept {
        climb_.shown(upper, commanded, done);
        commanded_[upper] = commanded;
        shown_[upper] = done;
        if (!recalls_ || !climb_.proves() || !(known_[0] || known_[1])) return false;
        known_ = {false, false};
        rise();
        return true;
    }

    // The axis has fallen behind a stroke, which was given up, while the speed rises.
    void fall_behind() noexcept {
        climb_.fall_behind();
        note_weakness();
    }

    // Mu, of the commanded strokes before and after a dead point; 0: as the ends are now.
    struct Lengths {
        double before, after;
    };

    // How far the axis turned beyond the commanded end of a stroke, at any speed of the selected stroke. It
    // braked by a part of the acceleration with which it left. `number` is that of restrain().
    void turned(bool upper, int number, double speed, double braking, const Lengths& lengths,
                double beyond) noexcept {
        if (number != number_) return;
        const double faster = speed / stroke_.speed;
        TurnLaw::Turn turn = turn_of(upper, (lengths.before + lengths.after) / 2);
        turn.leaving *= faster * faster;
        turn.acceleration = braking * turn.leaving;
        // The last one of a pause leaves with more acceleration than its own stroke has.
        const bool pauses = !climb_.complete() && turn.leaving <= turn.acceleration;
        turn.starts = predicts_[upper];
        if (laws_[upper].empty() || !pauses) laws_[upper].add(turn, beyond, settings_.most_beyond);
        if (recalls_ && !laws_[upper].remembers()) {  // the axis is another one
            laws_[!upper].drop_remembered();
            recalls_ = false;
        }
        if (predicts_[upper]) predict(upper);
    }

    // A measured dead point: its error (positive beyond the dead point), the offset that its stroke had, the
    // acceleration of the reversal, the speed, and the lengths, of strokes at the present speed factor.
    Verdict measured(bool upper, double error, double used, double acceleration, double speed,
                     Lengths lengths = {}) noexcept {
        const bool beyond = error > settings_.most_beyond;
        const bool changes = lengths.before > 0 && differs(lengths);
        if (was_learned_ && !beyond && !passed_ && changes) return Verdict::none;
        error_[upper] = error;
        excess_[upper] = error - used;
        excess_speed_[upper] = speed;
        known_[upper] = true;
        predicts_[upper] = false;
        if (was_learned_) shift_[upper] = excess_[upper] - steady_excess_[upper];
        if (climb_.complete()) {
            if (!waits(upper)) correct(upper, error, used, changes);
            reference_[upper] = acceleration;
        } else if (beyond) {
            offset_[upper] = placed(std::min(offset_[upper], used - error));
            per_acceleration_ = std::max(per_acceleration_, excess_[upper] / acceleration);
        }
        const bool passes = was_learned_ && beyond;
        const bool decides = passed_ && (answered_ || passed_upper_ != upper);
        if (decides) answered_ = true;
        if (passes && !passed_) {
            passed_ = true;
            answered_ = false;
            passed_upper_ = upper;
        }
        if (slips()) {
            go_back();
            known_ = {false, false};
            if (++slips_ < 3) return passes ? Verdict::passed : Verdict::none;
            slipped();
            return Verdict::slips;
        }
        slips_ = 0;
        if (decides) return pass_beyond();
        if (passes) return Verdict::passed;
        return known_[0] && known_[1] ? cycle() : Verdict::none;
    }

    // The scale has slipped: what was learned before stays, and nothing else.
    void slipped() noexcept {
        if (was_learned_)
            go_back();
        else
            for (double& each : offset_) each = std::min(each, -settings_.inset);
        known_ = waited_ = {false, false};
        passed_ = false;
        slips_ = good_ = 0;
    }

    bool learned() const noexcept { return good_ >= 2; }
    bool was_learned() const noexcept { return was_learned_; }  // since learning began
    int cycles() const noexcept { return cycles_; }             // at full speed, in which it was not learned
    double most_beyond() const noexcept { return settings_.most_beyond; }
    double demand() const noexcept { return settings_.demand; }
    // Mu, since the stroke was first learned.
    double drift() const noexcept { return drift_; }
    // A correction is at its bound, and the dead point is not reached.
    bool weak() const noexcept {
        const auto at_bound = [&](std::size_t i) {
            return offset_[i] >= settings_.most && error_[i] < -settings_.tolerance;
        };
        return cycles_ > 0 && (at_bound(0) || at_bound(1));
    }

private:
    double length() const noexcept { return stroke_.upper - stroke_.lower; }
    // Mu, the smallest difference of a length that counts.
    double least_longer() const noexcept { return std::max(10 * settings_.tolerance, 0.003 * length()); }
    // Strokes after a start are shorter than the ends are apart.
    bool differs(const Lengths& lengths) const noexcept {
        return std::max(std::abs(lengths.before - whole_length()), std::abs(lengths.after - whole_length())) >
               least_longer();
    }
    double whole_length() const noexcept { return length() + offset_[0] + offset_[1]; }  // of the command
    // Mu/s2, of the way to the end position; by the largest acceleration where no stroke was selected.
    double end_acceleration(double most) const noexcept {
        return approach_.acceleration(strokes_now(most), settings_.most_beyond);
    }
    EndApproach::Strokes strokes_now(double most) const noexcept {
        return {settings_.demand > 0 ? settings_.demand : most, climb_.level(), overshoot()};
    }
    // S2, for each acceleration, of this joint.
    double overshoot() const noexcept { return std::max(per_acceleration_, strokes_.largest_overshoot()); }
    // Mu, what a drive that saturates may overshoot.
    double room() const noexcept { return std::min(settings_.inset, 10 * settings_.most_beyond); }

    // Mu, of an end: outward within max-correction, inward at most a quarter of the stroke.
    double placed(double its) const noexcept { return std::clamp(its, -length() / 4, settings_.most); }

    // Where the joint has proven nothing the ends of its first cycle lie farther inside: a position loop with
    // an integral turns far beyond its command in a slow stroke, too.
    void begin() noexcept {
        begin_climb();
        const double a = settings_.demand * climb_.level();
        const double most = climb_.level() > slow * slow ? settings_.inset : 10 * settings_.inset;
        offset_[0] = offset_[1] = placed(-std::min(most, 0.05 * length()) - 1.3 * a * overshoot());
        excess_ = excess_speed_ = last_excess_ = {};
        last_turning_ = 0;
        reference_ = lengths_ = slopes_ = {};
        for (TurnLaw& each : laws_) each.begin();
        slow_ = force_ = {};
        recalls_ = false;
        if (const Learned* known = strokes_.find(stroke_); known && !doubted_) recall(*known);
        for (const std::size_t i : {0, 1}) {
            predicts_[i] = at_full_speed() && !laws_[i].empty();
            if (predicts_[i]) predict(i);
        }
        known_ = {false, false};
        shift_ = {};
        waited_ = {false, false};
        passed_ = false;
        cycles_ = good_ = slips_ = 0;
        was_learned_ = false;
        drift_ = 0;
    }

    // A remembered stroke gives two turns for each end: at full speed, and in the last cycle of a climb. The
    // second one tells whether the axis turns as before.
    void recall(const Learned& known) noexcept {
        slow_ = known.slow;
        if (slow_ == std::array<double, 2>{}) return;
        force_ = known.shown;
        climb_.expect(std::min(force_[0], force_[1]) / (seen_part * settings_.demand));
        for (const std::size_t i : {0, 1}) {
            TurnLaw::Turn fast = turn_of(i != 0, length() + known.offset[0] + known.offset[1]);
            TurnLaw::Turn first = turn_of(i != 0, whole_length());
            fast.remembered = first.remembered = true;
            first.acceleration *= unshown;
            laws_[i].add(fast, -known.offset[i], settings_.most_beyond);
            laws_[i].add(first, slow_[i], settings_.most_beyond);
            excess_[i] = slow_[i];
        }
        excess_speed_[0] = excess_speed_[1] = stroke_.speed * climb_.factor();
        recalls_ = true;
    }
    int shape() const noexcept { return settings_.even ? 0 : number_; }

    // The same turn between strokes of another mean length.
    TurnLaw::Turn stretched(TurnLaw::Turn turn, double length_now) const noexcept {
        const double longer = length_now / turn.length;
        turn.length = length_now;
        turn.acceleration *= std::pow(longer, settings_.stretching);
        turn.leaving *= std::pow(longer, settings_.stretching);
        return turn;
    }
    TurnLaw::Turn turn_of(bool upper, double length_now) const noexcept {
        const double its = settings_.reversal[upper];
        return stretched({its, its, length(), shape()}, length_now);
    }
    TurnLaw::Prediction predicted(bool upper, const TurnLaw::Turn& turn) const noexcept {
        return laws_[upper].predict(turn, settings_.most_beyond);
    }

    // An end by the turns that the joint has made, inside by the doubt of the law. The ends that move make
    // the strokes longer.
    void predict(bool upper) noexcept {
        TurnLaw::Turn turn = turn_of(upper, length());
        TurnLaw::Prediction its;
        for (int i = 0; i < 4; ++i) {
            its = predicted(upper, turn);
            const double longer = std::clamp(-2 * its.beyond, -0.5 * length(), 0.5 * length());
            turn = turn_of(upper, length() + longer);
        }
        double doubt = its.doubt;
        if (!laws_[upper].covers(turn)) doubt = std::max(doubt, uneven_doubt(upper, its.beyond));
        excess_[upper] = its.beyond;
        reference_[upper] = settings_.reversal[upper];
        aim(upper, -its.beyond - doubt, turn);
    }

    // Takes an end, for strokes as this turn has them.
    void aim(bool upper, double its, const TurnLaw::Turn& turn) noexcept {
        offset_[upper] = placed(its);
        lengths_[upper] = turn.length;
        const TurnLaw::Turn longer = stretched(turn, 1.01 * turn.length);
        slopes_[upper] =
            (predicted(upper, longer).beyond - predicted(upper, turn).beyond) / (0.01 * turn.length);
    }

    // Mu, of a turn beside a section, which no even stroke explains, and of a stroke that is quicker than all
    // others: an axis that lags can turn beyond there. An overshoot grows with the square of the frequency,
    // which is that of the way from the last change of speed; with a reserve of 30 %.
    double uneven_doubt(bool upper, double beyond) const noexcept {
        const double shortness = settings_.shortness[upper], over = std::max(beyond, 0.0);
        const double grown = std::min(1.3 * over * (shortness * shortness - 1), largest_growth * length());
        return std::max({settings_.inset + over / 2, grown, -0.6 * beyond});
    }

    void forget_turns() noexcept {
        for (TurnLaw& each : laws_) each.forget();
        approach_.begin();
    }

    // At once at full speed where the joint has proven the acceleration since the start. One that it has
    // proven before that is shown again by a cycle, which brakes by less.
    void begin_climb() noexcept {
        const auto part = [&](double its) {
            return settings_.demand > 0 ? std::min(nearly * its / settings_.demand, 1.0) : 0;
        };
        const double now = part(proven_), before = doubted_ ? 0 : part(strokes_.largest_proven());
        constexpr double least = slow * slow;
        const double level = std::max({now, before * unshown, least});
        climb_.begin(level, level);
    }

    // A learned end by a part of its error, any other one by the law of its turns. At most half of the error
    // is a doubt, so that a small one ends.
    void correct(bool upper, double error, double used, bool changes) noexcept {
        const TurnLaw& law = laws_[upper];
        const bool within = std::abs(error) <= settings_.tolerance;
        const bool gently =
            law.empty() || ((was_learned_ || (within && !changes)) && error <= settings_.most_beyond);
        const TurnLaw::Turn turn = law.empty() ? turn_of(upper, length()) : law.last();
        const double others = length() + offset_[!upper];
        double its = used - (gently ? settings_.gain : 1) * error;
        for (int i = 0; i < 4 && !gently; ++i) {
            const TurnLaw::Prediction now = predicted(upper, stretched(turn, others + its));
            its = -now.beyond -
                  std::min(now.doubt, std::max(0.5 * std::abs(now.beyond + used), law.surprise()));
        }
        aim(upper, its, stretched(turn, others + placed(its)));
    }

    Verdict cycle() noexcept {
        known_ = {false, false};
        const bool beyond = std::max(error_[0], error_[1]) > settings_.most_beyond;
        if (!climb_.complete()) {
            if (beyond) return pass_beyond();
            rise();
            return Verdict::none;
        }
        if (beyond) return pass_beyond();
        if (cycles_ < 1000000) ++cycles_;
        const bool within =
            std::abs(error_[0]) <= settings_.tolerance && std::abs(error_[1]) <= settings_.tolerance;
        good_ = within ? std::min(good_ + 1, 2) : 0;
        if (!climb_.capped()) {
            const double largest = std::min(commanded_[0], commanded_[1]) / seen_part;
            proven_ = std::max(proven_, std::min(settings_.demand, largest));
            const double least = std::min(reference_[0], reference_[1]);
            if (least > 0) per_acceleration_ = std::max(excess_[0], excess_[1]) / least;
        }
        if (!learned()) return Verdict::none;
        was_learned_ = true;
        cycles_ = 0;
        steady_excess_ = excess_;
        steady_offset_ = offset_;
        doubted_ = false;
        if (climb_.capped()) return Verdict::none;  // not learned for the full speed
        const Learned* known = strokes_.find(stroke_);
        const std::array<double, 2> first = known ? known->first_offset : offset_;
        drift_ = drift_from(first);
        strokes_.remember(
            {stroke_, offset_, first, std::min(reference_[0], reference_[1]), proven_, slow_, force_});
        return Verdict::none;
    }

    // Whether the axis turns inside of where it did, for the first time: if the other dead point has moved
    // the same way the scale slips, and a correction would take the axis beyond.
    bool waits(bool upper) noexcept {
        const bool before = waited_[upper];
        waited_[upper] = std::max(shift_[upper], error_[upper]) < -2 * settings_.tolerance;
        return waited_[upper] && !before;
    }

    // Both dead points have moved the same way: the scale has, or the joint. Friction moves both inward, or
    // both outward. The first turn may contain a part of the slip only. Such a turn corrects nothing.
    bool slips() const noexcept {
        return was_learned_ && std::min(shift_[0], shift_[1]) < -2 * settings_.tolerance &&
               std::max(shift_[0], shift_[1]) > 2 * settings_.tolerance;
    }

    // To the last cycle that was right.
    void go_back() noexcept {
        offset_ = steady_offset_;
        for (const std::size_t i : {0, 1}) aim(i != 0, offset_[i], turn_of(i != 0, whole_length()));
    }

    // The first time learning begins again. After the second one the speed stays at the last good one.
    Verdict pass_beyond() noexcept {
        if (++trips_ >= 2) {
            climb_.cap_before();
            limit_ = climb_.ceiling() * settings_.demand;
        }
        restart();
        return Verdict::beyond;
    }

    // The inset takes the growth of the overshoot, with a reserve of 30 %.
    void rise() noexcept {
        const double now = climb_.turning();
        double slope = 0;  // mu of overshoot a level
        for (std::size_t i = 0; i < 2; ++i) {
            slope = std::max(slope, excess_[i] / now);
            if (now - last_turning_ > 0.05 * now && last_turning_ > 0)
                slope = std::max(slope, (excess_[i] - last_excess_[i]) / (now - last_turning_));
            offset_[i] = placed(-settings_.inset - std::max({excess_[0], excess_[1], 0.0}));
        }
        last_turning_ = now;
        last_excess_ = excess_;
        const double level = climb_.level();
        const double growth = slope > 0 ? 1 + settings_.inset / (1.3 * slope * level) : Climb::fastest;
        if (!recalls_ && level >= 1 && std::abs(climb_.braking() - unshown) < 0.01) {
            slow_ = excess_;
            force_ = shown_;
        }
        climb_.rise(growth, length(), room());
        note_weakness();
        if (at_full_speed() && recalls_)
            for (const bool upper : {false, true}) predict(upper);
    }

    void note_weakness() noexcept {
        if (!climb_.weak()) return;
        weak_drive_ = true;
        limit_ = climb_.ceiling() * settings_.demand;
    }

    double drift_from(const std::array<double, 2>& first) const noexcept {
        return std::max(std::abs(offset_[0] - first[0]), std::abs(offset_[1] - first[1]));
    }

    static constexpr double seen_part = 0.95;       // of the peak of a crank, in a mean of 30 degrees
    static constexpr double nearly = 1.1;           // times the proven acceleration is proven, too
    static constexpr double largest_growth = 0.05;  // of the length
    static constexpr double unshown = 0.671;        // of an acceleration that was proven before the start

    Settings settings_;
    Stroke stroke_;
    LearnedStrokes strokes_;
    Climb climb_;
    EndApproach approach_;
    int number_ = 0;  // of the stroke, which changes with each that is selected
    bool used_ = false, was_learned_ = false, weak_drive_ = false;
    bool doubted_ = false;  // the axis is not the one that learned
    std::array<double, 2> offset_{}, error_{};
    // Of the last cycle that was right; mu, by which an end turns elsewhere since.
    std::array<double, 2> steady_offset_{}, steady_excess_{}, shift_{};
    std::array<bool, 2> waited_{};  // a correction outward, for a cycle
    // A dead point, by the axis or by its scale, which the turn at the other one decides.
    bool passed_ = false, passed_upper_ = false, answered_ = false;
    std::array<double, 2> excess_{}, excess_speed_{};  // of the last dead points: beyond the command; speed
    std::array<double, 2> last_excess_{};              // at the level before
    std::array<double, 2> commanded_{}, shown_{};      // mu/s2, of the last strokes from both ends
    std::array<bool, 2> known_{};
    std::array<double, 2> reference_{};  // mu/s2, of the reversals whose ends were corrected
    std::array<double, 2> lengths_{};    // mu, of the strokes for which the offsets are; 0: any
    std::array<double, 2> slopes_{};     // of the turns, by that length
    std::array<TurnLaw, 2> laws_{};
    std::array<bool, 2> predicts_{};  // the end is predicted, and not measured yet
    double last_turning_ = 0, drift_ = 0;
    double proven_ = 0;            // mu/s2, of this joint since the start
    double per_acceleration_ = 0;  // s2, the overshoot of this joint
    // Of the last cycle of a climb: mu, beyond the command; mu/s2, of the axis itself.
    std::array<double, 2> slow_{}, force_{};
    bool recalls_ = false;  // the stroke was learned before
    double limit_ = 0;      // mu/s2, of the last good speed, until open(); 0: none
    int cycles_ = 0, good_ = 0, trips_ = 0, slips_ = 0;
};

}  // namespace plumb
