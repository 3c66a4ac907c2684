// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_orders.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s

StrokeOrders::Given usual() {
    StrokeOrders::Given its;
    its.farthest = 1e6;
    return its;
}

TEST(StrokeOrders, AStartIsARisingEdgeAndALongStopIsAState) {
    StrokeOrders it;
    StrokeOrders::Given given = usual();
    EXPECT_FALSE(it.step(given, dt).starts);
    given.run = true;
    EXPECT_TRUE(it.step(given, dt).starts);
    EXPECT_FALSE(it.step(given, dt).starts);
    given.stop = true;
    const StrokeOrders::Now now = it.step(given, dt);
    EXPECT_FALSE(now.starts || now.runs);
    EXPECT_TRUE(now.run);
}

TEST(StrokeOrders, AStartInThePeriodOfAnOrderToTheEndIsSeen) {
    StrokeOrders it;
    StrokeOrders::Given given = usual();
    given.run = given.go_to_end = true;
    const StrokeOrders::Now now = it.step(given, dt);
    EXPECT_TRUE(now.returns);
    EXPECT_TRUE(now.starts) << "to be refused";
    EXPECT_FALSE(it.step(given, dt).starts);
}

TEST(StrokeOrders, AShiftIsEachChangeOrACrossingWhereItCounts) {
    StrokeOrders it;
    StrokeOrders::Given given = usual();
    given.crossing_position = -1;
    it.step(given, dt);
    for (const bool shift : {true, false}) {
        given.shift = shift;
        EXPECT_TRUE(it.step(given, dt).shifts);
        EXPECT_FALSE(it.step(given, dt).shifts);
    }
    given.crossing_position = 1;
    EXPECT_FALSE(it.step(given, dt).shifts) << "a crossing that does not count";
    given.shift_at_crossing = true;
    EXPECT_FALSE(it.step(given, dt).shifts) << "and does not count later";
    given.crossing_position = -1;
    EXPECT_TRUE(it.step(given, dt).shifts);
}

TEST(StrokeOrders, StrokesEndWithTheProgramThatBeganThem) {
    for (const bool seen_late : {false, true})
        for (const bool outlasts : {false, true}) {
            StrokeOrders it;
            StrokeOrders::Given given = usual();
            given.outlasts = outlasts;
            given.program_running = !seen_late;
            it.step(given, dt);
            given.run = true;
            EXPECT_TRUE(it.step(given, dt).starts);
            for (int i = 0; i < 100; ++i) it.step(given, dt);
            given.program_running = true;
            EXPECT_TRUE(it.step(given, dt).runs);
            given.program_running = false;
            EXPECT_EQ(it.step(given, dt).runs, outlasts);
            given.program_running = true;  // the next program
            EXPECT_EQ(it.step(given, dt).ordered, outlasts);
            given.program_running = false;
            EXPECT_EQ(it.step(given, dt).ordered, outlasts);
            given.run = false;
            it.step(given, dt);
            given.run = true;
            EXPECT_TRUE(it.step(given, dt).runs) << "another start";
        }
}

TEST(StrokeOrders, StrokesOfMdiEndWhenAProgramBegins) {
    for (const bool outlasts : {false, true}) {
        StrokeOrders it;
        StrokeOrders::Given given = usual();
        given.run = true;
        given.outlasts = outlasts;
        for (int i = 0; i < 1100; ++i) EXPECT_TRUE(it.step(given, dt).runs);
        for (const bool running : {true, false, true, false}) {
            given.program_running = running;
            const StrokeOrders::Now now = it.step(given, dt);
            EXPECT_EQ(now.runs, outlasts);
            EXPECT_EQ(now.ended, !outlasts);
        }
        given.run = false;
        it.step(given, dt);
        given.run = true;
        EXPECT_TRUE(it.step(given, dt).runs) << "another start";
    }
}

}  // namespace
}  // namespace plumb
