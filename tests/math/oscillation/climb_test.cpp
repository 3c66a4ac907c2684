// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/climb.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace plumb {
namespace {

constexpr double length = 40, room = 0.05;  // mm
constexpr double slowest = Climb::slow * Climb::slow;

// A drive that follows up to a level.
struct Drive {
    double strongest = 10;

    void stroke(Climb& climb) const {
        for (const bool upper : {false, true})
            climb.shown(upper, climb.level(), std::min(climb.level(), strongest));
    }
};

TEST(Climb, BrakesByNoMoreThanTheAxisHasShown) {
    for (const double strongest : {0.1, 0.3, 0.5, 0.9, 2.0}) {
        Climb climb;
        climb.begin(slowest, slowest);
        const Drive drive{strongest};
        for (int i = 0; i < 100; ++i) {
            drive.stroke(climb);
            EXPECT_LE(climb.level() * climb.braking(), std::max(strongest * 1.12, Climb::slow * Climb::slow))
                << strongest;
            climb.rise(10, length, room);
        }
        EXPECT_EQ(climb.weak(), strongest < 1);
        EXPECT_EQ(climb.complete(), true);
        if (strongest < 1) {
            EXPECT_LE(climb.level(), strongest);
            EXPECT_GE(climb.level(), 0.8 * strongest);
        }
    }
}

TEST(Climb, IsAtFullSpeedAfterNineCyclesWhereTheAxisShowsItsForce) {
    Climb climb;
    climb.begin(slowest, slowest);
    int cycles = 0;
    for (; !climb.complete() && cycles < 50; ++cycles) {
        Drive{}.stroke(climb);
        climb.rise(10, length, room);
    }
    EXPECT_LE(cycles, 9);
    EXPECT_EQ(climb.factor(), 1);
    EXPECT_EQ(climb.braking(), 1);
}

// The overshoot of a drive that saturates at the last level, S (r - 1)^2 / (4 r).
TEST(Climb, WithoutAMeasurementItRisesByWhatMayBeOvershot) {
    Climb climb;
    climb.begin(slowest, slowest);
    double before = climb.level();
    for (int i = 0; i < 20; ++i) {
        climb.rise(10, length, room);
        const double r = climb.level() / before;
        EXPECT_NEAR(length * (r - 1) * (r - 1) / (4 * r), room, 1e-9);
        EXPECT_EQ(climb.braking(), 1);
        before = climb.level();
    }
}

TEST(Climb, ARestartBrakesByLessUntilTheAxisHasShownTheForceOfBefore) {
    for (const double before : {0.0, 0.9})
        for (const double now : {0.75, 0.8, 0.87, 1.0}) {
            Climb climb;
            climb.begin(1, 0.671);
            climb.expect(before);
            EXPECT_EQ(climb.factor(), 1);
            EXPECT_NEAR(climb.braking(), 0.671, 1e-12);
            Drive{now}.stroke(climb);
            climb.rise(10, length, room);
            EXPECT_EQ(climb.complete(), now > (before > 0 ? 0.93 * before : 0.93 * 0.85)) << now;
            if (!climb.complete()) {
                EXPECT_LE(climb.level(), now);
            }
        }
}

TEST(Climb, ARestartWithoutAMeasurementBrakesHarderByWhatMayBeOvershot) {
    Climb climb;
    climb.begin(1, 0.671);
    climb.rise(10, length, room);
    const double r = climb.braking() / 0.671;
    EXPECT_EQ(climb.level(), 1);
    EXPECT_NEAR(length * (r - 1) * (r - 1) / (4 * r), room, 1e-9);
}

TEST(Climb, NeverRisesByMoreThanTheOvershootPermits) {
    Climb climb;
    climb.begin(slowest, slowest);
    Drive{}.stroke(climb);
    climb.rise(1.2, length, room);
    EXPECT_NEAR(climb.level(), 1.2 * Climb::slow * Climb::slow, 1e-12);
}

TEST(Climb, AnAxisThatFallsBehindTwiceIsWeak) {
    Climb climb;
    climb.begin(0.25, 0.25);
    Drive{}.stroke(climb);
    climb.rise(10, length, room);
    climb.fall_behind();
    EXPECT_NEAR(climb.level(), 0.25, 1e-12);
    EXPECT_FALSE(climb.weak());
    Drive{}.stroke(climb);
    climb.rise(10, length, room);
    EXPECT_LT(climb.level(), 0.25 * 1.1) << "carefully now";
    climb.fall_behind();
    EXPECT_TRUE(climb.weak());
    EXPECT_LT(climb.level(), 0.25);
    climb.open();
    climb.begin(slowest, slowest);
    EXPECT_FALSE(climb.weak());
    EXPECT_FALSE(climb.complete());
}

}  // namespace
}  // namespace plumb
