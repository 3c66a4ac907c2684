// SPDX-License-Identifier: GPL-2.0-or-later
// Events that upset a part program, and the pins that set them.
#pragma once

#include "components/math/blocks/usable.hpp"
#include "components/plants/sim_part_program/part_program.hpp"
#include "hal/component.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace plumb {

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

constexpr const char* sentence(Event event) {
    switch (event) {
        case Event::air_cut: return "An operation has no work.";
        case Event::chip: return "A chip lies on the work.";
        case Event::stock: return "The blank has another height.";
        case Event::wrong_part: return "The blank is of another part.";
        case Event::wrong_tool_length: return "A tool length is wrong.";
        case Event::feed_override: return "The feed override changes.";
        case Event::feed_hold: return "A feed hold stops the plunge for 3 s.";
        case Event::spindle_override: return "The spindle override changes.";
        case Event::speed_change: return "The speed changes on approach.";
        case Event::abort: return "The program is aborted.";
        case Event::edited: return "The program is edited.";
        default: return nullptr;
    }
}

// One event of one cycle.
struct Upset {
    Event kind = Event::none;
    std::size_t operation = 0;  // which it concerns, unless it concerns the cycle or a tool
    double height = 0;          // mm: of a chip, of the work, of a tool's length, of an edit
    double factor = 1;          // on feed or speed
    double place = 0;           // mm above the work, at its begin

    bool is(Event event, const PartProgram& program, std::size_t now) const noexcept {
        if (kind != event) return false;
        switch (kind) {
            case Event::none: return false;
            case Event::stock:
            case Event::wrong_part:
            case Event::edited: return true;
            case Event::wrong_tool_length: return program[now].tool == program[operation].tool;
            default: return now == operation;
        }
    }
};

class Upsets final : public hal::Group {
public:
    using Group::Group;

    // For a cycle, numbered from 1. Always draws as many numbers, so that one setting does not change the
    // draws of another.
    Upset draw(const PartProgram& program, std::int32_t cycle, bool learning, Random& random) noexcept {
        const bool happens = random.uniform() < rate_ && !learning;
        const int drawn = 1 + random.index(event_count);
        const auto count = static_cast<int>(program.size());
        const std::int32_t named = event_, only = cycle_, key = operation_;
        const bool forced = named >= 1 && named <= event_count && (only == 0 || only == cycle);

        Upset upset;
        upset.kind = static_cast<Event>(forced ? named : happens ? drawn : 0);
        upset.operation = static_cast<std::size_t>(random.index(count));
        const double size = random.uniform(), sign = random.uniform();
        upset.height = drawn_height(upset.kind, size, sign);
        upset.factor = random.uniform(0.5, 1.1);
        if (upset.factor > 0.95) upset.factor += 0.1;  // to 1.2, but never close to 1
        upset.place = upset.kind == Event::speed_change ? random.uniform(0.2, 1) : random.uniform(-1, 4);

        for (std::size_t i = program.size(); i-- > 0;)
            if (program[i].key == key) upset.operation = i;
        const double height = usable(height_, 10, 0), factor = usable(factor_, 2, 0);
        if (height != 0) upset.height = height;
        if (factor > 0) upset.factor = factor;
        return upset;
    }

private:
    double drawn_height(Event kind, double size, double sign) const noexcept {
        const double usual = kind == Event::chip                ? 0.5
                             : kind == Event::stock             ? 0.3
                             : kind == Event::wrong_part        ? 5
                             : kind == Event::wrong_tool_length ? 2
                                                                : 1;
        const double asked = usable(largest_, 10, 0);
        const double most = asked > 0 ? asked : usual;
        const double least = std::clamp(usable(smallest_, 10, 0.1), 0.0, most);
        const double drawn = least + (most - least) * size;
        return kind != Event::chip && sign < 0.5 ? -drawn : drawn;
    }

    const hal::In<double> rate_{this, "event-rate", 0, "1",
                                "Probability that an event upsets a cycle, 0 to 1."};
    const hal::In<std::int32_t> event_{this, "event", 0,
                                       "Number of an event to cause; 0 leaves it to event-rate."};
    const hal::In<std::int32_t> cycle_{this, "event-cycle", 0,
                                       "Cycle that event upsets, from 1; 0 for every one."};
    const hal::In<std::int32_t> operation_{this, "event-operation", 0,
                                           "Operation that an event upsets; 0 draws it."};
    const hal::In<double> height_{this, "event-height", 0, "mu", "Height of an event; 0 draws it."};
    const hal::In<double> factor_{this, "event-factor", 0, "1", "Factor of an event; 0 draws it."};
    const hal::In<double> smallest_{this, "event-smallest", 0.1, "mu", "Smallest height that is drawn."};
    const hal::In<double> largest_{this, "event-largest", 0, "mu",
                                   "Largest height that is drawn; 0 for the usual one."};
};

}  // namespace plumb
