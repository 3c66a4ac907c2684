// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth/probed_growth.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(TouchLatch, GivesTheFastestMotionBeforeTheTouch) {
    TouchLatch latch;
    EXPECT_FALSE(latch.step(false, false, {1, -3, 2}));
    EXPECT_TRUE(latch.step(true, true, {5, 0, 0}));
    EXPECT_TRUE(latch.latched());
    EXPECT_EQ(latch.direction(), -2);
    latch.arm();
    EXPECT_FALSE(latch.latched());
    EXPECT_EQ(latch.direction(), 0);
    latch.step(false, false, {0, 0, 0.1});
    latch.step(false, false, {0, 0, 0});  // it stands before the touch
    EXPECT_TRUE(latch.step(true, true, {0, 0, 0}));
    EXPECT_EQ(latch.direction(), 3);
}

TEST(TouchLatch, ATouchWithoutMotionHasNoDirection) {
    TouchLatch latch;
    EXPECT_TRUE(latch.step(true, true, {1, 0, 0}));
    EXPECT_EQ(latch.direction(), 0);
}

TEST(TouchLatch, AProbeThatTouchesAlreadyIsNoTouch) {
    TouchLatch latch;
    EXPECT_FALSE(latch.step(true, false, {1, 0, 0}));
    EXPECT_FALSE(latch.latched());
    EXPECT_FALSE(latch.step(false, false, {-1, 0, 0}));
    EXPECT_TRUE(latch.step(true, true, {1, 0, 0}));
    EXPECT_EQ(latch.direction(), -1);
}

}  // namespace
}  // namespace plumb
