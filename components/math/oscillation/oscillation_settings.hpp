// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/oscillation/speed_sections.hpp"

#include <cstdint>
#include <tuple>

namespace plumb {

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
