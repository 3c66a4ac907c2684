// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/edge.hpp"
#include "hal/component.hpp"

namespace plumb {

// The orders of an operator or a program. Each is a rising edge.
struct HeightOrders final : hal::Group {
    using Group::Group;

    hal::In<bool> start{this, "start", false, "A rising edge begins the procedure."};
    hal::In<bool> resume{this, "resume", false, "A rising edge continues after an abort."};
    hal::In<bool> abort{this, "abort", false, "A rising edge interrupts the procedure."};
    hal::In<bool> stored{this, "stored", false,
                         "A rising edge ends the procedure: the program has the height."};
    hal::In<bool> cut_done{this, "cut-done", false, "A rising edge: the tool stands at the end of a cut."};
    hal::In<bool> value_ready{this, "value-ready", false, "A rising edge: the diameter of the cut counts."};
    hal::In<double> entered_diameter{this, "entered-diameter", 0, "mu",
                                     "Diameter, or radius, that the operator or a program enters."};
    hal::In<bool> entered{this, "entered", false, "A rising edge: entered-diameter of the cut counts."};
    hal::In<double> entered_cut{this, "entered-cut", 0, "1",
                                "Number of the cut whose diameter entered-diameter replaces, from 1; 0: the "
                                "cut that waits; below 0: the last cut, whose diameter is taken back."};
    hal::In<double> program_method{this, "program-method", 0, "1",
                                   "Method by a word of a program, plus 1; 0: the pin method."};
    hal::In<double> program_cuts{this, "program-cuts", 0, "1",
                                 "Number of cuts by a word of a program; 0: the pin cuts."};
    hal::In<double> program_post{this, "program-post", 0, "1",
                                 "Post by a word of a program, plus 1; 0: the pin post."};
    hal::In<bool> compute{this, "compute", false, "A rising edge computes from the cuts that there are."};

    // Of one period.
    struct Given {
        bool start = false, resume = false, abort = false, stored = false, cut = false, value = false,
             entry = false, compute = false;
        bool cut_done = false, value_ready = false, entered = false;  // as they are
        double cuts = 0;                                              // by a program; 0 for none
        double corrected =
            0;  // number of the cut whose diameter is replaced, or below 0 taken back; 0 for none
    };

    Given read() noexcept {
        Given now;
        now.cut_done = cut_done;
        now.value_ready = value_ready;
        now.entered = entered;
        now.start = start_.rises(start);
        now.resume = resume_.rises(resume);
        now.abort = abort_.rises(abort);
        now.stored = stored_.rises(stored);
        now.cut = cut_.rises(now.cut_done);
        now.value = value_.rises(now.value_ready);
        now.entry = entry_.rises(now.entered);
        now.compute = compute_.rises(compute);
        now.cuts = program_cuts;
        now.corrected = entered_cut;
        return now;
    }

private:
    Edge start_, resume_, abort_, stored_, cut_, value_, entry_, compute_;
};

}  // namespace plumb
