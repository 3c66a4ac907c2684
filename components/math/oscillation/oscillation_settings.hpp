// SPDX-License-Identifier: GPL-2.0-or-later
// A stroke as it is asked for: the harmonic motion between two dead points, sections with a speed of their
// own, and the settings of strokes.
#pragma once

#include "components/math/blocks/pi.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

namespace plumb {

// Harmonic reciprocation between two dead points, governed by its phase: 0 at the lower, pi at the upper dead
// point, 0 to pi upward, pi to 2 pi downward.
//
//     Z = lower + S sin^2(phase / 2)    v = F sin(phase)    d(phase)/dt = 2 F / S    T = pi S / F
//
// S = upper - lower > 0, mu; F > 0 is the peak speed, mu/s.
struct Reciprocation {
    double lower = 0, upper = 0;  // mu
    double speed = 0;             // mu/s, F

    double stroke() const noexcept { return upper - lower; }
    double position(double phase) const noexcept {
        const double s = std::sin(phase / 2);
        return lower + stroke() * s * s;
    }
    // Rad, 0 to 2 pi. A position beyond a dead point counts as the dead point.
    double phase(double position, bool upward) const noexcept {
        const double up = 2 * std::atan2(std::sqrt(std::max(position - lower, 0.0)),
                                         std::sqrt(std::max(upper - position, 0.0)));
        return upward ? up : 2 * pi - up;
    }
    // mu2/s2, the square of the speed at a position; 0 beyond a dead point.
    double speed_squared(double position) const noexcept {
        const double part = (position - lower) / stroke();
        return 4 * speed * speed * std::max(part * (1 - part), 0.0);
    }
    double peak_acceleration() const noexcept { return 2 * speed * speed / stroke(); }
    double cycle_time() const noexcept { return pi * stroke() / speed; }

    // The speeds F of a mean speed, and of a time for one cycle.
    static double speed_of_mean(double mean) noexcept { return mean * pi / 2; }
    static double speed_of_cycle(double time, double stroke) noexcept { return pi * stroke / time; }
};

// A part of the stroke with a speed of its own, [from, to).
struct SpeedSection {
    // What from and to are. A phase section may wrap through 2 pi; heights hold for one direction or both.
    enum Kind : std::int32_t { off, phase, height, height_upward, height_downward };

    std::int32_t kind = off;
    double from = 0, to = 0;  // rad, 0 to 2 pi; or mu, from < to
    double ratio = 1;         // of the speed there to the speed without sections

    bool operator==(const SpeedSection& other) const noexcept {
        return kind == other.kind && from == other.from && to == other.to && ratio == other.ratio;
    }
};

// A piece of a stroke in one direction.
struct SpeedSpan {
    double from = 0, to = 0;  // mu, from < to
    double ratio = 1;

    bool operator==(const SpeedSpan& other) const noexcept {
        return from == other.from && to == other.to && ratio == other.ratio;
    }
};

// Up to four sections, and the pieces that they make of a stroke.
class SpeedSections {
public:
    static constexpr std::size_t most = 4;
    static constexpr std::size_t most_spans = 2 * most;  // a section that wraps is two pieces
    static constexpr double least_ratio = 1e-3, largest_ratio = 1e3;
    using Table = std::array<SpeedSection, most>;

    struct Spans {
        std::array<SpeedSpan, most_spans> list;  // ascending, disjoint
        std::size_t count = 0;

        const SpeedSpan* begin() const noexcept { return list.data(); }
        const SpeedSpan* end() const noexcept { return list.data() + count; }
        bool operator==(const Spans& other) const noexcept {
            return count == other.count && std::equal(begin(), end(), other.begin());
        }
    };

    // The pieces of an upward or a downward stroke. Requires sections that are valid one by one.
    static Spans spans(const Table& table, const Reciprocation& base, bool upward) noexcept {
        Spans result;
        const auto add = [&](double from, double to, double ratio) {
            from = std::max(from, base.lower);
            to = std::min(to, base.upper);
            if (!(from < to) || result.count == most_spans) return;
            std::size_t place = result.count++;
            for (; place > 0 && result.list[place - 1].from > from; --place)
                result.list[place] = result.list[place - 1];
            result.list[place] = {from, to, ratio};
        };
        // Of phases 0 <= from < to <= 2 pi.
        const auto add_phases = [&](double from, double to, double ratio) {
            const double low = upward ? from : 2 * pi - to, high = upward ? to : 2 * pi - from;
            if (low < pi) add(base.position(std::max(low, 0.0)), base.position(std::min(high, pi)), ratio);
        };
        for (const SpeedSection& each : table) {
            switch (each.kind) {
                case SpeedSection::phase:
                    if (each.from < each.to) {
                        add_phases(each.from, each.to, each.ratio);
                    } else {
                        add_phases(each.from, 2 * pi, each.ratio);
                        add_phases(0, each.to, each.ratio);
                    }
                    break;
                case SpeedSection::height: add(each.from, each.to, each.ratio); break;
                case SpeedSection::height_upward:
                    if (upward) add(each.from, each.to, each.ratio);
                    break;
                case SpeedSection::height_downward:
                    if (!upward) add(each.from, each.to, each.ratio);
                    break;
                default: break;
            }
        }
        return result;
    }

    // Whether each section alone is possible, whatever the region. False for NaN too.
    static bool valid(const Table& table) noexcept {
        return std::all_of(table.begin(), table.end(), [](const SpeedSection& each) {
            if (each.kind == SpeedSection::off) return true;
            if (!(each.ratio >= least_ratio && each.ratio <= largest_ratio)) return false;
            if (each.kind == SpeedSection::phase)
                return each.from >= 0 && each.from <= 2 * pi && each.to >= 0 && each.to <= 2 * pi &&
                       each.from != each.to;
            return each.kind >= SpeedSection::height && each.kind <= SpeedSection::height_downward &&
                   each.from < each.to && each.from >= -1e9 && each.to <= 1e9;
        });
    }

    // Whether two pieces of a stroke share more than rounding.
    static bool overlap(const Table& table, const Reciprocation& base) noexcept {
        const double slack = 1e-9 * base.stroke();
        for (const bool upward : {false, true}) {
            const Spans its = spans(table, base, upward);
            for (std::size_t i = 1; i < its.count; ++i)
                if (its.list[i].from < its.list[i - 1].to - slack) return true;
        }
        return false;
    }

    // The pieces of a phase section at a dead point make this the ratio there.
    static double ratio_at(const Spans& spans, double position) noexcept {
        for (const SpeedSpan& each : spans)
            if (position >= each.from && position <= each.to) return each.ratio;
        return 1;
    }
};

// What an oscillation is to do. All positions are in mu.
struct OscillationSettings {
    // dead_point: the next one. withdraw: at the dead point nearest the end position, then to the end
    // position, without spark-out. leave: the same by the dead point that is clear of the work; an axis that
    // moves away from it turns back at once.
    enum class Stop { none, dead_point, end_position, at_once, withdraw, leave, lower, upper };

    double lower = 0, upper = 0;    // dead points, lower < upper
    double speed = 0;               // mu/s, peak, with the override
    double acceleration = 0;        // mu/s2, the largest
    double braking = 1;             // the part of it that brakes, and ends any other motion
    double end_acceleration = 1e9;  // mu/s2, the largest on the way to the end position
    double largest_speed = 0;       // mu/s
    double caution = 0;             // mu, by which a stroke ends inside for which no end was learned
    double lower_dwell = 0, upper_dwell = 0;  // s
    double exact_stop = 0;           // s, the longest wait for the axis at a dead point, before its dwell
    double lowest = 0, highest = 0;  // soft limits
    double end_position = 0;
    std::int32_t strokes = 0;    // 0: until stopped
    std::int32_t spark_out = 0;  // strokes after that
    int learned = 0;             // number of the stroke for which its ends are learned
    bool upward_first = false;
    bool timed = false;                // a stroke keeps its time where its ends are learned, not its speed
    Stop ending = Stop::end_position;  // after the last stroke; a dead point or end_position
    Stop clear = Stop::none;           // the dead point that is clear of the work: lower or upper
    SpeedSections::Table sections{};

    bool operator==(const OscillationSettings& other) const noexcept {
        const auto all = [](const OscillationSettings& its) {
            return std::tie(its.lower, its.upper, its.speed, its.acceleration, its.braking,
                            its.end_acceleration, its.largest_speed, its.caution, its.lower_dwell,
                            its.upper_dwell, its.exact_stop, its.lowest, its.highest, its.end_position,
                            its.strokes, its.spark_out, its.learned, its.upward_first, its.timed, its.ending,
                            its.clear, its.sections);
        };
        return all(*this) == all(other);
    }
};

}  // namespace plumb
