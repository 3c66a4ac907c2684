// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_offset.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace plumb {
namespace {

constexpr double dt = 0.001, farthest = 1000;  // s, mu
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Guarded : testing::Test {
    GuardedOffset it;
    std::vector<double> values = std::vector<double>(2, 0.0);

    Guarded() { allow({100, 50, 1000}); }
    void allow(const GuardedOffset::Limits& limits, bool moves = false) {
        it.allow(limits, moves, farthest, dt);
    }
    void follow(double target, double seconds, bool holds = false) {
        for (int i = 0; i < seconds / dt - 0.5; ++i) {
            it.step(target, holds, dt);
            values.push_back(it.value());
        }
    }
    double fastest() const {
        double result = 0;
        for (std::size_t i = 1; i < values.size(); ++i)
            result = std::max(result, std::abs(values[i] - values[i - 1]) / dt);
        return result;
    }
    double hardest() const {
        double result = 0;
        for (std::size_t i = 2; i < values.size(); ++i)
            result = std::max(result, std::abs(values[i] - 2 * values[i - 1] + values[i - 2]) / (dt * dt));
        return result;
    }
};

TEST_F(Guarded, FollowsExactlyWhatItsLimitsPermit) {
    for (int i = 1; i < 3000; ++i) {
        const double target = 12 * (1 - std::cos(4 * i * dt));  // at most 48 mu/s, 192 mu/s2
        it.step(target, false, dt);
        ASSERT_EQ(it.value(), target) << i;
        ASSERT_FALSE(it.kept_back());
    }
}

TEST_F(Guarded, ATargetThatStepsIsReachedWithinRateAndAcceleration) {
    follow(-20, 0.1);
    EXPECT_TRUE(it.kept_back());
    follow(-20, 1);
    EXPECT_FALSE(it.kept_back());
    EXPECT_NEAR(it.value(), -20, 1e-9);
    EXPECT_LE(fastest(), 50 * (1 + 1e-6));
    EXPECT_GT(fastest(), 49);
    EXPECT_LE(hardest(), 1000 * (1 + 1e-6));
    follow(500, 5);
    EXPECT_NEAR(it.value(), 100, 1e-9) << "its bound";
    EXPECT_TRUE(it.kept_back());
    EXPECT_TRUE(it.stands());
    EXPECT_LE(hardest(), 1000 * (1 + 1e-6));
}

TEST_F(Guarded, ASmallerBoundOrRateWaitsForTheEndOfThePlannedMotion) {
    allow({100, 50, 1000}, true);
    follow(40, 0.5);
    allow({30, 10, 1000}, true);
    follow(40, 1);
    EXPECT_NEAR(it.value(), 40, 1e-9);
    EXPECT_GT(fastest(), 49);
    follow(20, 2);
    allow({30, 10, 1000});
    values.assign(2, it.value());
    follow(40, 3);
    EXPECT_NEAR(it.value(), 30, 1e-9);
    EXPECT_LE(fastest(), 10 * (1 + 1e-6));
}

TEST_F(Guarded, AMotionThatBeginsHasTheNewLimitsAtOnce) {
    allow({30, 10, 1000}, true);
    follow(40, 5);
    EXPECT_NEAR(it.value(), 30, 1e-9);
    EXPECT_LE(fastest(), 10 * (1 + 1e-6));
}

TEST_F(Guarded, ABoundBelowTheOffsetIsRefusedAndMovesNothing) {
    follow(40, 2);
    allow({30, 50, 1000});
    EXPECT_TRUE(it.refused());
    values.assign(2, it.value());
    follow(40, 1);
    EXPECT_EQ(fastest(), 0);
    follow(20, 2);
    allow({30, 50, 1000});
    EXPECT_FALSE(it.refused()) << "within it";
    follow(40, 2);
    EXPECT_NEAR(it.value(), 30, 1e-9);
}

TEST_F(Guarded, ABoundThatItCannotStopWithinIsRefusedUntilItCan) {
    follow(29.9, 0.55);  // near 27, with 50 mu/s: 1.25 mu to rest
    ASSERT_GT(it.value(), 25);
    allow({it.value() + 0.5, 50, 1000});
    EXPECT_TRUE(it.refused());
    allow({it.value() + 2, 50, 1000});
    EXPECT_FALSE(it.refused());
}

TEST_F(Guarded, AnAccelerationThatCannotStopItWithinItsBoundWaits) {
    follow(500, 1.95);
    ASSERT_GT(it.value(), 95);
    ASSERT_LT(it.value(), 98);
    allow({100, 50, 10});
    follow(500, 2);
    EXPECT_LE(*std::max_element(values.begin(), values.end()), 100 + 1e-9);
    EXPECT_LE(hardest(), 1000 * (1 + 1e-6));
}

TEST_F(Guarded, ASmallerAccelerationLetsAMotionEndAtItsPlace) {
    allow({100, 50, 1000}, true);
    const double end = 10;
    follow(end - 0.5, 2);
    for (double left = 0.1; left > 0; left -= dt)
        follow(end - 50 * left * left, dt);  // brakes with 100 mu/s2
    allow({100, 50, 10});
    follow(end, dt);
    allow({100, 50, 10});
    follow(end, 1);
    EXPECT_LE(*std::max_element(values.begin(), values.end()), end);
    EXPECT_EQ(it.value(), end);
    allow({100, 50, 10});
    values.assign(2, end);
    follow(20, 5);
    EXPECT_LE(hardest(), 10 * (1 + 1e-6)) << "and holds from then on";
}

TEST_F(Guarded, ImpossibleLimitsLeaveTheLastOnes) {
    for (const double most : {nan, -1.0, 2 * farthest}) {
        allow({most, 50, 1000});
        EXPECT_FALSE(it.refused()) << most;
    }
    follow(500, 5);
    EXPECT_NEAR(it.value(), 100, 1e-9);
    for (const double rate : {nan, -1.0, 0.0, 1e7}) allow({100, rate, 1000});
    follow(-500, 5);
    EXPECT_NEAR(it.value(), -100, 1e-9);
    EXPECT_LE(fastest(), 50 * (1 + 1e-6));
}

TEST_F(Guarded, HeldItStandsAndReleasedItIsGone) {
    follow(40, 0.5);
    const double place = it.value();
    values.assign(2, place);
    follow(40, 1, true);
    EXPECT_EQ(fastest(), 0);
    EXPECT_TRUE(it.stands());
    it.release();
    EXPECT_EQ(it.value(), 0);
    follow(0, 0.1);
    EXPECT_EQ(it.value(), 0);
}

}  // namespace
}  // namespace plumb
