// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/crossing.hpp"
#include "components/compensation/chopping/edge.hpp"

namespace plumb {

// The orders of the program and the operator, out of bits that stay.
class StrokeOrders {
public:
    // The bits of a period.
    struct Given {
        bool run = false, stop = false, enable = true, go_to_end = false, shift = false;
        bool shift_at_crossing = false;
        double crossing_position = 0, crossing_at = 0, farthest = 0;  // mu
    };

    // The orders of a period. An order to go to the end goes before a start.
    struct Now {
        bool starts = false, returns = false, shifts = false;  // in this period
        bool run = false;                                      // the bit itself
        bool runs = false;                                     // strokes go on
        bool permitted = true;                                 // by enable
    };

    Now step(const Given& given) noexcept {
        Now now;
        now.run = given.run;
        now.runs = given.run && !given.stop;
        now.permitted = given.enable;
        now.returns = end_.rises(given.go_to_end);
        now.starts = run_.rises(given.run) && !now.returns;
        const bool crosses = crossing_.step(given.crossing_position, given.crossing_at, given.farthest);
        now.shifts = shift_.changes(given.shift) || (crosses && given.shift_at_crossing);
        return now;
    }

private:
    Edge run_, end_, shift_;
    Crossing crossing_;
};

}  // namespace plumb
