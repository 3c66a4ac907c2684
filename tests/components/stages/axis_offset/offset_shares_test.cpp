// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/stages/axis_offset/external_offset.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double step = 1e-4, grain = 1e-4;

TEST(OffsetShares, WithoutAGuestAllIsItsOwn) {
    OffsetShares shares;
    for (const double in_force : {0.0, 0.1, -5.0, 0.05}) {
        shares.divide(in_force, {0.05, 0, false}, step, grain);
        EXPECT_EQ(shares.own(), in_force);
        EXPECT_EQ(shares.guest(), 0);
    }
}

TEST(OffsetShares, OwnPartFollowsItsRequestWhileTheGuestIsUnderWay) {
    OffsetShares shares;
    shares.divide(0.05, {0.05, 0, false}, step, grain);
    double own = 0.05;
    for (int n = 1; n <= 100; ++n) {  // the guest to -4, the own part the other way
        own += step;
        shares.divide(own - 0.04 * n, {own, -4, false}, step, grain);
        ASSERT_NEAR(shares.own(), own, 1e-9);
        ASSERT_NEAR(shares.guest(), -0.04 * n, 1e-9);
    }
    shares.divide(own - 4 + grain / 2, {own, -4, false}, step, grain);
    EXPECT_EQ(shares.guest(), -4);
}

TEST(OffsetShares, NothingMovesBothWhileLinuxCncMovesNothing) {
    OffsetShares shares;
    shares.divide(0.05, {0.05, 0, false}, step, grain);
    shares.divide(0.05, {0.07, 3, false}, step, grain);
    EXPECT_EQ(shares.own(), 0.05);
    EXPECT_EQ(shares.guest(), 0);
}

TEST(OffsetShares, HeldGuestHasWhatItTakesToBrakeAndNoMore) {
    OffsetShares shares;
    shares.divide(0.1, {0, 10, false}, step, grain);
    shares.divide(0.2, {0, 10, false}, step, grain);
    shares.divide(0.25, {0, 0.2, true}, step, grain);
    shares.divide(0.26, {0, 0.25, true}, step, grain);
    EXPECT_NEAR(shares.guest(), 0.26, 1e-12);
    shares.divide(0.259, {0, 0.26, true}, step, grain);  // it turns
    EXPECT_NEAR(shares.guest(), 0.26, 1e-12);
    EXPECT_NEAR(shares.own(), -0.001, 1e-12);
}

}  // namespace
}  // namespace plumb
