// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_offset.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

using Offset = HomedWatch::Offset;

TEST(HomedWatch, AHomedThatIsLostForAMomentLeavesTheOffsetAsItIsApplied) {
    HomedWatch it;
    EXPECT_EQ(it.step(true, true, 0.001), Offset::stays);
    for (int i = 0; i < 900; ++i) ASSERT_EQ(it.step(false, true, 0.001), Offset::stays);
    EXPECT_EQ(it.step(true, true, 0.001), Offset::as_applied);
}

TEST(HomedWatch, AStageThatRampsItDownHasTakenItAwayAfterASecond) {
    HomedWatch it;
    for (int i = 0; i < 999; ++i) ASSERT_EQ(it.step(false, true, 0.001), Offset::stays);
    for (int i = 0; i < 3; ++i) it.step(false, true, 0.001);
    EXPECT_EQ(it.step(false, true, 0.001), Offset::none);
}

TEST(HomedWatch, WhereNoStageRampsItDownItStays) {
    HomedWatch it;
    for (int i = 0; i < 3000; ++i) ASSERT_EQ(it.step(false, false, 0.001), Offset::stays);
    EXPECT_EQ(it.step(true, false, 0.001), Offset::as_applied);
}

}  // namespace
}  // namespace plumb
