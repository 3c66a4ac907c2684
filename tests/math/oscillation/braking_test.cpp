// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/stroke_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

TEST(Braking, RestsWhereAndWhenAConstantDecelerationEnds) {
    for (const double sign : {1.0, -1.0}) {
        const Braking braking({5, sign * 100, 0}, 1000);
        EXPECT_DOUBLE_EQ(braking.duration(), 0.1);
        EXPECT_DOUBLE_EQ(braking.end(), 5 + sign * 5);
        EXPECT_DOUBLE_EQ(braking.at(0.04).position, 5 + sign * (4 - 0.8));
        EXPECT_DOUBLE_EQ(braking.at(0.04).velocity, sign * 60);
        EXPECT_EQ(braking.at(0.04).acceleration, -sign * 1000);
        for (const double time : {0.1, 7.0}) {
            EXPECT_DOUBLE_EQ(braking.at(time).position, braking.end());
            EXPECT_EQ(braking.at(time).velocity, 0);
            EXPECT_EQ(braking.at(time).acceleration, 0);
        }
    }
}

TEST(Braking, NeedsTheDecelerationThatEndsInTheWay) {
    EXPECT_DOUBLE_EQ(Braking::needed(5, 100), 1000);
    EXPECT_TRUE(std::isinf(Braking::needed(0, 100)));
}

}  // namespace
}  // namespace plumb
