// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

enum class ChoppingStatus : std::int32_t {
    strokes = hal::first_own,
    bounded,
    with_fault,
    hold_ordered,
    held,
    held_by_speed,
    ends,
    returns,
    stopped,
    away_off,
    away,
    at_rest,
    stands_off,
    place_lost
};

constexpr hal::Said said(ChoppingStatus status) {
    using hal::Kind;
    using S = ChoppingStatus;
    switch (status) {
        case S::strokes: return {Kind::good, "The axis strokes.", "", {}, "stroke-count"};
        case S::bounded:
            return {Kind::warn,
                    "The axis strokes, and a bound is active.",
                    "Wait while it learns. Else change the stroke, or the limit that is given.",
                    {},
                    "limited-code"};
        case S::with_fault:
            return {Kind::bad, "The axis strokes with a fault.", "Stop the strokes, and remove the cause.",
                    hal::Button::stop, "fault-code"};
        case S::hold_ordered:
            return {Kind::warn, "A hold is ordered: the axis goes on to where it will stand.",
                    "End the hold, and the strokes go on.", hal::Button::hold};
        case S::held:
            return {Kind::warn, "Held: the axis stands away from point R, and goes on after the hold.",
                    "End the hold, or stop the strokes.", hal::Button::hold, "offset"};
        case S::held_by_speed:
            return {Kind::warn,
                    "Held by the speed 0: the axis stands, and goes on with the speed.",
                    "Raise the override.",
                    {},
                    "offset"};
        case S::ends:
            return {Kind::warn, "The strokes end. Moves of a program wait until then.",
                    "Wait. Jogs do not wait: jog another axis, not this one."};
        case S::returns:
            return {Kind::warn, "The axis is on its way to point R.",
                    "Wait. Jogs do not wait: jog another axis, not this one."};
        case S::stopped:
            return {Kind::bad, "Stopped by a fault, away from point R.",
                    "Remove the cause, then move the axis to point R. Jog another axis, not this one.",
                    hal::Button::to_end, "fault-code"};
        case S::away_off:
            return {Kind::warn,
                    "The machine is off, and the axis stands away from point R.",
                    "Turn the machine on, then move the axis to point R.",
                    {},
                    "offset"};
        case S::away:
            return {Kind::warn, "The axis stands away from point R.", "Move the axis to point R.",
                    hal::Button::to_end, "offset"};
        case S::stands_off:
            return {Kind::warn, "The axis stands away from where the stroke began.",
                    "Jog it clear, or start strokes from here.", hal::Button::start, "stands-off-by"};
        case S::place_lost:
            return {Kind::bad,
                    "The place of the axis is unknown, and nothing moves it.",
                    "Check encoder and supply. Then turn the machine off, unhome the joint, and home it.",
                    {},
                    "fault-code"};
        case S::at_rest:
            return {Kind::off, "At rest at point R.", "G81.1 or Start begins strokes.", hal::Button::start};
        default: return hal::said(static_cast<hal::Common>(status));
    }
}

struct ChoppingSeen {
    bool fault = false, bounded = false;
    bool moves = false, returns = false, ends = false, held = false, hold_ordered = false, speed_zero = false;
    bool away = false;        // from point R, at rest
    bool stands_off = false;  // from the former point R, where machine off has ended strokes
    bool place_known = true;
    bool on = false, homed = false, permitted = false;
    ChoppingStatus interlock{};
};

inline ChoppingStatus status_of(const ChoppingSeen& its) noexcept {
    using S = ChoppingStatus;
    if (!its.place_known) return S::place_lost;
    if (its.moves)
        return hal::first<S>({{its.held && its.hold_ordered, S::held},
                              {its.held && its.speed_zero, S::held_by_speed},
                              {its.returns, S::returns},
                              {its.ends, S::ends},
                              {its.fault, S::with_fault},
                              {its.hold_ordered || its.speed_zero, S::hold_ordered},
                              {its.interlock != S{}, its.interlock},
                              {its.bounded, S::bounded},
                              {true, S::strokes}});
    if (its.away) return its.fault ? S::stopped : its.on ? S::away : S::away_off;
    return hal::first<S>({{its.fault, hal::common<S>(hal::Common::fault)},
                          {its.stands_off && its.on, S::stands_off},
                          {its.interlock != S{}, its.interlock},
                          {!its.on, hal::common<S>(hal::Common::machine_off)},
                          {!its.homed, hal::common<S>(hal::Common::not_homed)},
                          {!its.permitted, hal::common<S>(hal::Common::off)},
                          {true, S::at_rest}});
}

}  // namespace plumb
