// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroking_axis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s

// An axis that follows its command a period later; R is 0, the stroke from -20 to -8.
struct StrokingAxisTest : testing::Test {
    StrokingAxis it;
    StrokingAxis::Inputs now;
    StrokeSettings values;
    double lowest = 0, highest = -100;  // mu, of the command

    StrokingAxisTest() {
        values.in_range = true;
        values.lower = -20;
        values.upper = -8;
        values.feed = 60;
        values.max_acceleration = 1000;
        values.max_feed = 500;
        values.min_limit = -100;
        values.max_limit = 100;
        values.max_offset = values.max_rate = 500;
        now.orders.farthest = StrokingAxis::farthest;
        now.on = now.homed = true;
        it.begin(values);
    }
    void step() {
        now.joint = it.command();
        it.step(now, {values}, dt);
        lowest = std::min(lowest, it.command());
        highest = std::max(highest, it.command());
    }
    void run(double seconds) {
        for (int i = 0; i < seconds / dt; ++i) step();
    }
    void start() {
        now.orders.run = true;
        run(1);
    }
};

TEST_F(StrokingAxisTest, StrokesAndReturnsToItsEnd) {
    EXPECT_TRUE(it.at_end());
    start();
    lowest = 0;
    highest = -100;
    run(2);
    EXPECT_NEAR(lowest, -20, 0.001);
    EXPECT_NEAR(highest, -8, 0.001);
    EXPECT_FALSE(it.busy());
    now.orders.run = false;
    step();
    EXPECT_TRUE(it.busy()) << "moves of a program wait";
    run(2);
    EXPECT_TRUE(it.at_end());
    EXPECT_FALSE(it.busy());
    EXPECT_EQ(it.fault(), Fault::none);
}

TEST_F(StrokingAxisTest, AStartThatIsNotReadyIsRefusedUntilTheNextOne) {
    now.homed = false;
    start();
    EXPECT_FALSE(it.motion().moves());
    EXPECT_EQ(it.fault(), Fault::not_ready);
    now.homed = true;
    run(1);
    EXPECT_FALSE(it.motion().moves());
    now.orders.run = false;
    run(0.1);
    EXPECT_EQ(it.fault(), Fault::not_ready);
    start();
    EXPECT_TRUE(it.motion().moves());
    EXPECT_EQ(it.fault(), Fault::none);
}

TEST_F(StrokingAxisTest, AStartBeforeTheLastStrokesHaveEndedIsRefusedWithItsReason) {
    start();
    run(0.3);
    now.orders.run = false;
    run(0.01);
    ASSERT_TRUE(it.moves());
    now.orders.run = true;
    run(3);
    EXPECT_EQ(it.fault(), Fault::withdrawing);
    EXPECT_TRUE(it.at_end());
    now.orders.run = false;
    step();
    start();
    EXPECT_EQ(it.fault(), Fault::none);
}

TEST_F(StrokingAxisTest, AStartInThePeriodOfAnOrderToTheEndIsRefusedWithItsReason) {
    now.orders.run = now.orders.go_to_end = true;
    run(1);
    EXPECT_EQ(it.fault(), Fault::withdrawing);
    EXPECT_TRUE(it.at_end());
}

TEST_F(StrokingAxisTest, MachineOffStopsItAtOnceAndOnMovesNothing) {
    start();
    run(0.1);
    now.on = false;
    step();
    const double place = it.command();
    run(1);
    now.on = true;
    run(1);
    EXPECT_EQ(it.command(), place);
    EXPECT_TRUE(it.away());
}

TEST_F(StrokingAxisTest, AReleasedOffsetIsAPartOfThePosition) {
    start();
    now.on = false;
    now.releasable = now.released = true;
    const double place = it.command();
    now.position = place;
    now.joint = place;
    it.step(now, {values}, dt);
    EXPECT_EQ(it.offset(), 0);
    EXPECT_EQ(it.command(), place);
    EXPECT_TRUE(it.stands_off());
    now.released = false;
    now.on = true;
    run(1);
    EXPECT_EQ(it.command(), place);
    now.orders.run = false;
    run(0.1);
    start();
    EXPECT_FALSE(it.stands_off());
}

TEST_F(StrokingAxisTest, AnInvalidPositionKeepsTheLastGoodOne) {
    now.position = 1;
    run(0.1);
    now.position = std::numeric_limits<double>::quiet_NaN();
    run(0.1);
    EXPECT_EQ(it.position(), 1);
    EXPECT_EQ(it.fault(), Fault::position);
    start();
    EXPECT_FALSE(it.motion().moves());
}

TEST_F(StrokingAxisTest, AFollowingErrorStopsItAndProgramsWait) {
    values.max_following_error = 3;
    start();
    for (int i = 0; i < 500; ++i) {
        now.joint = -30;  // it does not follow
        it.step(now, {values}, dt);
    }
    EXPECT_EQ(it.fault(), Fault::following);
    run(1);
    EXPECT_FALSE(it.motion().moves());
    EXPECT_TRUE(it.away());
    EXPECT_TRUE(it.busy());
}

TEST_F(StrokingAxisTest, AnAxisThatDoesNotTurnAtADeadPointStopsTheStroke) {
    values.learn = true;
    values.inset = 0.3;
    now.orders.run = true;
    double farthest = -100;
    for (int i = 0; i < 20000 && it.fault() != Fault::lost; ++i) {
        farthest = std::max(farthest, it.command());
        now.joint = farthest += 1e-6;
        it.step(now, {values}, dt);
    }
    EXPECT_EQ(it.fault(), Fault::lost);
    run(1);
    EXPECT_FALSE(it.motion().moves());
}

// Not when its turn is judged, which is half a stroke later.
TEST_F(StrokingAxisTest, ADeadPointThatIsPassedIsToldInThatPeriod) {
    values.learn = true;
    values.inset = 0.3;
    values.max_drift = 1;
    start();
    run(40);
    ASSERT_TRUE(it.supervision().learning().learned());
    const auto arrives = [&] {
        const auto& its = it.motion().oscillation().arrival();
        return its.happened && its.regular && its.upper;
    };
    for (int i = 0; i < 20000 && !arrives(); ++i) step();
    run(0.002);
    for (double joint = now.joint; joint < values.upper + 0.0045; joint += 0.001) {
        now.joint = joint;
        it.step(now, {values}, dt);
        ASSERT_EQ(it.fault(), Fault::none) << joint;
    }
    now.joint = values.upper + 0.0055;
    it.step(now, {values}, dt);
    EXPECT_EQ(it.fault(), Fault::beyond);
}

}  // namespace
}  // namespace plumb
