// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/stages/joint_offset/tapered_offset.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double dt = 0.001;
constexpr SoftLimits limits{-100, 300, 2000, 500};  // share 0.1875

TEST(SoftLimits, AreValidInOrderAndInRangeOnly) {
    EXPECT_TRUE(limits.valid());
    EXPECT_FALSE(SoftLimits().valid());
    EXPECT_FALSE((SoftLimits{300, -100, 2000, 500}.valid()));
    EXPECT_FALSE((SoftLimits{100, 100, 2000, 500}.valid()));
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -2e9, 2e9}) {
        EXPECT_FALSE((SoftLimits{bad, 300, 2000, 500}.valid())) << bad;
        EXPECT_FALSE((SoftLimits{-100, bad, 2000, 500}.valid())) << bad;
        EXPECT_FALSE((SoftLimits{-100, 300, bad, 500}.valid())) << bad;
        EXPECT_FALSE((SoftLimits{-100, 300, 2000, bad}.valid())) << bad;
    }
    EXPECT_FALSE((SoftLimits{-100, 300, 0, 500}.valid()));
    EXPECT_FALSE((SoftLimits{-100, 300, 2000, 0}.valid()));
}

TEST(SoftLimits, TaperAnOffsetTowardsALimitAndLeaveOneAwayFromIt) {
    EXPECT_EQ(limits.allowed(0.05, 100), 0.05);
    EXPECT_EQ(limits.allowed(0.05, 300), 0);
    EXPECT_EQ(limits.allowed(-0.05, 300), -0.05);
    EXPECT_EQ(limits.allowed(-0.05, -100), 0);
    EXPECT_EQ(limits.allowed(0.05, -101), 0.05);
    EXPECT_DOUBLE_EQ(limits.allowed(0.05, 299.5), -limits.allowed(-0.05, -99.5));
    EXPECT_DOUBLE_EQ(limits.distance(1, 299.5), 0.5);
    EXPECT_DOUBLE_EQ(limits.distance(-1, -100.5), -0.5);
}

TEST(SoftLimits, TaperAnOffsetOverFourTimesItselfByTheRatioOfTheAccelerations) {
    const double length = 4 * 0.05 * limits.joint_acceleration / limits.offset_acceleration;
    EXPECT_DOUBLE_EQ(limits.allowed(0.05, 300 - length), 0.05);
    EXPECT_LT(limits.allowed(0.05, 300 - 0.9 * length), 0.05);
    EXPECT_EQ((SoftLimits{-100, 300, 100, 500}.share()), 1);  // the drive never passes the limit
}

TEST(SoftLimits, TaperAnOffsetWithinItsLengthFromThePlaceWhereTheJointCanStop) {
    const auto tapers = [](double offset, double from, double to) {
        return limits.tapers(offset, {from, to, std::abs(to - from), dt});
    };
    EXPECT_FALSE(tapers(0.05, 299.1, 299.1));  // the length is 0.8
    EXPECT_TRUE(tapers(0.05, 299.3, 299.3));
    EXPECT_FALSE(tapers(-0.05, 299.3, 299.3));
    EXPECT_TRUE(tapers(-0.05, -99.3, -99.3));
    EXPECT_TRUE(tapers(0.05, 296.9, 297));  // at 100 mm/s it stops after 2.5 mm
    EXPECT_FALSE(tapers(0.05, 297.1, 297));
    EXPECT_FALSE(tapers(0, 299.9, 299.9));
}

// The joint goes to the limit and brakes as hard as it can, from any speed and place; its offset grows as
// fast as it may.
TEST(SoftLimits, StopAGrowingOffsetAtItsShareOfTheRoomThatRemains) {
    Random random(1);
    for (int i = 0; i < 100; ++i) {
        const double speed = random.uniform(0, 100);
        const double stopping = speed * speed / (2 * limits.joint_acceleration);
        const double room = std::pow(10, random.uniform(-3, 1));
        double offset = 0, rate = limits.largest_speed(1, 0, {0, 0, 0, dt}), place = 300 - room - stopping;
        ASSERT_GT(rate, 1);  // far from the limit
        rate = 0;
        for (double v = speed; v > 0; v -= limits.joint_acceleration * dt) {
            const double before = place;
            place = std::min(place + (v - limits.joint_acceleration * dt / 2) * dt, 300 - room);
            place = std::max(place, before);
            const double possible = limits.largest_speed(1, offset, {before, place, place - before, dt});
            rate = std::min(possible, rate + limits.offset_acceleration / 4 * dt);
            offset += rate * dt;
            ASSERT_LE(offset, limits.share() * (300 - place) * (1 + 1e-9));
        }
        for (int n = 0; n < 3000; ++n) {
            const double before = rate;
            const double possible = limits.largest_speed(1, offset, {place, place, 0, dt});
            rate = std::min(possible, rate + limits.offset_acceleration / 4 * dt);
            offset += rate * dt;
            ASSERT_GE(rate - before, n ? -limits.offset_acceleration / 4 * dt * (1 + 1e-6) : -1e9);
            ASSERT_LE(offset, limits.share() * (300 - place) * (1 + 1e-9));
        }
        EXPECT_NEAR(offset, limits.share() * (300 - place), 1e-6);
    }
}

TEST(SoftLimits, LetAnOffsetGrowWithAJointThatLeavesTheLimit) {
    const double v = 20;
    EXPECT_DOUBLE_EQ(limits.largest_speed(1, 0, {300, 300, 0, dt}), 0);
    EXPECT_NEAR(limits.largest_speed(1, limits.share() * 1, {299 + v * dt, 299, v * dt, dt}),
                limits.share() * v, 1e-6);
    EXPECT_DOUBLE_EQ(limits.largest_speed(1, 1, {299 + v * dt, 299, 0, dt}), 0);  // the place jumped
}

TEST(SoftLimits, AreTheSameBothWays) {
    Random random(2);
    const SoftLimits mirrored{-300, 100, 2000, 500};
    for (int i = 0; i < 1000; ++i) {
        const double from = random.uniform(-105, 305), to = from + random.uniform(-0.1, 0.1);
        const double moved = std::abs(to - from), offset = random.uniform(-1, 1),
                     before = random.uniform(-1, 1);
        const SoftLimits::Step step{from, to, moved, dt}, back{-from, -to, moved, dt};
        for (const double direction : {-1.0, 1.0})
            ASSERT_EQ(limits.largest_speed(direction, offset, step),
                      mirrored.largest_speed(-direction, -offset, back));
        ASSERT_EQ(limits.largest_offset(offset, before, step),
                  mirrored.largest_offset(-offset, -before, back));
    }
}

TEST(SoftLimits, KeepJointAndOffsetWithinTheLimit) {
    Random random(3);
    for (int i = 0; i < 10000; ++i) {
        const double from = 300 - random.uniform(0, 2), moved = random.uniform(0, 0.2);
        const double to = std::min(from + moved, 300.0);
        const double before = random.uniform(0, 300 - from);
        const double most = limits.largest_offset(before, before, {from, to, moved, dt});
        ASSERT_LE(to + most, 300 + 1e-9);
    }
}

TEST(SoftLimits, KeepADriveThatIsBeyondTheLimitFromGoingFurther) {
    // 0.3 beyond: the offset goes back by the move of the joint, and no faster.
    EXPECT_NEAR(limits.largest_offset(0.5, 0.5, {299.8, 299.9, 0.1, dt}), 0.4, 1e-9);
    // A joint that leaves may keep its offset.
    EXPECT_GE(limits.largest_offset(0.5, 0.5, {299.9, 299.8, 0.1, dt}), 0.5);
    // The limit jumped nearer: no faster than the joint moves.
    EXPECT_DOUBLE_EQ(limits.largest_offset(0.5, 0.5, {100, 300, 0.1, dt}), 0.4);
    // An offset that changes its sign has nothing to keep.
    EXPECT_DOUBLE_EQ(limits.largest_offset(0.5, -0.5, {300, 300, 0, dt}), 0);
}

}  // namespace
}  // namespace plumb
