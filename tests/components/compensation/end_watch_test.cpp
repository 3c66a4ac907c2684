// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_supervision.hpp"

#include <gtest/gtest.h>

#include <optional>

namespace plumb {
namespace {

constexpr double dt = 0.01, um = 1e-3;  // s, mu

// A way from 10 to 0, or from another place.
struct Ends : testing::Test {
    EndWatch it;
    double from = 10, to = 0;
    std::optional<double> found;

    void step(bool closes, double commanded, double measured) {
        if (it.step({closes, from, to, commanded, measured}, dt)) found = it.beyond();
    }
    void arrive() {
        step(true, from, from);
        step(true, (from + to) / 2, from);
    }
    void rest(double measured, double seconds = 1) {
        for (double t = 0; t < seconds; t += dt) step(false, to, measured);
    }
};

TEST_F(Ends, AnAxisThatComesLateAndTurnsBehindTheEndIsBeyond) {
    arrive();
    step(false, 0, 1);
    step(false, 0, -20 * um);
    EXPECT_FALSE(found) << "it may go farther";
    step(false, 0, -30 * um);
    rest(0);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, 30 * um, 1e-12);
    found.reset();
    rest(-1);
    EXPECT_FALSE(found) << "once for each way";
}

TEST_F(Ends, UpwardItIsTheOtherSide) {
    from = -10;
    arrive();
    step(false, 0, 30 * um);
    step(false, 0, -50 * um);
    rest(0);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, 30 * um, 1e-12);
}

TEST_F(Ends, AnAxisThatFrictionKeepsBeyondIsBeyond) {
    arrive();
    rest(-20 * um);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, 20 * um, 1e-12);
}

TEST_F(Ends, AnAxisThatStaysInsideIsNotBeyond) {
    arrive();
    rest(15 * um);
    ASSERT_TRUE(found);
    EXPECT_EQ(*found, 0);
}

TEST_F(Ends, AMotionThatBeginsBeforeTheAxisStandsEndsTheWay) {
    arrive();
    step(false, 0, -30 * um);
    step(false, 1 * um, -29 * um);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, 30 * um, 1e-12);
    rest(-1);
    EXPECT_NEAR(*found, 30 * um, 1e-12) << "a jog";
}

TEST_F(Ends, AWayThatStopsBeforeItsEndIsNone) {
    arrive();
    for (double t = 0; t < 1; t += dt) step(false, 5, 5);
    EXPECT_FALSE(found);
}

TEST_F(Ends, AWayThatStopsAfterOneThatEndedIsNone) {
    arrive();
    step(false, 0, 0);
    from = 0;
    to = 20;
    step(true, 1, 0);
    for (double t = 0; t < 1; t += dt) step(false, 5, 25);
    EXPECT_FALSE(found);
}

TEST_F(Ends, TheLastOfTwoWaysCounts) {
    arrive();
    step(true, 0, -1);  // it turns there
    from = 0;
    to = 20;
    step(true, 1, -1);
    rest(20);
    ASSERT_TRUE(found);
    EXPECT_EQ(*found, 0);
}

}  // namespace
}  // namespace plumb
