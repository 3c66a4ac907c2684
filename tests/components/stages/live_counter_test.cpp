// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/stages/stage_permit.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

// Whether it is alive after so many more periods of one value.
bool alive_after(LiveCounter& counter, std::int32_t value, int periods) {
    for (int n = 0; n < periods; ++n) counter.step(value);
    return counter.alive();
}

TEST(LiveCounter, IsAliveWhileItCounts) {
    LiveCounter counter;
    EXPECT_FALSE(alive_after(counter, 41, 1));
    for (std::int32_t n = 42; n < 200; ++n) EXPECT_TRUE(alive_after(counter, n, 1));
    EXPECT_TRUE(alive_after(counter, std::numeric_limits<std::int32_t>::max(), 1));
    EXPECT_TRUE(alive_after(counter, 0, 1));
}

TEST(LiveCounter, IsDeadTenPeriodsAfterItsLastChange) {
    LiveCounter counter;
    counter.step(1);
    EXPECT_TRUE(alive_after(counter, 2, 10));
    EXPECT_FALSE(alive_after(counter, 2, 1));
    EXPECT_FALSE(alive_after(counter, 2, 100000));
    EXPECT_TRUE(alive_after(counter, 3, 1));
}

TEST(LiveCounter, AValueThatWasLeftBehindIsDeadFromTheFirstPeriodOn) {
    for (const std::int32_t value : {0, 1, 77}) {
        LiveCounter counter;
        EXPECT_FALSE(counter.alive());
        EXPECT_FALSE(alive_after(counter, value, 1));
        EXPECT_FALSE(alive_after(counter, value, 1000));
    }
}

TEST(LiveCounter, IsMissedTenPeriodsAfterItsDeath) {
    LiveCounter counter;
    counter.step(0);  // it has not counted yet
    EXPECT_FALSE(counter.alive());
    EXPECT_FALSE(counter.missed());
    alive_after(counter, 1, 20);
    EXPECT_FALSE(counter.missed());
    alive_after(counter, 1, 1);
    EXPECT_TRUE(counter.missed());
    alive_after(counter, 2, 1);
    EXPECT_FALSE(counter.missed());
    LiveCounter left_behind;
    alive_after(left_behind, 7, 11);
    EXPECT_TRUE(left_behind.missed());
}

TEST(LiveCounter, BelowZeroNobodyCountsAndItIsAlive) {
    LiveCounter counter;
    EXPECT_TRUE(alive_after(counter, -1, 1));
    EXPECT_TRUE(alive_after(counter, std::numeric_limits<std::int32_t>::min(), 1000));
    EXPECT_FALSE(alive_after(counter, 5, 1));  // now somebody should
    EXPECT_TRUE(alive_after(counter, 6, 1));
    EXPECT_TRUE(alive_after(counter, -1, 1000));
}

}  // namespace
}  // namespace plumb
