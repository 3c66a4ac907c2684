// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/stroke_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace plumb {

// The region and the settings in force. Settings that contradict themselves leave the last good ones in
// force, as a whole.
class StrokeInForce {
public:
    // The present place of the axis.
    struct Place {
        double end = 0;                  // mu, where a stroke ends: point R
        bool running = false;            // it moves, by a command with
        double lead = 0, jerk_time = 0;  // s
    };

    // The first ones.
    void begin(const StrokeValues& given) noexcept { values_ = given; }

    // For a start or a shift: the reason why not.
    Fault take(const StrokeValues& given, double end, double dt) noexcept {
        const Fault reason = given.refusal(given.lower, given.upper, end, dt);
        if (reason != Fault::none) return reason;
        values_ = given;
        lower_ = given.lower;
        upper_ = given.upper;
        return Fault::none;
    }

    // For a way to the end from rest: false if neither the given settings nor the last ones permit it.
    bool take_end(const StrokeValues& given, double end, double dt) noexcept {
        if (given.possible(dt) && given.leads()) values_ = given;
        if (!values_.possible(dt) || !values_.leads()) return false;
        lower_ = upper_ = end;
        return true;
    }

    // Takes over changed settings for the present region; whether a stroke does. This takes longer than all
    // else, so it is done only where something has changed.
    bool judge(const StrokeValues& given, const Place& place, double dt) noexcept {
        if (judged_.is(given, lower_, upper_, place)) return false;
        judged_ = {given, lower_, upper_, place.end, place.running};
        const bool possible = given.possible(dt);
        refused_ = possible ? Fault::none : Fault::settings;
        if (!place.running) {
            if (possible && !given.leads()) refused_ = Fault::lead;
            if (refused_ == Fault::none) values_ = given;
            return false;
        }
        if (!(upper_ > lower_)) return false;
        refused_ = given.refusal(lower_, upper_, place.end, dt);
        if (refused_ == Fault::none && !given.leads(place.lead, place.jerk_time)) refused_ = Fault::lead;
        if (refused_ == Fault::none) values_ = given;
        return refused_ == Fault::none;
    }

    const StrokeValues& values() const noexcept { return values_; }
    Fault refused() const noexcept { return refused_; }  // the settings given last

    // The stroke that learning learns, and how.
    LearnedStrokes::Stroke learned_stroke() const noexcept {
        return values_.learned_stroke(lower_, upper_, command_);
    }
    DeadPointLearning::Settings learning() const noexcept {
        DeadPointLearning::Settings its = values_.learned(lower_, upper_);
        its.command = static_cast<int>(values_.turning(command_) >> 1);
        return its;
    }

    // Strokes start, with the command of the present settings until they end.
    void begin_strokes() noexcept {
        stretch_ = 1;
        command_ = {values_.lead, values_.jerk_time};
    }
    // Multiplies the speed, so that a cycle takes its time.
    void stretch(double ratio) noexcept {
        if (std::abs(ratio - 1) > 1e-3) stretch_ = std::clamp(stretch_ * ratio, 0.1, 10.0);
    }

    // Of the next stroke, mu/s, where learning permits a part of it.
    double speed(double part) const noexcept {
        const double whole =
            upper_ > lower_ ? values_.peak_speed(upper_ - lower_) : values_.stroke.largest_speed;
        return whole * stretch_ * (values_.override_value > 0 ? values_.override_value : 1) * part;
    }

    // S, at the lower and the upper dead point.
    std::array<double, 2> longest_waits() const noexcept {
        const double exact_stop = values_.exact_stop > 0 ? values_.stroke.exact_stop : 0;
        return {values_.stroke.lower_dwell + exact_stop, values_.stroke.upper_dwell + exact_stop};
    }

    // For the next stroke.
    Oscillation::Settings stroke(double part, double end) const noexcept {
        Oscillation::Settings its = values_.stroke;
        its.lower = lower_;
        its.upper = upper_;
        its.end_position = end;
        if (!(values_.exact_stop > 0)) its.exact_stop = 0;
        its.speed = speed(part);
        return its;
    }

private:
    struct Judged {
        StrokeValues given;
        double lower = 0, upper = 0, end = 0;
        bool running = false;

        bool is(const StrokeValues& now, double low, double high, const Place& place) const noexcept {
            return lower == low && upper == high && end == place.end && running == place.running &&
                   given == now;
        }
    };

    StrokeValues values_{};
    StrokeValues::Command command_;  // of the strokes that run, or that ran last
    Judged judged_;
    double lower_ = 0, upper_ = 0;
    double stretch_ = 1;
    Fault refused_ = Fault::none;
};

}  // namespace plumb
