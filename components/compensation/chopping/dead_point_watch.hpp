// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/dead_point_learning.hpp"
#include "components/math/oscillation/dead_point_meter.hpp"
#include "components/math/oscillation/lag_model.hpp"
#include "components/math/oscillation/oscillation_leg.hpp"
#include "components/math/oscillation/shown_acceleration.hpp"
#include "components/math/oscillation/slip_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace plumb {

// Watches the axis in each period: its lag, the acceleration that it shows, and its dead points. Compares
// them with the command, and learns from them.
class DeadPointWatch {
public:
    using Arrival = OscillationLeg::Arrival;
    using Verdict = DeadPointLearning::Verdict;

    // passes: the axis is beyond a dead point, which its turn decides.
    enum class Event { none, corrected, passes, beyond, wrong_scale, slips, lost, lags, falls_behind };

    // Of the strokes that are planned now.
    struct Present {
        bool learns = false;
        bool without_override = true;
        double speed = 0;              // mu/s
        std::array<double, 2> wait{};  // s, the longest one at the lower and the upper dead point
    };

    // Of this period; mu, mu/s, mu/s2, without the lead.
    struct Sample {
        double measured = 0, command = 0, velocity = 0, acceleration = 0;
        bool second_half = false, upward = false;
        double duration = 0, dt = 0.001;  // s, of the stroke, and of the period
        double length = 0;                // mu, of the stroke
        double speed = 0;                 // mu/s, peak of the stroke
        bool stands = false;              // the command
        double motor = 0;                 // mu, by its encoder
        double hardest = 0;               // mu/s2, of the stroke
    };

    DeadPointLearning& learning() noexcept { return learning_; }
    const DeadPointLearning& learning() const noexcept { return learning_; }

    // A motion begins.
    void begin() noexcept {
        arrival_[0] = arrival_[1] = {};
        doubts_[0] = doubts_[1] = 0;
        lag_.begin();
        pause();
    }

    // The next dead point is not that of a whole stroke.
    void pause() noexcept {
        metering_ = whole_ = false;
        paused_ = true;
        shown_.cancel();
        slip_.pause();
    }
    // The scale has another origin.
    void accept() noexcept { slip_.accept(); }
    // The axis or its scale is another one.
    void forget() noexcept {
        learning_.forget();
        slip_.forget();
    }

    void arrive(const Arrival& arrival) noexcept { arrival_[arrival.upper] = arrival; }

    // A dead point is between the second halves of two strokes.
    Event step(const Sample& now, const Present& present) noexcept {
        const bool turned = !paused_ && now.upward != upward_now_;
        paused_ = false;
        upward_now_ = now.upward;
        const double least = learning_.most_beyond();
        bool slips = turned && slip_.stroke(2 * least);
        slips |= slip_.step({now.measured, now.motor, now.hardest}, least / 5);
        if (slips && present.learns) {
            learning_.slipped();
            return Event::slips;
        }
        if (turned) {
            const bool upper = !now.upward;
            const double wait = std::exchange(wait_[upper], arrival_[upper].wait);
            if (wait_[upper] != wait || wait_[upper] != present.wait[upper])
                lag_.begin();  // a stroke from rest begins with another lag
            lag_.stroke(whole_, learning_.was_learned() && present.without_override, now.speed, now.length);
            whole_ = true;
            shown_.begin(now.upward, now.duration, now.dt);
        }
        Event event = lag(now, present);
        if (shown_.step(now.command, now.measured) && present.without_override &&
            now.speed == present.speed && learning_.shown(!now.upward, shown_.commanded(), shown_.done()) &&
            event == Event::none)
            event = Event::corrected;
        if (now.second_half && (!metering_ || now.upward != upward_)) {
            const Event its = metering_ ? evaluate(upward_, now.length, present) : Event::none;
            if (event == Event::none) event = its;
            metering_ = true;
            upward_ = now.upward;
            passed_ = false;
            meter_.begin(now.upward);
        }
        if (event == Event::none && !slip_.suspects() && passes(now, present)) event = Event::passes;
        if (metering_) meter_.step(now.measured);
        return event;
    }

    // The last ones.
    const Arrival& arrival(bool upper) const noexcept { return arrival_[upper]; }
    double position(bool upper) const noexcept { return position_[upper]; }  // mu
    double error(bool upper) const noexcept { return error_[upper]; }        // mu, positive outside

private:
    // Whether the axis goes beyond the dead point where its command turned last. A stroke leads there, or the
    // first way from point R. True once for each dead point.
    bool passes(const Sample& now, const Present& present) noexcept {
        const Arrival& its = arrival_[upward_];
        const bool first = !arrival_[!upward_].happened;
        if (!metering_ || passed_ || now.upward == upward_ || !its.happened || !present.learns ||
            !(its.regular || first))
            return false;
        const double error = upward_ ? now.measured - its.bound : its.bound - now.measured;
        return passed_ = error > learning_.most_beyond();
    }

    // Whether the lag is far from that of the last strokes: a jam, or a drive without force. It grows at most
    // with the square of the speed.
    Event lag(const Sample& now, const Present& present) noexcept {
        const double sign = now.upward ? 1 : -1, lag = sign * (now.command - now.measured);
        if (now.stands) return Event::none;
        const double rest = sign * lag_.step(now.command, now.velocity, now.acceleration, now.measured);
        if (!present.learns || !whole_ || !lag_.known() || slip_.suspects()) return Event::none;
        const double faster = now.speed / std::max(lag_.speed(), 1e-9),
                     longer = now.length / std::max(lag_.length(), 1e-9);
        const bool rises = learning_.rising() && present.without_override;
        const bool like = std::abs(faster - 1) < 1e-6 && std::abs(longer - 1) < 0.05;
        const double part = lag_.strokes() < 6 ? 0.2 : 0.05;
        const double most = 10 * learning_.most_beyond() +
                            std::max(faster * faster, 1.0) * (2 * lag_.band() + part * lag_.peak());
        // Of a stroke with another frequency only the largest lag is known.
        const double largest =
            like || rises ? 0 : std::max(faster, 1.0) * std::max(longer, 1.0) * lag_.peak();
        // An axis that follows closer than it did is no fault, one that runs ahead of its command is. A
        // stroke begins ahead, by the lag of the stroke before.
        const double late = rises ? rest : std::min(rest, lag - largest);
        if (late <= most && std::min(-rest, -lag - largest) <= most) return Event::none;
        lag_.begin();
        if (!rises) return Event::lags;
        learning_.fall_behind();
        return Event::falls_behind;
    }

    // `leaving` is the length of the stroke after it, mu.
    Event evaluate(bool upper, double leaving, const Present& present) noexcept {
        const Arrival& its = arrival_[upper];
        if (!its.happened) return Event::none;
        if (!meter_.found()) return present.learns && its.regular ? Event::lost : Event::none;
        position_[upper] = meter_.position();
        error_[upper] = upper ? position_[1] - its.bound : its.bound - position_[0];
        if (!present.learns || !its.regular) return Event::none;
        lag_.judge(std::abs(error_[upper]) <= learning_.most_beyond());
        const double crank = its.turning * its.length / (2 * its.speed * its.speed);
        if (its.wait == present.wait[upper] && arrival_[!upper].wait == present.wait[!upper])
            learning_.turned(upper, {its.turning, its.turning / its.braking, its.length, crank},
                             error_[upper] - its.offset);
        const bool plausible = learning_.plausible(upper, error_[upper], its.offset, its.speed);
        doubts_[upper] = plausible ? 0 : doubts_[upper] + 1;
        if (doubts_[upper] >= 2) return Event::wrong_scale;
        if (doubts_[0] + doubts_[1] > 0 || !present.without_override || its.speed != present.speed)
            return Event::none;
        if (its.braking != learning_.braking() || !learning_.has(upper, its.bound, its.opposite, its.learned))
            return Event::none;
        switch (learning_.measured(upper, error_[upper], its.offset, its.acceleration, its.speed,
                                   {its.length, leaving})) {
            case Verdict::passed: return Event::beyond;
            case Verdict::beyond: lag_.begin(); return Event::beyond;
            case Verdict::slips: return Event::slips;
            default: return Event::corrected;
        }
    }

    DeadPointLearning learning_;
    DeadPointMeter meter_;
    LagModel lag_;
    ShownAcceleration shown_;
    SlipWatch slip_;
    Arrival arrival_[2];  // lower, upper
    double position_[2] = {0, 0}, error_[2] = {0, 0};
    int doubts_[2] = {0, 0};   // of the scale, in a row
    double wait_[2] = {0, 0};  // s, at the dead points before the last strokes
    bool passed_ = false;      // the dead point that is metered
    bool metering_ = false, upward_ = false, upward_now_ = false, whole_ = false, paused_ = true;
};

}  // namespace plumb
