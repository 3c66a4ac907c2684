// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/delayed_bit.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double dt = 0.125;  // s, exact

// Periods of one input until the output is that input, at most 100.
int periods_until(DelayedBit& bit, bool input, double on, double off) {
    int n = 1;
    while (bit.step(input, on, off, dt) != input && n < 100) ++n;
    return n;
}

TEST(DelayedBit, WithoutDelaysItFollowsAtOnce) {
    DelayedBit bit;
    EXPECT_EQ(periods_until(bit, true, 0, 0), 1);
    EXPECT_EQ(periods_until(bit, false, 0, 0), 1);
}

TEST(DelayedBit, RisesAndFallsAfterItsDelays) {
    DelayedBit bit;
    EXPECT_EQ(periods_until(bit, true, 1, 0.5), 9);  // seen in one period, 1 s later in the ninth
    EXPECT_EQ(periods_until(bit, false, 1, 0.5), 5);
}

TEST(DelayedBit, ABreakStartsTheDelayAnew) {
    DelayedBit bit;
    for (int round = 0; round < 10; ++round) {
        for (int n = 0; n < 8; ++n) EXPECT_FALSE(bit.step(true, 1, 0, dt));
        EXPECT_FALSE(bit.step(false, 1, 0, dt));
    }
    EXPECT_EQ(periods_until(bit, true, 1, 1), 9);
    for (int round = 0; round < 10; ++round) {
        for (int n = 0; n < 8; ++n) EXPECT_TRUE(bit.step(false, 1, 1, dt));
        EXPECT_TRUE(bit.step(true, 1, 1, dt));
    }
}

TEST(DelayedBit, ARestDoesNotCountForTheDelay) {
    DelayedBit bit;
    for (int n = 0; n < 6; ++n) bit.step(false, 1, 5, dt);
    EXPECT_EQ(periods_until(bit, true, 1, 5), 9);
}

}  // namespace
}  // namespace plumb
