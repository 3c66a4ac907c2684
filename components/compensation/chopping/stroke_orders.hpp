// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/crossing.hpp"
#include "components/math/blocks/edge.hpp"

#include <algorithm>

namespace plumb {

// The orders of the program and the operator, out of bits that stay. The end of a program ends the strokes
// that the program began. The begin of a program ends other strokes, and its moves wait for the axis.
class StrokeOrders {
public:
    // The bits of a period.
    struct Given {
        bool run = false, stop = false, enable = true, go_to_end = false, shift = false;
        bool shift_at_crossing = false;
        // outlasts: strokes go on when a program ends or begins
        bool program_running = false, outlasts = false;
        double crossing_position = 0, crossing_at = 0, farthest = 0;  // mu
    };

    // The orders of a period. An order to go to the end goes before a start.
    struct Now {
        bool starts = false, returns = false, shifts = false;  // in this period
        bool run = false;                                      // the bit itself
        bool ordered = false;                                  // by the program or in MDI
        bool ended = false;                                    // by a program, which they do not outlast
        bool runs = false;                                     // strokes go on
        bool permitted = true;                                 // by enable
    };

    // One period of dt s.
    Now step(const Given& given, double dt) noexcept {
        Now now;
        now.run = given.run;
        now.permitted = given.enable;
        now.returns = end_.rises(given.go_to_end);
        now.starts = run_.rises(given.run) && !now.returns;
        watch_program(given, now.starts, dt);
        now.ended = ended_;
        now.ordered = given.run && !ended_;
        now.runs = now.ordered && !given.stop;
        const bool crosses = crossing_.step(given.crossing_position, given.crossing_at, given.farthest);
        now.shifts = shift_.changes(given.shift) || (crosses && given.shift_at_crossing);
        return now;
    }

private:
    // A program that has begun is seen some time later.
    void watch_program(const Given& given, bool starts, double dt) noexcept {
        if (starts) {
            of_program_ = ended_ = false;
            since_start_ = 0;
        }
        since_start_ = std::min(since_start_ + dt, 2 * patience);
        const bool begins = program_.rises(given.program_running);
        if (given.program_running && since_start_ <= patience) of_program_ = true;
        const bool ends = of_program_ && !given.program_running;
        if (!ends && (of_program_ || !begins)) return;
        of_program_ = false;
        ended_ |= !given.outlasts;
    }

    static constexpr double patience = 1;  // s

    double since_start_ = 2 * patience;  // s
    bool of_program_ = false, ended_ = false;
    Edge run_, end_, program_, shift_;
    Crossing crossing_;
};

}  // namespace plumb
