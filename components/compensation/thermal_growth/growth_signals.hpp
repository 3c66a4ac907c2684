// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/edge.hpp"
#include "components/math/growth/stop_rule.hpp"

#include <array>
#include <cstdint>

namespace plumb::growth_test {

// A bit of this period, and its change since the last one.
struct Bit {
    bool now = false, rises = false, falls = false;

    static Bit of(Edge& edge, bool now) noexcept {
        const bool changes = edge.changes(now);
        return {now, changes && now, changes && !now};
    }
};

// The position of the machine, and the compensation that it contains.
struct Position {
    std::array<double, 3> position{}, offset{}, velocity{};  // mu, mu, mu/s
    bool good = true;
};

struct Warmth {
    int count = 0;                   // of the sensors
    StopRule::Temperatures value{};  // degC; not a number: invalid
    StopRule::Temperatures age{};    // s
    std::uint32_t decides = 0;       // sensors of the stop rule, a bit each
    double sample_time = 60;         // s
    bool good = true, artifact_good = true;
};

// The program, the probe and the machine in one period.
struct Signals {
    Bit running, pass, bore, measuring, cycle, probe;
    bool resume = false;
    double gap = 0;       // s since the last record of a restored test; below 0: unknown
    double bore_key = 0;  // number of the bore
    double max_pass_time = 0;
    bool turned = false, oriented = false;  // the table is at 180 deg, and where the program wants it
    bool overtravel = false;
    bool compensated = false, cooled = false;
    bool confirmed = false;  // both are as the program wants them
    double spindle_speed = 0;
    Position at;
    Warmth warmth;
};

}  // namespace plumb::growth_test
