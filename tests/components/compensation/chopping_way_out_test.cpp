// SPDX-License-Identifier: GPL-2.0-or-later
// chopping takes the wheel out of the work by the dead point that is clear: at an abort, without an enable,
// and when the spindle stops.
#include "components/math/blocks/random.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/chopping_axis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace plumb {
namespace {

constexpr double lower = -20, upper = -8;
constexpr int by_lower = 1, by_upper = 2;

// Point R is 0, above the stroke.
struct ChoppingWayOut : ChoppingAxis {
    // S, until the axis is within 0.2 mm of the clear dead point, or beyond it, for good.
    double leaves(int kind, double seconds = 6) {
        const double most = get("way-out-time");
        set("enable", 0);
        const Table trace = bench.trace(seconds, {"chop.command"});
        const std::vector<double> z = trace.column("chop.command");
        std::size_t clear = z.size();
        while (clear > 0 && (kind == by_upper ? z[clear - 1] >= upper - 0.2 : z[clear - 1] <= lower + 0.2))
            --clear;
        const double time = static_cast<double>(clear) * dt;
        EXPECT_LE(time, most + 0.06) << "way-out-time";
        EXPECT_LE(hardest(z), 1000 * 1.01);
        EXPECT_GE(*std::min_element(z.begin(), z.end()), lower - 1 * nm);
        EXPECT_LE(*std::max_element(z.begin(), z.end()), kind == by_upper ? 0 : upper + 1 * nm);
        EXPECT_EQ(get("active"), 0);
        EXPECT_EQ(get("fault-code"), 0);
        return time;
    }
    void again() {
        set("run", 0);
        set("enable", 1);
        bench.run(0.01);
        set("go-to-end", 1);
        bench.run(2);
        set("go-to-end", 0);
        ASSERT_EQ(get("at-end"), 1);
        start();
    }
};

TEST_F(ChoppingWayOut, EachPhaseIsLeftByTheClearDeadPoint) {
    Random random(41);
    for (const int kind : {by_upper, by_lower}) {
        set("abort-kind", kind);
        double longest = 0;
        for (int i = 0; i < 60; ++i) {
            SCOPED_TRACE(testing::Message() << kind << ' ' << i);
            again();
            bench.run(1.5 + random.uniform(0, 0.7));
            longest = std::max(longest, leaves(kind));
            EXPECT_NEAR(get("command"), kind == by_upper ? 0 : lower, 1e-6) << "R is beyond the upper one";
        }
        RecordProperty("longest_" + std::to_string(kind), std::to_string(longest));
        EXPECT_LE(longest, 0.5) << "a stroke lasts 0.314 s, a cycle 0.628 s";
    }
}

TEST_F(ChoppingWayOut, WithoutAClearEndTheStrokeGoesOnFirst) {
    start();
    bench.run(1.75);
    const double from = get("command");
    set("enable", 0);
    const std::vector<double> z = commands(4);
    EXPECT_LT(*std::min_element(z.begin(), z.end()), from - 0.5);
    EXPECT_EQ(get("command"), 0);
}

// R amid the stroke, in the work.
TEST_F(ChoppingWayOut, AnAxisWhosePointRIsInTheWorkRestsAtTheClearEnd) {
    set("position", -14);
    for (const int kind : {by_upper, by_lower}) {
        SCOPED_TRACE(kind);
        set("abort-kind", kind);
        for (const double time : {0.05, 0.15, 0.9, 1.05, 1.2, 1.37}) {
            SCOPED_TRACE(time);
            set("run", 0);
            set("enable", 1);
            bench.run(3);
            start();
            bench.run(time);
            set("enable", 0);
            bench.run(3);
            EXPECT_EQ(get("active"), 0);
            EXPECT_NEAR(get("command"), kind == by_upper ? upper : lower, 1e-6);
            EXPECT_EQ(get("at-end"), 0);
            set("go-to-end", 1);
            bench.run(3);
            set("go-to-end", 0);
            EXPECT_EQ(get("at-end"), 1) << "an order of its own goes to R";
        }
    }
}

TEST_F(ChoppingWayOut, TheEndOfTheProgramAndItsAbortLeaveTheWork) {
    set("abort-kind", by_upper);
    set("spark-out", 20);
    for (const bool word : {true, false}) {
        SCOPED_TRACE(word);
        set("program-running", 1);
        start();
        bench.run(1.75);
        ASSERT_LT(get("command"), -9);
        if (word)
            set("program-word", 15);
        else
            set("program-running", 0);
        bench.run(0.01);
        EXPECT_EQ(get("withdrawing"), 1);
        bench.run(2);
        EXPECT_EQ(get("at-end"), 1);
        set("program-word", 0);
        set("program-running", 0);
        set("run", 0);
        bench.run(1.5);
    }
}

TEST_F(ChoppingWayOut, ASpindleThatStopsOrLosesItsSpeedEndsTheStrokes) {
    for (const int kind : {0, by_upper}) {
        set("abort-kind", kind);
        for (const char* pin : {"spindle-on", "spindle-at-speed"}) {
            SCOPED_TRACE(std::string(pin) + ' ' + std::to_string(kind));
            const bool dips = pin == std::string("spindle-at-speed");
            set("run", 0);
            bench.run(0.01);
            start();
            bench.run(1.75);
            if (dips) {
                set(pin, 0);
                bench.run(0.19);
                set(pin, 1);
                bench.run(0.01);
                EXPECT_EQ(get("withdrawing"), 0) << "a dip";
            }
            set(pin, 0);
            bench.run(dips ? 0.21 : 0.002);
            EXPECT_EQ(get("withdrawing"), 1);
            EXPECT_EQ(get("fault-code"), dips ? 28 : 0);
            EXPECT_EQ(get("feed-wait"), 1);
            bench.run(3);
            EXPECT_EQ(get("fault-code"), 28);
            EXPECT_EQ(get("at-end"), 1);
            EXPECT_EQ(get("feed-wait"), 1) << "the program still orders strokes";
            set("run", 0);
            bench.run(0.01);
            EXPECT_EQ(get("feed-wait"), 0);
            start();
            bench.run(0.01);
            EXPECT_EQ(get("fault-code"), 27);
            EXPECT_EQ(get("active"), 0);
            set("run", 0);
            bench.run(0.01);
            EXPECT_EQ(get("fault-code"), 27) << "until the next start";
            set(pin, 1);
        }
    }
}

TEST_F(ChoppingWayOut, ASpindleThatIsOrderedOffWithItsProgramIsNoFault) {
    for (const char* end : {"run", "program-running"}) {
        SCOPED_TRACE(end);
        set("spindle-on", 1);
        set("run", 0);
        set("program-running", 1);
        bench.run(1.5);
        start();
        bench.run(1.75);
        set("spindle-on", 0);
        bench.run(0.5);
        set(end, 0);
        bench.run(4);
        EXPECT_EQ(get("fault-code"), 0);
        EXPECT_EQ(get("at-end"), 1);
        EXPECT_EQ(get("feed-wait"), 0);
    }
}

TEST_F(ChoppingWayOut, ASpindleThatStopsWithTheMachineIsNoFault) {
    start();
    bench.run(1.75);
    set("spindle-on", 0);
    bench.run(0.01);
    set("motion-enabled", 0);
    bench.run(4);
    EXPECT_EQ(get("fault-code"), 0) << "the program still orders strokes";
    EXPECT_EQ(get("active"), 0);
}

TEST_F(ChoppingWayOut, AWheelThatTripsInSparkOutLeavesTheWork) {
    set("abort-kind", by_upper);
    set("spark-out", 20);
    start();
    bench.run(1.2);
    set("run", 0);
    bench.run(0.6);
    ASSERT_EQ(get("sparking-out"), 1);
    set("spindle-at-speed", 0);
    bench.run(0.21);
    EXPECT_EQ(get("withdrawing"), 1);
    EXPECT_EQ(get("fault-code"), 28);
    bench.run(2);
    EXPECT_EQ(get("at-end"), 1);
}

TEST_F(ChoppingWayOut, StrokesWithoutAWheelNeedNoSpindle) {
    set("without-wheel", 1);
    set("spindle-on", 0);
    set("spindle-at-speed", 0);
    start();
    bench.run(3);
    EXPECT_EQ(get("stroking"), 1);
    EXPECT_EQ(get("fault-code"), 0);
}

}  // namespace
}  // namespace plumb
