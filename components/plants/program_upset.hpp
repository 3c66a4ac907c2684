// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/random.hpp"

#include <algorithm>
#include <cstdint>

namespace plumb {

// What may go otherwise than the program has it.
enum class Event : std::int32_t {
    none,
    air_cut,
    chip,
    stock,
    wrong_part,
    wrong_tool_length,
    feed_override,
    feed_hold,
    spindle_override,
    speed_change,
    abort,
    edited,
};
inline constexpr int event_count = 11;

// Lasts from the first operation of its cycle to the last?  The others concern one operation, or one tool.
inline bool concerns_cycle(Event event) noexcept {
    return event == Event::stock || event == Event::wrong_part || event == Event::abort ||
           event == Event::edited;
}

// How much: a height in millimetres (a chip's, of the work, of the tool's length, of the edit), signed but
// for a chip. The size is drawn from `smallest` to what such an event has at most, or to `largest` where that
// is above 0.
inline double drawn_height(Event event, double smallest, double largest, Random& random) noexcept {
    const double usual = event == Event::chip                ? 0.5
                         : event == Event::stock             ? 0.3
                         : event == Event::wrong_part        ? 5
                         : event == Event::wrong_tool_length ? 2
                         : event == Event::edited            ? 1
                                                             : 0;
    const double most = usual > 0 && largest > 0 ? largest : usual;
    const double size = random.uniform(std::min(smallest, most), most);
    return event != Event::chip && random.uniform() < 0.5 ? -size : size;
}

// A factor for feed or speed, 0.5 to 1.2 but not within a twentieth of 1.
inline double drawn_factor(Random& random) noexcept {
    const double x = random.uniform(0.5, 1.1);
    return x < 0.95 ? x : x + 0.1;
}

}  // namespace plumb
