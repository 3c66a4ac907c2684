// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_offset.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s

// The offset of a homed joint on a machine that is on.
struct StrokeOffsetTest : testing::Test {
    StrokeOffset it;
    StrokeOffset::Period now;

    StrokeOffsetTest() {
        now.on = now.homed = true;
        allow(100);
    }
    void allow(double most) { it.allow({most, 500, 10000}, now.moves, 1000, dt); }
    void run(double seconds) {
        for (int i = 0; i < seconds / dt; ++i) it.step(now, dt);
    }
    // A slow motion to a place, and its end there.
    void move_to(double place) {
        const double from = it.value();
        now.moves = true;
        for (int i = 1; i <= 2000; ++i) {
            now.command = now.mean = from + (place - from) * (1 - std::cos(3.14159265 * i / 2000)) / 2;
            it.step(now, dt);
        }
        now.moves = false;
        now.ends = true;
        it.step(now, dt);
        now.ends = false;
    }
};

TEST_F(StrokeOffsetTest, RestsWhereTheMotionEndedWithoutItsLead) {
    move_to(-30);
    EXPECT_NEAR(it.value(), -30, 1e-9);
    now.command = 50;  // nothing commands it any more
    run(1);
    EXPECT_NEAR(it.value(), -30, 1e-9);
    EXPECT_EQ(it.rest(), it.value());
}

TEST_F(StrokeOffsetTest, AnEndWithinRoundingIsTheEnd) {
    move_to(-30);
    move_to(1e-12);
    run(0.1);
    EXPECT_EQ(it.value(), 0);
}

TEST_F(StrokeOffsetTest, FrozenItStaysAndReleasedItIsGone) {
    now.moves = true;
    now.command = -20;
    run(0.02);
    const double place = it.value();
    ASSERT_LT(place, 0);
    now.moves = now.on = false;
    it.freeze();
    run(1);
    EXPECT_EQ(it.value(), place);
    it.release();
    EXPECT_EQ(it.value(), 0);
    now.on = true;
    run(1);
    EXPECT_EQ(it.value(), 0);
}

TEST_F(StrokeOffsetTest, WhereTheAxisWasMovedItStaysAlsoBeyondItsBound) {
    allow(100);
    it.put(130);
    EXPECT_EQ(it.value(), 130);
    run(1);
    EXPECT_EQ(it.value(), 130);
    EXPECT_EQ(it.rest(), 130);
    move_to(20);
    EXPECT_NEAR(it.value(), 20, 1e-9) << "and comes back";
}

TEST_F(StrokeOffsetTest, ABoundThatHasStoppedItDoesNotMoveItLater) {
    allow(20);
    move_to(-30);
    run(1);
    ASSERT_NEAR(it.value(), -20, 1e-9);
    allow(100);
    run(1);
    EXPECT_NEAR(it.value(), -20, 1e-9);
    allow(10);
    EXPECT_TRUE(it.refused());
    run(1);
    EXPECT_NEAR(it.value(), -20, 1e-9);
}

TEST_F(StrokeOffsetTest, FollowsAMotionAtItsLargestRateExactly) {
    it.allow({1000, 400, 20000}, false, 1000, dt);
    now.moves = true;
    double speed = 0;
    for (int i = 0; i < 1500; ++i) {
        speed = std::min(speed + 2, 400.0);
        now.command -= speed * dt;
        it.step(now, dt);
        ASSERT_EQ(it.value(), now.command) << i;
    }
}

TEST_F(StrokeOffsetTest, AStageThatHasTakenItAwayLeavesNothingToReturn) {
    move_to(-30);
    now.ramps = true;
    now.homed = false;
    run(2);
    EXPECT_EQ(it.value(), 0);
    now.homed = true;
    run(1);
    EXPECT_EQ(it.value(), 0);
}

TEST(StandingOff, EndsAtTheOldEndOrBeyondItButOnlyWhereTheMachineIsOn) {
    for (const double offset : {-35.0, 35.0}) {
        StandingOff it;
        it.step(10, true);
        it.begin(offset);
        it.step(10 + offset, true);
        EXPECT_TRUE(it.stands());
        it.step(10, false);
        it.step(10 + offset / 2, true);
        EXPECT_TRUE(it.stands());
        it.step(10 - offset / 100, true);
        EXPECT_FALSE(it.stands());
        it.step(10 + offset, true);
        EXPECT_FALSE(it.stands()) << "it has been there";
    }
}

TEST(StandingOff, AnAxisAtItsEndDoesNotStandOff) {
    StandingOff it;
    it.step(10, true);
    it.begin(0);
    EXPECT_FALSE(it.stands());
    it.begin(-20);
    EXPECT_TRUE(it.stands());
    it.end();
    EXPECT_FALSE(it.stands());
}

}  // namespace
}  // namespace plumb
