// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/growth_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm
constexpr double dt = 0.001;

struct Follower {
    GrowthOffset offset{};
    GrowthOffset::Settings settings{2 * um, 100 * um, 10 * um};
    GrowthOffset::Wish wish{true, true, true, true, 0, 0};

    double after(double seconds) {
        for (double t = 0; t < seconds; t += dt) offset.step(wish, settings, settings.tolerance, dt);
        return offset.value();
    }
};

TEST(GrowthOffset, FollowsAtTheRateAndLeavesOutChangesWithinTheTolerance) {
    Follower its;
    its.wish.growth = 12 * um;
    EXPECT_NEAR(its.after(0.5), 5 * um, 0.02 * um);
    EXPECT_NEAR(its.after(2), 12 * um, 1e-9);
    its.wish.growth = 13.9 * um;
    EXPECT_NEAR(its.after(2), 12 * um, 1e-9);
    its.wish.growth = 14.1 * um;
    EXPECT_NEAR(its.after(2), 14.1 * um, 1e-9);
}

TEST(GrowthOffset, BeginsWhenTheGrowthIsKnownAndHoldsWhenItIsNotKnownAnyMore) {
    Follower its;
    its.wish.known = false;
    its.wish.growth = 12 * um;
    EXPECT_EQ(its.after(2), 0);
    its.wish.known = true;
    EXPECT_NEAR(its.after(2), 12 * um, 1e-9);
    its.wish.known = false;
    its.wish.growth = 20 * um;
    EXPECT_NEAR(its.after(2), 12 * um, 1e-9) << "it holds";
}

TEST(GrowthOffset, MovesAndChangesOnlyWhenItMay) {
    Follower its;
    its.wish.growth = 12 * um;
    its.wish.may_move = false;
    EXPECT_EQ(its.after(2), 0);
    its.wish.may_move = true;
    its.after(2);
    its.wish.may_change = false;
    its.wish.growth = 30 * um;
    EXPECT_NEAR(its.after(3), 12 * um, 1e-9);
    its.wish.may_change = true;
    EXPECT_NEAR(its.after(3), 30 * um, 1e-9);
}

TEST(GrowthOffset, IsBoundedAndReturnsWhenItIsNotApplied) {
    Follower its;
    its.wish.growth = 130 * um;
    EXPECT_NEAR(its.after(15), 100 * um, 1e-9);
    EXPECT_TRUE(its.offset.limited());
    its.wish.applying = false;
    EXPECT_NEAR(its.after(15), 0, 1e-9);
    EXPECT_FALSE(its.offset.limited());
}

TEST(GrowthOffset, AStepOnPurposeComesBesideTheGrowth) {
    Follower its;
    its.wish.growth = 12 * um;
    its.wish.step = -20 * um;
    EXPECT_NEAR(its.after(3), -8 * um, 1e-9);
    its.wish.step = 0;
    EXPECT_NEAR(its.after(3), 12 * um, 1e-9);
}

}  // namespace
}  // namespace plumb
