// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/dead_point_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3, dt = 0.001, floor_of_all = 1 * um;

// A stroke of 20 mm at 2 Hz with a scale of 1 um; the motor is where the load is, without the windup of
// friction.
struct SlipWatchTest : testing::Test {
    SlipWatch it;
    double time = 0, slip = 0, windup = 0.03;
    bool motor = false, slipped = false, upward = true;
    int periods_until = -1;  // after the slip

    void step() {
        time += dt;
        const double place = 10 * std::sin(12.566 * time), speed = std::cos(12.566 * time);
        if ((speed > 0) != upward) {
            upward = speed > 0;
            slipped |= it.stroke(10 * um);
        }
        const double load = place - windup * (upward ? 1 : -1);
        const double read = std::round((load + slip) / um) * um;
        if (it.step({read, motor ? place : 0, 1580}, floor_of_all)) slipped = true;
    }
    void run(double seconds) {
        for (int i = 0; i < seconds / dt; ++i) step();
    }
};

TEST_F(SlipWatchTest, FindsAJumpOfOnePeriodInTheNextOne) {
    windup = 0;
    for (const double size : {8 * um, -10 * um, 0.1, -3.0})
        for (const double moment : {0.0, 0.05, 0.125, 0.2}) {
            SCOPED_TRACE(size);
            it.forget();
            slipped = false;
            run(3 + moment);
            ASSERT_FALSE(slipped) << "no slip";
            EXPECT_LE(it.least(), 8 * um);
            slip += size;
            step();
            EXPECT_FALSE(slipped);
            EXPECT_EQ(it.suspects(), true);
            step();
            EXPECT_TRUE(slipped);
            EXPECT_FALSE(it.suspects());
        }
}

// At 3000 mm/s2 each way differs from the one before by 3 um, which a fine scale shows.
TEST(SlipWatch, AnAccelerationAboveItsFloorIsNotSuspected) {
    SlipWatch it;
    for (int i = 0; i < 3000; ++i) {
        const double phase = 12.566 * dt * i;
        if (i % 250 == 0) EXPECT_FALSE(it.stroke(10 * um));
        EXPECT_FALSE(it.step({19 * std::cos(phase), 0, 3000}, floor_of_all)) << i;
        EXPECT_FALSE(it.suspects()) << i;
    }
}

TEST_F(SlipWatchTest, AnAxisThatStopsOrIsPausedDoesNotSlip) {
    windup = 0;
    run(3);
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(it.step({3, 0, 1580}, floor_of_all) && i > 1) << i;
    it.forget();
    run(3);
    it.pause();
    slip = 5;
    run(3);
    EXPECT_FALSE(slipped);
}

TEST_F(SlipWatchTest, WithTheMotorItFindsASlowSlipThroughTheWindupOfFriction) {
    motor = true;
    run(3);
    ASSERT_FALSE(slipped);
    for (int i = 0; i < 400; ++i) {  // 20 um in 0.4 s
        slip += 0.05 * um;
        step();
    }
    run(1);
    EXPECT_TRUE(slipped);
    it.accept();
    slipped = false;
    run(3);
    EXPECT_FALSE(slipped) << "another origin";
}

TEST_F(SlipWatchTest, FrictionAndHeatAreNoSlip) {
    motor = true;
    run(3);
    for (int i = 0; i < 60; ++i) {
        windup += 80 * um / 60;
        slip += 0.4 * um;  // heat, in half a second
        run(0.5);
    }
    EXPECT_FALSE(slipped);
}

}  // namespace
}  // namespace plumb
