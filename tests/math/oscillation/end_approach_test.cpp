// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/climb.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double demand = 1000, room = 0.005;  // mu/s2, mu

TEST(EndApproach, BeginsAtAFractionAndRisesToAQuarter) {
    EndApproach it;
    EXPECT_DOUBLE_EQ(it.acceleration({demand}, room), 40);
    for (double last = 40; last < 250;) {
        it.ended({demand}, last, 0, room);
        const double now = it.acceleration({demand}, room);
        EXPECT_LE(now, 1.6001 * last);
        EXPECT_GT(now, last);
        last = now;
    }
    EXPECT_DOUBLE_EQ(it.acceleration({demand}, room), 250);
    it.begin();
    EXPECT_DOUBLE_EQ(it.acceleration({demand}, room), 40);
}

TEST(EndApproach, NeverHasMoreThanAQuarterOfTheStrokesOfNow) {
    EndApproach it;
    EXPECT_DOUBLE_EQ(it.acceleration({demand, 0.04}, room), 10);
    it.ended({demand}, 200, 0, room);
    EXPECT_DOUBLE_EQ(it.acceleration({500}, room), 125);
}

TEST(EndApproach, BeginsSlowerWhereTheAxisOvershootsInItsStrokes) {
    const EndApproach it;
    EXPECT_DOUBLE_EQ(it.acceleration({demand, 1, 1e-4}, room), 25);
    EXPECT_DOUBLE_EQ(it.acceleration({demand, 1, 1e-6}, room), 40);
}

TEST(EndApproach, NeverStandsStillBecauseAScaleReadsAnotherPlace) {
    EndApproach it;
    for (int i = 0; i < 9; ++i) it.ended({demand}, it.acceleration({demand}, room), 0.1, room);
    EXPECT_DOUBLE_EQ(it.acceleration({demand}, room), 4);
}

// An axis that goes beyond in proportion to the acceleration comes to rest at half of the room.
TEST(EndApproach, KeepsTheAxisWithinTheRoom) {
    for (const double each : {1e-4, 1e-5}) {  // mu of each mu/s2
        EndApproach it;
        double beyond = 0;
        for (int i = 0; i < 10; ++i) {
            const double now = it.acceleration({demand}, room);
            beyond = each * now;
            if (i > 0) {
                EXPECT_LE(beyond, room);
            }
            it.ended({demand}, now, beyond, room);
        }
        EXPECT_NEAR(beyond, each > 5e-5 ? room / 2 : 0.0025, 1e-9);
    }
}

}  // namespace
}  // namespace plumb
