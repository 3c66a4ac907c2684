// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_cycle.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

CycleTally::Cycle compared_cycle() {
    CycleTally::Cycle cycle;
    cycle.compared = cycle.complete = cycle.enabled = true;
    return cycle;
}

void cycle_with_a_rejection(CycleTally& tally) {
    tally.begin();
    tally.find();
    tally.reject(Rejection::beyond_gate);
    tally.end(compared_cycle());
}

TEST(CycleTally, ThreeCyclesThatRejectAllHaveLostTrack) {
    CycleTally tally;
    for (int i = 0; i < 3; ++i) {
        EXPECT_FALSE(tally.lost_track());
        cycle_with_a_rejection(tally);
        EXPECT_TRUE(tally.barren());
    }
    EXPECT_TRUE(tally.lost_track());
    tally.begin();
    tally.accept(false);
    EXPECT_FALSE(tally.lost_track() || tally.barren());
    EXPECT_EQ(tally.counts().accepted, 1);
    EXPECT_EQ(tally.counts().rejected, 3);
    EXPECT_EQ(tally.rejection(), Rejection::beyond_gate);
    EXPECT_EQ(tally.of_last_contact(), Rejection::none);
}

TEST(CycleTally, ALearningOrAbortedCycleIsNotBarren) {
    CycleTally tally;
    CycleTally::Cycle learning = compared_cycle();
    learning.learning = true;
    learning.fault = LearningFault::no_contact;
    tally.begin();
    tally.end(learning);
    EXPECT_EQ(tally.learning_fault(), LearningFault::no_contact);
    CycleTally::Cycle aborted = compared_cycle();
    aborted.complete = false;
    aborted.missed = 2;
    tally.begin();
    tally.end(aborted);
    EXPECT_FALSE(tally.barren());
    EXPECT_EQ(tally.counts().missed, 2);
}

TEST(CycleTally, AnUnexpectedContactIsNotARejectedOne) {
    CycleTally tally;
    tally.reject(Rejection::unexpected);
    EXPECT_EQ(tally.counts().unexpected, 1);
    EXPECT_EQ(tally.counts().rejected, 0);
}

}  // namespace
}  // namespace plumb
