// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_motion.hpp"

#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

constexpr double dt = 0.001;

TEST(JerkLimit, OneSampleIsTheMotionItself) {
    JerkLimit limit;
    limit.reset(3, 1);
    EXPECT_EQ(limit.step(4), 4);
    EXPECT_TRUE(limit.settled());
}

// Reversals with +-a at any time: the jerk is bounded, and nothing grows.
TEST(JerkLimit, BoundsTheJerkAndRaisesNothingElse) {
    constexpr double a = 1000, jerk = 100000;  // 2 a in 20 samples
    Random random(1);
    JerkLimit limit;
    limit.reset(1e3, 20);
    double z = 1e3, v = 0, sign = 1, last = 1e3, speed = 0, acceleration = 0, fastest = 0;
    for (int i = 0; i < 20000; ++i) {
        if (random.uniform() < 0.02 || std::abs(v) > 100) sign = v > 0 ? -1 : 1;
        v += sign * a * dt;
        fastest = std::max(fastest, std::abs(v));
        z += v * dt;
        const double y = limit.step(z), now = (y - last) / dt, change = (now - speed) / dt;
        ASSERT_LE(std::abs(change), a * 1.001);
        ASSERT_LE(std::abs(change - acceleration) / dt, jerk * 1.01);
        ASSERT_LE(std::abs(now), fastest * (1 + 1e-9));
        last = y;
        speed = now;
        acceleration = change;
    }
}

TEST(JerkLimit, AReversalEndsShortByATwentyFourthOfATSquared) {
    constexpr double a = 800;
    JerkLimit limit;
    constexpr std::size_t count = 40;
    limit.reset(-a * 0.5 * 0.25 * 0.25, count);
    double highest = -1e9;
    for (int i = -249; i < 250; ++i) highest = std::max(highest, limit.step(-a / 2 * i * dt * i * dt));
    EXPECT_NEAR(-highest, a * (count * dt) * (count * dt) / 24, 1e-3);
}

TEST(JerkLimit, SettlesAtTheLastPositionExactly) {
    JerkLimit limit;
    limit.reset(0, 10);
    for (int i = 0; i < 9; ++i) limit.step(0.1);
    EXPECT_FALSE(limit.settled());
    EXPECT_LT(limit.value(), 0.1);
    limit.step(0.1);
    EXPECT_TRUE(limit.settled());
    EXPECT_EQ(limit.value(), 0.1);
}

}  // namespace
}  // namespace plumb
