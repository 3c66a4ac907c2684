// SPDX-License-Identifier: GPL-2.0-or-later
// The settings of a stroke, and the set of them that is in force.
//
// 1. read() reads the pins; a program's words then go before them.
// 2. refusal() judges a set as a whole, for the region of a stroke.
// 3. StrokeInForce takes a good one over: at a start, a shift, and whenever one has changed. A refused one
//    leaves the last good one in force.
// 4. planned() is the set as Oscillation needs it, learned() as DeadPointLearning does.
#pragma once

#include "components/compensation/chopping/chopping_codes.hpp"
#include "components/compensation/chopping/stroke_motion.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/oscillation/dead_point_learning.hpp"
#include "components/math/oscillation/learned_strokes.hpp"
#include "components/math/oscillation/oscillation.hpp"
#include "hal/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

struct StrokeSettings : hal::Settings {
    static constexpr double farthest = 1e6;           // mu
    static constexpr double slowest = 1e-3;           // mu/s, of max-feed
    static constexpr std::int32_t with_sections = 4;  // of speed_kind
    // Of stop_kind, and the first two of hold_kind.
    enum StopKind : std::int32_t { at_end, at_dead_point, at_once, at_lower, at_upper };

    StrokeSettings() = default;
    StrokeSettings(hal::Owner owner, std::size_t sections) : Settings(owner), sections_by_pins(sections) {}

    std::size_t sections_by_pins = 0;
    double upper = unjudged(upper, "upper", 0, "mu", "Upper dead point, in the frame of position.");
    double lower = unjudged(lower, "lower", 0, "mu", "Lower dead point, in the frame of position.");
    bool by_centre =
        pin(by_centre, "by-centre", false, "Centre and stroke give the dead points.", hal::machine());
    double centre = unjudged(centre, "centre", 0, "mu", "Middle of the stroke.", hal::machine(places));
    double stroke =
        unjudged(stroke, "stroke", 0, "mu", "Distance of the dead points.", hal::machine(lengths));
    std::int32_t speed_kind = unjudged(speed_kind, "speed-kind", 0,
                                       "What gives the speed: 0 feed at its peak, 1 mean feed, 2 frequency, "
                                       "3 cycle-time, 4 cycle-time with sections and dwells.",
                                       hal::machine({0, with_sections}));
    double feed = unjudged(feed, "feed", 0, "mu/s", "Speed of the stroke, without sections.");
    double frequency = unjudged(frequency, "frequency", 0, "Hz", "Cycles a second, without sections.",
                                hal::machine({0, 1000}));
    double cycle_time =
        unjudged(cycle_time, "cycle-time", 0, "s", "Time of both strokes.", hal::machine(times));
    double override_ =
        pin(override_, "override", 1, "1", "Multiplies the speed, from 0.01 on; 0 holds.", hal::Range{0, 2});
    double lower_dwell =
        pin(lower_dwell, "lower-dwell", 0, "s", "Rest at the lower dead point.", hal::machine(times));
    double upper_dwell =
        pin(upper_dwell, "upper-dwell", 0, "s", "Rest at the upper dead point.", hal::machine(times));
    double exact_stop =
        pin(exact_stop, "exact-stop", 0, "mu",
            "The dwell begins when the measured axis is as near to its dead point; 0 does not wait for it.",
            hal::machine(lengths));
    double exact_stop_time =
        pin(exact_stop_time, "exact-stop-time", 0.2, "s",
            "Longest time for which a dead point waits for the axis.", hal::expert({0.001, 10}));
    std::int32_t strokes =
        pin(strokes, "strokes", 0, "Strokes to make; 0 until run is false.", hal::machine(counts));
    std::int32_t spark_out =
        pin(spark_out, "spark-out", 0, "Strokes without infeed before the stop, unless that is at once.",
            hal::machine(counts));
    std::int32_t stop_kind = pin(stop_kind, "stop-kind", 0,
                                 "Stop: 0 at the next dead point, then to position; 1 at the next dead "
                                 "point; 2 at once; 3 at the lower, 4 at the upper dead point.",
                                 hal::machine({0, 4}));
    bool upward_first =
        pin(upward_first, "upward-first", false,
            "The first stroke is upward, where the axis starts between the dead points.", hal::machine());
    std::int32_t hold_kind = pin(hold_kind, "hold-kind", 1,
                                 "Hold: 0 at the next dead point, then to position; 1 at the next dead "
                                 "point. emergency-hold holds at once.",
                                 hal::machine({0, 1}));
    std::int32_t abort_kind =
        pin(abort_kind, "abort-kind", 0,
            "Abort, end of the program, enable false or a stopped wheel: 0 by the dead point nearest "
            "position; by the one that is clear of the work, 1 lower, 2 upper, at once.",
            hal::machine({0, 2}));
    bool without_wheel =
        pin(without_wheel, "without-wheel", false,
            "Strokes need no turning spindle: to dress or set up, or for a planer.", hal::machine());
    double at_speed_time =
        pin(at_speed_time, "at-speed-time", 0.2, "s",
            "Longest time for which the spindle may be below its speed in strokes.", hal::machine(times));
    bool refuse_slower =
        pin(refuse_slower, "refuse-slower", false,
            "Refuse a stroke that max-acceleration makes slower, and do not limit it.", hal::machine());
    SpeedSections::Table section = section_pins();  // a phase in deg
    double max_feed =
        unjudged(max_feed, "max-feed", 500, "mu/s", "Largest speed of the stroke.", hal::must(speeds));
    double max_acceleration = pin(max_acceleration, "max-acceleration", 1000, "mu/s2",
                                  "Largest acceleration of the stroke.", hal::must(accelerations));
    double jerk_time =
        pin(jerk_time, "jerk-time", 0, "s",
            "The jerk is at most 2 max-acceleration / jerk-time; 0 does not limit it.", hal::must(times));
    double lead = pin(lead, "lead", 0, "s", "The command leads by this time; below 0.8 / Kv of the drive.",
                      hal::machine(lead_times));
    double max_lead = pin(max_lead, "max-lead", 0.02, "s", "Largest lead.", hal::expert(lead_times));
    double max_output_acceleration =
        pin(max_output_acceleration, "max-output-accel", 3000, "mu/s2",
            "Largest acceleration of the command, with the lead.", hal::machine(accelerations));
    double min_limit =
        pin(min_limit, "min-limit", 0, "mu", "Lower soft limit of the joint.", hal::must(places));
    double max_limit =
        pin(max_limit, "max-limit", 0, "mu", "Upper soft limit of the joint.", hal::must(places));
    double taper = pin(taper, "taper", 0, "1",
                       "Distance from a soft limit that the stage needs, as a multiple of the offset.",
                       hal::must({0, 100}));
    double max_offset =
        pin(max_offset, "max-offset", 500, "mu", "Largest offset either way.", hal::must(lengths));
    double max_rate =
        pin(max_rate, "max-rate", 500, "mu/s", "Fastest change of the offset.", hal::must(speeds));

    bool learn = pin(learn, "learn", false, "Correct the dead points by the measured ones.", hal::machine());
    double gain = pin(gain, "gain", 0.7, "1", "Part of a measured error that is corrected each cycle.",
                      hal::expert({0.01, 0.95}));
    double inset = pin(inset, "inset", 0.3, "mu",
                       "Largest distance inside the dead points at which learning begins; in the first cycle "
                       "of a new machine ten times as much.",
                       hal::machine(lengths));
    double max_correction = pin(max_correction, "max-correction", 1, "mu",
                                "Largest correction of a dead point, outward.", hal::expert(lengths));
    double tolerance =
        pin(tolerance, "tolerance", 0.002, "mu", "Error of a learned dead point.", hal::machine(lengths));
    double max_beyond = pin(max_beyond, "max-beyond", 0.005, "mu",
                            "Largest distance of the axis beyond a dead point.", hal::machine(lengths));
    double max_drift =
        pin(max_drift, "max-drift", 0.1, "mu", "Largest change of a correction since it was first learned.",
            hal::expert(lengths));
    double max_following_error =
        pin(max_following_error, "max-following-error", 0, "mu",
            "Largest distance of the axis from its command; 0 does not watch it.", hal::must(lengths));

    // The dead points as given.
    double low() const noexcept { return by_centre ? centre - stroke / 2 : lower; }
    double high() const noexcept { return by_centre ? centre + stroke / 2 : upper; }

    // Of a region, without override; mu/s.
    double peak_speed(double length) const noexcept {
        switch (speed_kind) {
            case 1: return Reciprocation::speed_of_mean(feed);
            case 2: return Reciprocation::speed_of_cycle(1 / frequency, length);
            case 3:
            case with_sections: return Reciprocation::speed_of_cycle(cycle_time, length);
            default: return feed;
        }
    }
    double largest_speed() const noexcept { return std::min(max_feed, max_rate - lead * max_acceleration); }

    Oscillation::Stop stop() const noexcept {
        switch (stop_kind) {
            case at_dead_point: return Oscillation::Stop::dead_point;
            case at_once: return Oscillation::Stop::at_once;
            case at_lower: return Oscillation::Stop::lower;
            case at_upper: return Oscillation::Stop::upper;
            default: return Oscillation::Stop::end_position;
        }
    }
    // After a number of strokes, which is never at once.
    Oscillation::Stop ending() const noexcept {
        return stop_kind == at_once ? Oscillation::Stop::dead_point : stop();
    }
    Oscillation::Stop hold() const noexcept {
        return hold_kind == at_end ? Oscillation::Stop::end_position : Oscillation::Stop::dead_point;
    }
    // The dead point that is clear of the work.
    Oscillation::Stop clear() const noexcept {
        return abort_kind == 1   ? Oscillation::Stop::lower
               : abort_kind == 2 ? Oscillation::Stop::upper
                                 : Oscillation::Stop::none;
    }

    SpeedSections::Table sections() const noexcept {
        SpeedSections::Table its = section;
        for (SpeedSection& each : its) {
            if (each.kind == SpeedSection::off) each = {};
            if (each.kind != SpeedSection::phase) continue;
            each.from *= pi / 180;
            each.to *= pi / 180;
        }
        return its;
    }
    bool even() const noexcept {
        return std::all_of(section.begin(), section.end(),
                           [](const SpeedSection& each) { return each.kind == SpeedSection::off; });
    }
    // S, at the lower and the upper dead point.
    std::array<double, 2> longest_waits() const noexcept {
        const double its = exact_stop > 0 ? exact_stop_time : 0;
        return {lower_dwell + its, upper_dwell + its};
    }

    // Between these dead points, at the full speed.
    Oscillation::Settings planned(double low, double high) const noexcept {
        Oscillation::Settings its;
        its.lower = low;
        its.upper = high;
        its.speed = peak_speed(high - low);
        its.timed = speed_kind >= 2;
        its.acceleration = max_acceleration;
        its.largest_speed = largest_speed();
        its.lower_dwell = lower_dwell;
        its.upper_dwell = upper_dwell;
        its.exact_stop = exact_stop > 0 ? exact_stop_time : 0;
        its.lowest = min_limit;
        its.highest = max_limit;
        its.strokes = strokes;
        its.spark_out = spark_out;
        its.upward_first = upward_first;
        its.ending = ending();
        its.clear = clear();
        its.sections = sections();
        return its;
    }

    std::size_t jerk_samples(double dt) const noexcept {
        return static_cast<std::size_t>(std::max(std::ceil(jerk_time / dt - 1e-9), 1.0));
    }
    // Mu/s2, the largest acceleration of a stroke of this length, at most.
    double demand(double length) const noexcept {
        const Reciprocation base{0, length, peak_speed(length)};
        return even() ? std::min(base.peak_acceleration(), max_acceleration) : max_acceleration;
    }
    double inset_of(double length) const noexcept { return std::min(inset, 0.05 * length); }

    // The length, to the way from the last change of speed to a dead point.
    double shortness(const Reciprocation& base, bool upward) const noexcept {
        const double end = upward ? base.upper : base.lower, length = base.stroke();
        double way = length;
        for (const SpeedSpan& each : SpeedSections::spans(sections(), base, upward))
            for (const double edge : {each.from, each.to})
                if (std::abs(edge - end) > length / 100) way = std::min(way, std::abs(edge - end));
        return length / way;
    }

    // How learning learns between these dead points.
    DeadPointLearning::Settings learned(double low, double high) const noexcept {
        const double length = high - low;
        const Oscillation::Settings its_stroke = planned(low, high);
        const Reciprocation base{low, high, its_stroke.speed};
        DeadPointLearning::Settings its;
        its.gain = gain;
        its.most = max_correction;
        its.tolerance = tolerance;
        its.most_beyond = max_beyond;
        its.inset = inset_of(length);
        its.demand = demand(length);
        its.reversal = {OscillationLeg::reversal(base, low, its_stroke),
                        OscillationLeg::reversal(base, high, its_stroke)};
        its.shortness = {shortness(base, false), shortness(base, true)};
        const bool crank = std::min(its.reversal[0], its.reversal[1]) >= base.peak_acceleration();
        its.stretching = !crank ? 0 : its_stroke.timed ? 1 : -1;
        its.even = even() && !(lower_dwell > 0 || upper_dwell > 0 || exact_stop > 0);
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
        for (const double value : {lower_dwell, upper_dwell, exact_stop}) number = number * 31 + whole(value);
        return number;
    }

    // As it is learned between these dead points: one number stands for its sections, dwells, command and
    // exact stop.
    LearnedStrokes::Stroke learned_stroke(double low, double high, const Command& command) const noexcept {
        std::uint32_t number = 0;
        for (const SpeedSection& each : sections())
            for (const double value :
                 {static_cast<double>(each.kind), each.from, each.to, each.ratio, lower_dwell, upper_dwell})
                number = number * 31 + whole(value);
        number = number * 31 + command.number();
        if (exact_stop > 0) number = number * 31 + whole(exact_stop);
        return {low, high, peak_speed(high - low), max_acceleration, static_cast<int>(number >> 1)};
    }

    // Whether each value alone is possible. False for NaN.
    bool possible(double dt) const noexcept {
        return in_range && jerk_time <= dt * static_cast<double>(JerkLimit::most) &&
               largest_speed() >= slowest && min_limit < max_limit && (override_ == 0 || override_ >= 0.01);
    }

    // Why a stroke between these dead points, from a position, is not possible.
    Fault refusal(double low, double high, double position, double dt) const noexcept {
        if (!possible(dt)) return Fault::settings;
        if (!(high - low > 1e-6 && low >= -farthest && high <= farthest)) return Fault::region;
        const double speed = peak_speed(high - low);
        if (!(speed_kind >= 0 && speed_kind <= with_sections && speed > 1e-6 &&
              speed <= largest_speed() * (1 + 1e-9)))
            return Fault::speed;
        const Reciprocation base{low, high, speed};
        const SpeedSections::Table its = sections();
        if (!SpeedSections::valid(its) || SpeedSections::overlap(its, base)) return Fault::sections;
        if (refuse_slower && base.peak_acceleration() > max_acceleration) return Fault::acceleration;
        if (!leads()) return Fault::lead;
        return fits(low, high, position) ? Fault::none : Fault::soft_limit;
    }

    // The lead adds its time, times the jerk 2 a / jerk-time, to the acceleration a.
    bool leads() const noexcept { return lead == 0 || (lead <= max_lead && leads(lead, jerk_time)); }
    // With the lead and the jerk-time of the command that runs.
    bool leads(double its_lead, double its_jerk_time) const noexcept {
        return its_lead == 0 || (its_jerk_time > 0 && max_acceleration * (1 + 2 * its_lead / its_jerk_time) <=
                                                          max_output_acceleration);
    }

    static constexpr hal::Range places{-farthest, farthest}, lengths{0, farthest}, speeds{slowest, 1e6},
        accelerations{1e-3, 1e9}, times{0, 3600}, lead_times{0, 1}, counts{0, 2147483647};

private:
    SpeedSections::Table section_pins() {
        static constexpr hal::Range kinds{SpeedSection::off, SpeedSection::height_downward},
            ratios{SpeedSections::least_ratio, SpeedSections::largest_ratio};
        for (std::size_t i = 0; i < sections_by_pins; ++i) {
            const std::string stem = "section-" + std::to_string(i);
            SpeedSection& its = section[i];
            unjudged(its.kind, stem + "-kind", 0,
                     "What its ends are: 0 none, 1 phases in deg, 2 heights, 3 heights upward, 4 heights "
                     "downward.",
                     hal::machine(kinds));
            unjudged(its.from, stem + "-from", 0, "1",
                     "Where the section begins: deg or machine units, by its kind.", hal::machine(places));
            unjudged(its.to, stem + "-to", 0, "1",
                     "Where the section ends: deg or machine units, by its kind.", hal::machine(places));
            unjudged(its.ratio, stem + "-ratio", 1, "1",
                     "Speed in the section, as a part of the speed without it.", hal::machine(ratios));
        }
        return {};
    }

    static std::uint32_t whole(double value) noexcept {
        return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::clamp(value, -1e6, 1e6) * 1e6));
    }

    bool fits(double low, double high, double position) const noexcept {
        const double overlead = max_acceleration * lead * lead / 2;
        const double more = (learn ? max_correction : 0) + overlead;
        const double up = std::max(high + more - position, 0.0), down = std::max(position - low + more, 0.0);
        return high + more <= max_limit && low - more >= min_limit && std::max(up, down) <= max_offset &&
               position + taper * up <= max_limit && position - taper * down >= min_limit;
    }
};

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
    void begin(const StrokeSettings& given) noexcept { values_ = given; }

    // For a start or a shift: the reason why not.
    Fault take(const StrokeSettings& given, double end, double dt) noexcept {
        const Fault reason = given.refusal(given.low(), given.high(), end, dt);
        if (reason == Fault::none) put(given, given.low(), given.high());
        return reason;
    }

    // For a way to the end from rest: false if neither the given settings nor the last ones permit it.
    bool take_end(const StrokeSettings& given, double end, double dt) noexcept {
        const bool takes = given.possible(dt) && given.leads();
        if (!takes && !(values_.possible(dt) && values_.leads())) return false;
        put(takes ? given : values_, end, end);
        return true;
    }

    // Takes over settings, of which one has `changed`, for the present region; whether a stroke does. This
    // takes longer than all else, so it is done only where something has changed.
    bool judge(const StrokeSettings& given, bool changed, const Place& place, double dt) noexcept {
        const bool same = judged_.lower == lower_ && judged_.upper == upper_ && judged_.end == place.end &&
                          judged_.running == place.running;
        if (same && !changed) return false;
        judged_ = {lower_, upper_, place.end, place.running};
        refused_ = given.possible(dt) ? Fault::none : Fault::settings;
        if (!place.running) {
            if (refused_ == Fault::none && !given.leads()) refused_ = Fault::lead;
            if (refused_ == Fault::none) put(given, lower_, upper_);
            return false;
        }
        if (!(upper_ > lower_)) return false;
        refused_ = given.refusal(lower_, upper_, place.end, dt);
        if (refused_ == Fault::none && !given.leads(place.lead, place.jerk_time)) refused_ = Fault::lead;
        if (refused_ == Fault::none) put(given, lower_, upper_);
        return refused_ == Fault::none;
    }

    const StrokeSettings& values() const noexcept { return values_; }
    Fault refused() const noexcept { return refused_; }          // the settings given last
    std::uint32_t changes() const noexcept { return changes_; }  // of all that stroke() depends on

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
        ++changes_;
    }
    // Multiplies the speed, so that a cycle takes its time.
    void stretch(double ratio) noexcept {
        if (!(std::abs(ratio - 1) > 1e-3)) return;
        stretch_ = std::clamp(stretch_ * ratio, 0.1, 10.0);
        ++changes_;
    }

    // Of the next stroke, mu/s, where learning permits a part of it.
    double speed(double part) const noexcept {
        const double whole = upper_ > lower_ ? values_.peak_speed(upper_ - lower_) : values_.largest_speed();
        return whole * stretch_ * (values_.override_ > 0 ? values_.override_ : 1) * part;
    }

    // For the next stroke.
    Oscillation::Settings stroke(double part, double end) const noexcept {
        Oscillation::Settings its = values_.planned(lower_, upper_);
        its.end_position = end;
        its.speed = speed(part);
        return its;
    }

private:
    void put(const StrokeSettings& given, double lower, double upper) noexcept {
        values_ = given;
        lower_ = lower;
        upper_ = upper;
        ++changes_;
    }

    // When the last settings were judged.
    struct Judged {
        double lower = 0, upper = 0, end = 0;
        bool running = false;
    };

    StrokeSettings values_;
    StrokeSettings::Command command_;  // of the strokes that run, or that ran last
    Judged judged_;
    double lower_ = 0, upper_ = 0;
    double stretch_ = 1;
    Fault refused_ = Fault::none;
    std::uint32_t changes_ = 0;
};

}  // namespace plumb
