// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/math/oscillation/dead_point_learning.hpp"
#include "components/math/oscillation/jerk_limit.hpp"
#include "components/math/oscillation/learned_strokes.hpp"
#include "components/math/oscillation/oscillation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

namespace plumb {

// The settings of a stroke, read once.
struct StrokeValues {
    static constexpr double farthest = 1e6;           // mu
    static constexpr double slowest = 1e-3;           // mu/s, of max-feed
    static constexpr std::int32_t with_sections = 4;  // of speed_kind
    // Of stop_kind, and the first two of hold_kind.
    enum StopKind : std::int32_t { at_end, at_dead_point, at_once, at_lower, at_upper };

    Oscillation::Settings stroke;  // without the region, which is taken over by commands
    double lower = 0, upper = 0;   // as given now
    double speed_value = 0, override_value = 1;
    std::int32_t speed_kind = 0, stop_kind = 0, hold_kind = at_dead_point;
    bool refuse_slower = false, learn = false, in_range = false, without_wheel = false;
    double at_speed_time = 0;
    double jerk_time = 0, lead = 0, max_lead = 0, max_output_acceleration = 0;
    double taper = 0, max_offset = 0, max_rate = 0, max_drift = 0, max_following_error = 0;
    double inset = 0, exact_stop = 0;
    DeadPointLearning::Settings learning;

    bool operator==(const StrokeValues& other) const noexcept {
        const auto all = [](const StrokeValues& its) {
            return std::tie(its.stroke, its.lower, its.upper, its.speed_value, its.override_value,
                            its.speed_kind, its.stop_kind, its.hold_kind, its.refuse_slower, its.learn,
                            its.without_wheel, its.at_speed_time, its.jerk_time, its.lead, its.max_lead,
                            its.max_output_acceleration, its.taper, its.max_offset, its.max_rate,
                            its.max_drift, its.max_following_error, its.inset, its.exact_stop, its.learning);
        };
        return all(*this) == all(other);
    }

    // Of a region, without override; mu/s.
    double peak_speed(double length) const noexcept {
        switch (speed_kind) {
            case 1: return Reciprocation::speed_of_mean(speed_value);
            case 2: return Reciprocation::speed_of_cycle(1 / speed_value, length);
            case 3:
            case 4: return Reciprocation::speed_of_cycle(speed_value, length);
            default: return speed_value;
        }
    }
    Oscillation::Stop stop() const noexcept {
        switch (stop_kind) {
            case at_dead_point: return Oscillation::Stop::dead_point;
            case at_once: return Oscillation::Stop::at_once;
            case at_lower: return Oscillation::Stop::lower;
            case at_upper: return Oscillation::Stop::upper;
            default: return Oscillation::Stop::end_position;
        }
    }
    Oscillation::Stop hold() const noexcept {
        return hold_kind == at_end ? Oscillation::Stop::end_position : Oscillation::Stop::dead_point;
    }
    // Also of the end after a number of strokes, which is never at once.
    void set_stop_kind(std::int32_t kind) noexcept {
        stop_kind = kind;
        stroke.ending = kind == at_once ? Oscillation::Stop::dead_point : stop();
    }
    // 1 lower, 2 upper: the dead point that is clear of the work.
    void set_abort_kind(std::int32_t kind) noexcept {
        stroke.clear = kind == 1   ? Oscillation::Stop::lower
                       : kind == 2 ? Oscillation::Stop::upper
                                   : Oscillation::Stop::none;
    }
    std::size_t jerk_samples(double dt) const noexcept {
        return static_cast<std::size_t>(std::max(std::ceil(jerk_time / dt - 1e-9), 1.0));
    }
    // Mu/s2, the largest acceleration of a stroke of this length, at most.
    double demand(double length) const noexcept {
        const Reciprocation base{0, length, peak_speed(length)};
        return even() ? std::min(base.peak_acceleration(), stroke.acceleration) : stroke.acceleration;
    }
    double inset_of(double length) const noexcept { return std::min(inset, 0.05 * length); }

    bool even() const noexcept {
        return std::all_of(stroke.sections.begin(), stroke.sections.end(),
                           [](const SpeedSection& each) { return each.kind == SpeedSection::off; });
    }

    // The length, to the way from the last change of speed to a dead point.
    double shortness(const Reciprocation& base, bool upward) const noexcept {
        const double end = upward ? base.upper : base.lower, length = base.stroke();
        double way = length;
        for (const SpeedSpan& each : SpeedSections::spans(stroke.sections, base, upward))
            for (const double edge : {each.from, each.to})
                if (std::abs(edge - end) > length / 100) way = std::min(way, std::abs(edge - end));
        return length / way;
    }

    // How learning learns between these dead points.
    DeadPointLearning::Settings learned(double low, double high) const noexcept {
        const double length = high - low;
        Oscillation::Settings planned = stroke;
        planned.speed = peak_speed(length);
        const Reciprocation base{low, high, planned.speed};
        DeadPointLearning::Settings its = learning;
        its.inset = inset_of(length);
        its.demand = demand(length);
        its.reversal = {OscillationLeg::reversal(base, low, planned),
                        OscillationLeg::reversal(base, high, planned)};
        its.crank = std::min(its.reversal[0], its.reversal[1]) / base.peak_acceleration();
        its.shortness = {shortness(base, false), shortness(base, true)};
        its.stretching = its.crank < 1 ? 0 : stroke.timed ? 1 : -1;
        its.even = even() && !(stroke.lower_dwell > 0 || stroke.upper_dwell > 0 || exact_stop > 0);
        return its;
    }

    // From stroke to command.
    struct Command {
        double lead = 0, jerk_time = 0;  // s

        std::uint32_t number() const noexcept { return whole(lead) * 31 + whole(jerk_time); }
    };

    // A number that changes with the command and with the waits at the dead points. They decide, beside the
    // stroke itself, where an axis turns.
    std::uint32_t turning(const Command& command) const noexcept {
        std::uint32_t number = command.number();
        for (const double value : {stroke.lower_dwell, stroke.upper_dwell, exact_stop})
            number = number * 31 + whole(value);
        return number;
    }

    // As it is learned between these dead points: one number stands for its sections, dwells, command and
    // exact stop.
    LearnedStrokes::Stroke learned_stroke(double low, double high, const Command& command) const noexcept {
        std::uint32_t number = 0;
        for (const SpeedSection& each : stroke.sections)
            for (const double value : {static_cast<double>(each.kind), each.from, each.to, each.ratio,
                                       stroke.lower_dwell, stroke.upper_dwell})
                number = number * 31 + whole(value);
        number = number * 31 + command.number();
        if (exact_stop > 0) number = number * 31 + whole(exact_stop);
        return {low, high, peak_speed(high - low), stroke.acceleration, static_cast<int>(number >> 1)};
    }

    // Whether each value alone is possible. False for NaN.
    bool possible(double dt) const noexcept {
        return in_range && jerk_time <= dt * static_cast<double>(JerkLimit::most) &&
               stroke.largest_speed >= slowest && stroke.lowest < stroke.highest &&
               (override_value == 0 || override_value >= 0.01);
    }

    // Why a stroke between these dead points, from a position, is not possible.
    Fault refusal(double low, double high, double position, double dt) const noexcept {
        if (!possible(dt)) return Fault::settings;
        if (!(high - low > 1e-6 && low >= -farthest && high <= farthest)) return Fault::region;
        const double speed = peak_speed(high - low);
        if (!(speed_kind >= 0 && speed_kind <= with_sections && speed > 1e-6 &&
              speed <= stroke.largest_speed * (1 + 1e-9)))
            return Fault::speed;
        const Reciprocation base{low, high, speed};
        if (!SpeedSections::valid(stroke.sections) || SpeedSections::overlap(stroke.sections, base))
            return Fault::sections;
        if (refuse_slower && base.peak_acceleration() > stroke.acceleration) return Fault::acceleration;
        if (!leads()) return Fault::lead;
        return fits(low, high, position) ? Fault::none : Fault::soft_limit;
    }

    // The lead adds its time, times the jerk 2 a / jerk-time, to the acceleration a.
    bool leads() const noexcept { return lead == 0 || (lead <= max_lead && leads(lead, jerk_time)); }
    // With the lead and the jerk-time of the command that runs.
    bool leads(double its_lead, double its_jerk_time) const noexcept {
        return its_lead == 0 ||
               (its_jerk_time > 0 &&
                stroke.acceleration * (1 + 2 * its_lead / its_jerk_time) <= max_output_acceleration);
    }

private:
    static std::uint32_t whole(double value) noexcept {
        return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::clamp(value, -1e6, 1e6) * 1e6));
    }

    bool fits(double low, double high, double position) const noexcept {
        const double overlead = stroke.acceleration * lead * lead / 2;
        const double more = (learn ? learning.most : 0) + overlead;
        const double up = std::max(high + more - position, 0.0), down = std::max(position - low + more, 0.0);
        return high + more <= stroke.highest && low - more >= stroke.lowest &&
               std::max(up, down) <= max_offset && position + taper * up <= stroke.highest &&
               position - taper * down >= stroke.lowest;
    }
};

}  // namespace plumb
