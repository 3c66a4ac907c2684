// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/stroke_values.hpp"
#include "components/math/blocks/pi.hpp"
#include "hal/component.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

// One section of the stroke.
struct SectionPins final : hal::Group {
    static constexpr hal::Range kinds{SpeedSection::off, SpeedSection::height_downward},
        ends{-StrokeValues::farthest, StrokeValues::farthest},
        ratios{SpeedSections::least_ratio, SpeedSections::largest_ratio};

    SectionPins(hal::Owner owner, const std::string& stem)
        : Group(owner),
          kind{owner, stem + "-kind", 0,
               "What its ends are: 0 none, 1 phases in deg, 2 heights, 3 heights upward, 4 heights downward.",
               hal::machine(kinds)},
          from{owner,
               stem + "-from",
               0,
               "1",
               "Where the section begins: deg or machine units, by its kind.",
               hal::machine(ends)},
          to{owner,
             stem + "-to",
             0,
             "1",
             "Where the section ends: deg or machine units, by its kind.",
             hal::machine(ends)},
          ratio{owner,
                stem + "-ratio",
                1,
                "1",
                "Speed in the section, as a part of the speed without it.",
                hal::machine(ratios)} {}

    SpeedSection read() const noexcept {
        const std::int32_t its_kind = kind;
        const double scale = its_kind == SpeedSection::phase ? pi / 180 : 1, begin = from, end = to;
        return its_kind == SpeedSection::off ? SpeedSection{}
                                             : SpeedSection{its_kind, begin * scale, end * scale, ratio};
    }

    hal::In<std::int32_t> kind;
    hal::In<double> from, to, ratio;
};

// The settings of a stroke.
struct ChoppingSettings final : hal::Group {
    ChoppingSettings(hal::Owner owner, std::size_t sections)
        : Group(owner), section(this, sections, "section") {}

    static constexpr double farthest = StrokeValues::farthest;  // mu
    static constexpr hal::Range places{-farthest, farthest}, lengths{0, farthest},
        speeds{StrokeValues::slowest, 1e6};
    static constexpr hal::Range accelerations{1e-3, 1e9}, times{0, 3600}, wait_times{0.001, 10},
        lead_times{0, 1}, gains{0.01, 0.95}, frequencies{0, 1000};
    static constexpr hal::Range overrides{0, 2}, stop_kinds{0, 4}, hold_kinds{0, 1}, abort_kinds{0, 2},
        tapers{0, 100}, speed_kinds{0, StrokeValues::with_sections}, counts{0, 2147483647};

    hal::In<double> upper{this, "upper", 0, "mu", "Upper dead point, in the frame of position."};
    hal::In<double> lower{this, "lower", 0, "mu", "Lower dead point, in the frame of position."};
    hal::In<bool> by_centre{this, "by-centre", false, "Centre and stroke give the dead points.",
                            hal::machine()};
    hal::In<double> centre{this, "centre", 0, "mu", "Middle of the stroke.", hal::machine(places)};
    hal::In<double> stroke{this, "stroke", 0, "mu", "Distance of the dead points.", hal::machine(lengths)};
    hal::In<std::int32_t> speed_kind{
        this, "speed-kind", 0,
        "What gives the speed: 0 feed at its peak, 1 mean feed, 2 frequency, 3 cycle-time, 4 cycle-time with "
        "sections and dwells.",
        hal::machine(speed_kinds)};
    hal::In<double> feed{this, "feed", 0, "mu/s", "Speed of the stroke, without sections."};
    hal::In<double> frequency{
        this, "frequency", 0, "Hz", "Cycles a second, without sections.", hal::machine(frequencies)};
    hal::In<double> cycle_time{this, "cycle-time", 0, "s", "Time of both strokes.", hal::machine(times)};
    hal::In<double> override_{this,     "override", 1, "1", "Multiplies the speed, from 0.01 on; 0 holds.",
                              overrides};
    hal::In<double> lower_dwell{
        this, "lower-dwell", 0, "s", "Rest at the lower dead point.", hal::machine(times)};
    hal::In<double> upper_dwell{
        this, "upper-dwell", 0, "s", "Rest at the upper dead point.", hal::machine(times)};
    hal::In<double> exact_stop{
        this,
        "exact-stop",
        0,
        "mu",
        "The dwell begins when the measured axis is as near to its dead point; 0 does not wait for it.",
        hal::machine(lengths)};
    hal::In<double> exact_stop_time{this,
                                    "exact-stop-time",
                                    0.2,
                                    "s",
                                    "Longest time for which a dead point waits for the axis.",
                                    hal::expert(wait_times)};
    hal::In<std::int32_t> strokes{this, "strokes", 0, "Strokes to make; 0 until run is false.",
                                  hal::machine(counts)};
    hal::In<std::int32_t> spark_out{this, "spark-out", 0,
                                    "Strokes without infeed before the stop, unless that is at once.",
                                    hal::machine(counts)};
    hal::In<std::int32_t> stop_kind{
        this, "stop-kind", 0,
        "Stop: 0 at the next dead point, then to position; 1 at the next dead point; 2 at once; 3 at the "
        "lower, 4 at the upper dead point.",
        hal::machine(stop_kinds)};
    hal::In<bool> upward_first{this, "upward-first", false,
                               "The first stroke is upward, where the axis starts between the dead points.",
                               hal::machine()};
    hal::In<std::int32_t> hold_kind{this, "hold-kind", 1,
                                    "Hold: 0 at the next dead point, then to position; 1 at the next dead "
                                    "point. emergency-hold holds at once.",
                                    hal::machine(hold_kinds)};
    hal::In<std::int32_t> abort_kind{this, "abort-kind", 0,
                                     "Abort, end of the program, enable false or a stopped wheel: 0 by the "
                                     "dead point nearest position; by the "
                                     "one that is clear of the work, 1 lower, 2 upper, at once.",
                                     hal::machine(abort_kinds)};
    hal::In<bool> without_wheel{this, "without-wheel", false,
                                "Strokes need no turning spindle: to dress or set up, or for a planer.",
                                hal::machine()};
    hal::In<double> at_speed_time{this,
                                  "at-speed-time",
                                  0.2,
                                  "s",
                                  "Longest time for which the spindle may be below its speed in strokes.",
                                  hal::machine(times)};
    hal::In<bool> refuse_slower{this, "refuse-slower", false,
                                "Refuse a stroke that max-acceleration makes slower, and do not limit it.",
                                hal::machine()};
    hal::Row<SectionPins> section;

    hal::In<double> max_feed{
        this, "max-feed", 500, "mu/s", "Largest speed of the stroke.", hal::must(speeds)};
    hal::In<double> max_acceleration{this,
                                     "max-acceleration",
                                     1000,
                                     "mu/s2",
                                     "Largest acceleration of the stroke.",
                                     hal::must(accelerations)};
    hal::In<double> jerk_time{this,
                              "jerk-time",
                              0,
                              "s",
                              "The jerk is at most 2 max-acceleration / jerk-time; 0 does not limit it.",
                              hal::must(times)};
    hal::In<double> lead{this,
                         "lead",
                         0,
                         "s",
                         "The command leads by this time; below 0.8 / Kv of the drive.",
                         hal::machine(lead_times)};
    hal::In<double> max_lead{this, "max-lead", 0.02, "s", "Largest lead.", hal::expert(lead_times)};
    hal::In<double> max_output_acceleration{this,
                                            "max-output-accel",
                                            3000,
                                            "mu/s2",
                                            "Largest acceleration of the command, with the lead.",
                                            hal::machine(accelerations)};
    hal::In<double> min_limit{
        this, "min-limit", 0, "mu", "Lower soft limit of the joint.", hal::must(places)};
    hal::In<double> max_limit{
        this, "max-limit", 0, "mu", "Upper soft limit of the joint.", hal::must(places)};
    hal::In<double> taper{this,
                          "taper",
                          0,
                          "1",
                          "Distance from a soft limit that the stage needs, as a multiple of the offset.",
                          hal::must(tapers)};
    hal::In<double> max_offset{
        this, "max-offset", 500, "mu", "Largest offset either way.", hal::must(lengths)};
    hal::In<double> max_rate{
        this, "max-rate", 500, "mu/s", "Fastest change of the offset.", hal::must(speeds)};

    hal::In<bool> learn{this, "learn", false, "Correct the dead points by the measured ones.",
                        hal::machine()};
    hal::In<double> gain{
        this, "gain", 0.7, "1", "Part of a measured error that is corrected each cycle.", hal::expert(gains)};
    hal::In<double> inset{
        this,
        "inset",
        0.3,
        "mu",
        "Largest distance inside the dead points at which learning begins; in the first cycle "
        "of a new machine ten times as much.",
        hal::machine(lengths)};
    hal::In<double> max_correction{this,
                                   "max-correction",
                                   1,
                                   "mu",
                                   "Largest correction of a dead point, outward.",
                                   hal::expert(lengths)};
    hal::In<double> tolerance{
        this, "tolerance", 0.002, "mu", "Error of a learned dead point.", hal::machine(lengths)};
    hal::In<double> max_beyond{this,
                               "max-beyond",
                               0.005,
                               "mu",
                               "Largest distance of the axis beyond a dead point.",
                               hal::machine(lengths)};
    hal::In<double> max_drift{this,
                              "max-drift",
                              0.1,
                              "mu",
                              "Largest change of a correction since it was first learned.",
                              hal::expert(lengths)};
    hal::In<double> max_following_error{this,
                                        "max-following-error",
                                        0,
                                        "mu",
                                        "Largest distance of the axis from its command; 0 does not watch it.",
                                        hal::must(lengths)};

    StrokeValues read() noexcept {
        StrokeValues now;
        hal::SettingsReader setting;
        const bool centred = by_centre;
        const double middle = centre, length = stroke, low = lower, high = upper;
        now.lower = centred ? middle - length / 2 : low;
        now.upper = centred ? middle + length / 2 : high;
        now.speed_kind = speed_kind;
        const double given_feed = feed, given_frequency = frequency, given_time = cycle_time;
        now.speed_value = now.speed_kind == 2   ? given_frequency
                          : now.speed_kind >= 3 ? given_time
                                                : given_feed;
        now.stroke.timed = now.speed_kind >= 2;
        now.override_value = setting(override_);
        now.stroke.lower_dwell = setting(lower_dwell);
        now.stroke.upper_dwell = setting(upper_dwell);
        now.stroke.strokes = setting(strokes);
        now.stroke.spark_out = setting(spark_out);
        now.stroke.upward_first = upward_first;
        now.set_stop_kind(setting(stop_kind));
        now.hold_kind = setting(hold_kind);
        now.set_abort_kind(setting(abort_kind));
        now.without_wheel = without_wheel;
        now.at_speed_time = setting(at_speed_time);
        now.refuse_slower = refuse_slower;
        now.exact_stop = setting(exact_stop);
        now.stroke.exact_stop = setting(exact_stop_time);
        for (std::size_t i = 0; i < section.size(); ++i) now.stroke.sections[i] = section[i].read();
        const double rate = setting(max_rate), feed_limit = max_feed;
        now.max_rate = rate;
        now.stroke.acceleration = setting(max_acceleration);
        now.jerk_time = setting(jerk_time);
        now.lead = setting(lead);
        now.max_lead = setting(max_lead);
        now.max_output_acceleration = setting(max_output_acceleration);
        now.stroke.largest_speed = std::min(feed_limit, rate - now.lead * now.stroke.acceleration);
        now.stroke.lowest = setting(min_limit);
        now.stroke.highest = setting(max_limit);
        now.taper = setting(taper);
        now.max_offset = setting(max_offset);
        now.learn = learn;
        now.learning.gain = setting(gain);
        now.inset = setting(inset);
        now.learning.most = setting(max_correction);
        now.learning.tolerance = setting(tolerance);
        now.learning.most_beyond = setting(max_beyond);
        now.max_drift = setting(max_drift);
        now.max_following_error = setting(max_following_error);
        now.in_range = setting.good();
        return now;
    }
};

}  // namespace plumb
