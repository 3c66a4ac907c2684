// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/axis_growth/probed_reference.hpp"
#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

namespace axis_growth {

enum class Fault : std::int32_t { none, position, speed, settings };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::position: return "A position is invalid or beyond 1e6; its last good value is used.";
        case Fault::speed: return "The spindle speed is invalid or beyond 1e6; its last good value is used.";
        case Fault::settings: return "The settings are out of range; the last good set stays in force.";
        default: return nullptr;
    }
}

enum class Doubt : std::int32_t {
    none,
    sensor,
    old,
    range,
    uncertain,
    temperature_0,
    temperature_1,
    temperature_2,
    temperature_3,
    moved,
    revoked
};
// Of a sensor that contradicts the others.
constexpr Doubt contradiction(int sensor) noexcept {
    return static_cast<Doubt>(static_cast<int>(Doubt::temperature_0) + sensor);
}
constexpr const char* sentence(Doubt doubt) {
    switch (doubt) {
        case Doubt::sensor:
            return "A temperature is invalid: its last good value holds, and the offset returns to 0 after "
                   "hold-time.";
        case Doubt::old: return "A temperature has been invalid for hold-time: the offset returns to 0.";
        case Doubt::range:
            return "A temperature is outside the range of the growth test: the growth may be wrong by more "
                   "than "
                   "is harmless.";
        case Doubt::uncertain:
            return "The growth may be wrong by more than is harmless. A growth test on another day makes its "
                   "law "
                   "more certain.";
        case Doubt::temperature_0:
            return "Temperature 0 contradicts the other temperatures and the spindle speed. An offset by it "
                   "holds, "
                   "and returns to 0 after hold-time.";
        case Doubt::temperature_1:
            return "Temperature 1 contradicts the other temperatures and the spindle speed. An offset by it "
                   "holds, "
                   "and returns to 0 after hold-time.";
        case Doubt::temperature_2:
            return "Temperature 2 contradicts the other temperatures and the spindle speed. An offset by it "
                   "holds, "
                   "and returns to 0 after hold-time.";
        case Doubt::temperature_3:
            return "Temperature 3 contradicts the other temperatures and the spindle speed. An offset by it "
                   "holds, "
                   "and returns to 0 after hold-time.";
        case Doubt::moved:
            return "The touches of the reference do not agree, or no growth explains them: the bore or the "
                   "probe may have moved.";
        case Doubt::revoked:
            return "The touches of the reference show more error with the law of growth than without it. "
                   "The law of this axis is revoked. Repeat the growth test.";
        default: return nullptr;
    }
}

constexpr const char* sentence(Probing probing) {
    switch (probing) {
        case Probing::reference:
            return "This touch is the reference: growth counts from here. If the machine is warm, restart "
                   "LinuxCNC when it is cold, and touch the reference again.";
        case Probing::no_reference:
            return "No touch belongs to the work zero, so this touch corrects nothing. Touch the reference "
                   "on the cold machine, or before you set the work zero.";
        case Probing::first:
            return "The reference is touched. A second touch that agrees corrects the growth.";
        case Probing::corrected:
            return "Two touches agree. The next part is made with the offset of X changed by "
                   "{x-touch-change}, Y by {y-touch-change}, Z by {z-touch-change}.";
        case Probing::moved:
            return "The touches do not agree, or no growth explains them. Has the bore or the probe moved? "
                   "Nothing changes.";
        case Probing::revoked:
            return "The touches show more error with the law of growth than without it: the law of this axis "
                   "is revoked. The next part is made with the offset of X changed by {x-touch-change}, Y by "
                   "{y-touch-change}, Z by {z-touch-change}.";
        case Probing::not_now:
            return "This touch does not count: no law is set, a temperature or the position is invalid, or "
                   "an "
                   "axis moves to its offset.";
        default: return nullptr;
    }
}

}  // namespace axis_growth

enum class AxisGrowthStatus : std::int32_t {
    corrects = hal::first_own,
    no_law,
    no_temperature,
    returns,
    held,
    bounded,
    ramping,
    uncertain,
    moved,
    revoked
};

constexpr hal::Said said(AxisGrowthStatus status) {
    using hal::Kind;
    using hal::Tell;
    switch (status) {
        case AxisGrowthStatus::corrects: return {Kind::good, "Corrects the growth of the axes."};
        case AxisGrowthStatus::no_law:
            return {Kind::off, "No law of growth is set: nothing is corrected.",
                    "Run a growth test, and take over its result."};
        case AxisGrowthStatus::no_temperature:
            return {Kind::bad, "A temperature that the law needs was never valid: nothing is corrected.",
                    "Check the sensors."};
        case AxisGrowthStatus::returns:
            return {Kind::bad, "A temperature is lost: the offset returns to 0.", "Check the sensors."};
        case AxisGrowthStatus::held:
            return hal::Said{Kind::warn,
                             "A temperature cannot be trusted: an offset by it holds.",
                             "Check the sensor.",
                             {},
                             "doubt-code"}
                .told(Tell::text);
        case AxisGrowthStatus::uncertain:
            return {Kind::warn,
                    "Corrects the growth, and may be wrong by more than is harmless.",
                    "Check the sensors, and repeat the growth test on another day.",
                    {},
                    "doubt-code"};
        case AxisGrowthStatus::moved:
            return {
                Kind::warn,
                "Has the bore or the probe moved? Their touches do not agree, or no growth explains them.",
                "Check the bore and the probe, and touch the reference again."};
        case AxisGrowthStatus::revoked:
            return {Kind::warn,
                    "The touches of the reference show that the law of an axis is worse than none: this axis "
                    "is not corrected.",
                    "Repeat the growth test, and take over its result."};
        case AxisGrowthStatus::bounded:
            return hal::Said{
                Kind::warn, "The growth of an axis exceeds the largest offset, and is not corrected in full.",
                "Check the sensors, or raise the largest offset."}
                .told(Tell::text);
        case AxisGrowthStatus::ramping:
            return {Kind::wait, "The axes move to their offsets.", "Wait for the end of the move."};
        default: return hal::said(static_cast<hal::Common>(status));
    }
}

struct AxisGrowthSeen {
    bool fault = false, has_law = false, enabled = false, homed = false;
    bool temperatures_known = false, returns = false, held = false, bounded = false, ramping = false,
         moved = false, revoked = false, uncertain = false;
    AxisGrowthStatus interlock{};
};

inline AxisGrowthStatus status_of(const AxisGrowthSeen& seen) noexcept {
    using S = AxisGrowthStatus;
    return hal::first<S>({{seen.fault, hal::common<S>(hal::Common::fault)},
                          {!seen.has_law, S::no_law},
                          {seen.interlock != S{}, seen.interlock},
                          {!seen.enabled, hal::common<S>(hal::Common::off)},
                          {!seen.homed, hal::common<S>(hal::Common::not_homed)},
                          {!seen.temperatures_known, S::no_temperature},
                          {seen.returns, S::returns},
                          {seen.held, S::held},
                          {seen.bounded, S::bounded},
                          {seen.ramping, S::ramping},
                          {seen.revoked, S::revoked},
                          {seen.moved, S::moved},
                          {seen.uncertain, S::uncertain},
                          {true, S::corrects}});
}

}  // namespace plumb
