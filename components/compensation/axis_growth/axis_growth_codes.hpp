// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb::axis_growth {

enum class Fault : std::int32_t { none, position, speed, settings };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::position: return "A position is invalid or beyond 1e6; its last good value is used.";
        case Fault::speed: return "The spindle speed is invalid or beyond 1e6; its last good value is used.";
        case Fault::settings: return "The settings are out of range; the last good set stays in force.";
        default: return nullptr;
    }
}

enum class Doubt : std::int32_t { none, sensor, old, range, uncertain };
constexpr const char* sentence(Doubt doubt) {
    switch (doubt) {
        case Doubt::sensor:
            return "A temperature is invalid: its last good value holds, and the offset returns to 0 after "
                   "hold-time.";
        case Doubt::old: return "A temperature has been invalid for hold-time: the offset returns to 0.";
        case Doubt::range:
            return "A temperature is outside the range of the growth test: only a part of the growth is "
                   "applied.";
        case Doubt::uncertain: return "The growth is uncertain: only a part of it is applied.";
        default: return nullptr;
    }
}

}  // namespace plumb::axis_growth
