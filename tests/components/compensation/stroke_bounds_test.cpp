// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/chopping_codes.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(StrokeBounds, ShowsTheFirstThatIsActive) {
    StrokeBounds it;
    StrokeBounds::Active now{true, true, true, true, true, true, true};
    const auto shown = [&] {
        it.step(now, true);
        return it.bound();
    };
    EXPECT_EQ(shown(), Bound::offset);
    now.offset = false;
    EXPECT_EQ(shown(), Bound::stage);
    now.stage = false;
    EXPECT_EQ(shown(), Bound::soft_limit);
    now.soft_limit = false;
    EXPECT_EQ(shown(), Bound::learning);
    now.learning = false;
    EXPECT_EQ(shown(), Bound::speed);
    now.speed = false;
    EXPECT_EQ(shown(), Bound::plan);
}

TEST(StrokeBounds, ALatePlanCountsUntilTheAxisRests) {
    StrokeBounds it;
    StrokeBounds::Active late, arrival;
    late.late = arrival.arrival = true;
    it.step(late, true);
    it.step(arrival, true);
    EXPECT_EQ(it.bound(), Bound::plan);
    it.step({}, false);
    it.step(arrival, true);
    EXPECT_EQ(it.bound(), Bound::arrival);
}

TEST(StrokeBounds, ALatePlanAndTheInfeedItselfDoNotHinderTheInfeed) {
    StrokeBounds it;
    StrokeBounds::Active late, waits, arrival;
    waits.infeed_late = waits.infeed_cut = true;
    it.step(waits, true);
    EXPECT_EQ(it.bound(), Bound::infeed_late);
    EXPECT_FALSE(it.hinders_infeed());
    arrival.arrival = true;
    it.step(arrival, true);
    EXPECT_TRUE(it.hinders_infeed());
    late.late = true;
    it.step(late, true);
    EXPECT_FALSE(it.hinders_infeed());
}

TEST(StrokeBounds, AtRestOnlyTheOffsetCounts) {
    StrokeBounds it;
    it.step({false, true, true, true, true, true, true}, false);
    EXPECT_EQ(it.bound(), Bound::none);
    it.step({true}, false);
    EXPECT_EQ(it.bound(), Bound::offset);
}

}  // namespace
}  // namespace plumb
