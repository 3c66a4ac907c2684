// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/stages/joint_offset/tapered_offset.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

TEST(SoftLimitTaper, IsWholeFarAwayAndNothingAtTheLimitAndBeyond) {
    EXPECT_EQ(tapered(0.05, 10, 0.5), 0.05);
    EXPECT_EQ(tapered(0.05, 0.3, 0.5), 0.05);
    EXPECT_EQ(tapered(0.05, 0, 0.5), 0);
    EXPECT_EQ(tapered(0.05, -1, 0.5), 0);
    EXPECT_EQ(tapered(0, 1, 0.5), 0);
    EXPECT_EQ(tapered(-0.05, 0.001, 0.5), -0.05);
}

TEST(SoftLimitTaper, NeverPassesTheLimitAndGrowsWithDistanceAndOffset) {
    Random random(1);
    for (int i = 0; i < 100000; ++i) {
        const double share = random.uniform(0.001, 1), offset = std::pow(10, random.uniform(-6, 3));
        const double distance = 3 * offset / share * random.uniform(0, 1.2);
        const double f = tapered(offset, distance, share);
        ASSERT_GE(f, 0);
        ASSERT_LE(f, share * distance * (1 + 1e-12));
        ASSERT_LE(f, offset);
        ASSERT_GE(tapered(offset, distance * 1.001, share), f * (1 - 1e-12));
        ASSERT_GE(tapered(offset * 1.001, distance, share), f * (1 - 1e-12));
        ASSERT_LE(tapered(offset * 1.001, distance, share), f + offset * 0.001 * (1 + 1e-9));
    }
}

// A joint brakes to the limit as hard as it can, v² = 2 a d, from any speed; time is cut so finely that the
// second difference is the derivative.
TEST(SoftLimitTaper, AddsAtMostItsShareOfTheAccelerationOfAJointThatBrakes) {
    for (const double share : {0.05, 0.375, 1.0})
        for (const double offset : {0.001, 0.1, 5.0}) {
            const double a = 2000, dt = 1e-5;
            double hardest = 0, before = 0, last = 0;
            for (int i = 0; i < 100000; ++i) {
                const double t = (i - 50000) * dt,
                             y = tapered(offset, a * t * t / 2, share);  // there, and away
                if (i > 1) hardest = std::max(hardest, std::abs(y - 2 * last + before) / (dt * dt));
                before = last;
                last = y;
            }
            EXPECT_LE(hardest, share * a * 1.01) << share << " " << offset;
            EXPECT_GE(hardest, share * a * 0.9) << share << " " << offset;
        }
}

}  // namespace
}  // namespace plumb
