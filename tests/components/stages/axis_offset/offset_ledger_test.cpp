// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/stages/axis_offset/external_offset.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

namespace plumb {
namespace {

constexpr double limit = 0.15, grain = 1e-4, step = 1e-3;

GuestOffset::Given guest_at(std::int32_t counts) {
    return {counts, 0.001, true, false};
}

// A guest at 0.05 and an own part at 0.1, both in force.
OffsetLedger both() {
    OffsetLedger ledger;
    ledger.listen(guest_at(0), true);
    ledger.listen(guest_at(50), true);
    for (int i = 0; i < 200; ++i) {
        ledger.approach(0.1, step, 1);
        ledger.divide(ledger.asked(), step, grain);
    }
    return ledger;
}

TEST(OffsetLedger, AskedIsTheOwnPartAndTheGuests) {
    const OffsetLedger ledger = both();
    EXPECT_NEAR(ledger.own(), 0.1, 1e-12);
    EXPECT_NEAR(ledger.guest().request(), 0.05, 1e-12);
    EXPECT_NEAR(ledger.asked(), 0.15, 1e-12);
    EXPECT_NEAR(ledger.own_in_force(), 0.1, 1e-9);
    EXPECT_NEAR(ledger.guest_in_force(), 0.05, 1e-9);
}

TEST(OffsetLedger, TakingStockKeepsTheInvariant) {
    for (const double asked : {0.0, 0.03, 0.15, -0.1, 2.0, -300.0}) {
        OffsetLedger ledger = both();
        ledger.take_stock(asked, 0.15, limit, grain);
        EXPECT_NEAR(ledger.asked(), asked, 1e-9);
        EXPECT_LE(std::abs(ledger.own()), limit) << asked;
    }
}

TEST(OffsetLedger, TheGuestKeepsItsPartWhereItCan) {
    OffsetLedger ledger = both();
    ledger.take_stock(0.03, 0.03, limit, grain);
    EXPECT_NEAR(ledger.guest().request(), 0.05, 1e-12);
    EXPECT_NEAR(ledger.own(), -0.02, 1e-12);
    ledger.take_stock(0, 0, limit, grain);  // all was cleared
    EXPECT_EQ(ledger.guest().request(), 0);
    EXPECT_EQ(ledger.own(), 0);
}

TEST(OffsetLedger, TheOwnPartWaitsForTheAxis) {
    OffsetLedger ledger;
    for (int i = 0; i < 100; ++i) ledger.approach(1, step, 0.01);  // nothing is in force
    EXPECT_NEAR(ledger.own(), 0.01 + step, step);
    ledger.approach(-1, step, 0.01);  // back to the axis at any time
    EXPECT_LT(ledger.own(), 0.01 + step / 2);
}

TEST(OffsetLedger, ForgettingLeavesNothing) {
    OffsetLedger ledger = both();
    ledger.forget();
    EXPECT_EQ(ledger.asked(), 0);
    EXPECT_EQ(ledger.own_in_force(), 0);
    EXPECT_EQ(ledger.guest_in_force(), 0);
}

}  // namespace
}  // namespace plumb
