// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/homed_watch.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

using Offset = HomedWatch::Offset;

TEST(HomedWatch, AHomedThatIsLostForAMomentLeavesTheOffsetAsItIsApplied) {
    HomedWatch it;
    EXPECT_EQ(it.step({true, false, true, true, 0}, 0.001), Offset::stays);
    for (int i = 0; i < 900; ++i) ASSERT_EQ(it.step({false, false, true, true, 0}, 0.001), Offset::stays);
    EXPECT_EQ(it.step({true, false, true, true, 0}, 0.001), Offset::as_applied);
}

TEST(HomedWatch, AStageHasReleasedItAfterASecondAndAnExtraJointWhereItIsMoved) {
    HomedWatch stage, joint;
    for (int i = 0; i < 1000; ++i) {
        stage.step({false, false, true, true, 0}, 0.001);
        ASSERT_EQ(joint.step({false, false, false, true, 0.5}, 0.001), Offset::stays);
    }
    EXPECT_EQ(stage.step({false, false, true, true, 0}, 0.001), Offset::none);
    EXPECT_EQ(joint.step({false, false, false, true, 0.52}, 0.001), Offset::none)
        << "0.02 farther than it was";
}

TEST(HomedWatch, AStageThatHoldsTheOffsetKeepsIt) {
    HomedWatch it;
    for (int i = 0; i < 3000; ++i) ASSERT_EQ(it.step({false, true, true, true, 5}, 0.001), Offset::stays);
    EXPECT_EQ(it.step({true, true, true, true, 5}, 0.001), Offset::as_applied);
}

}  // namespace
}  // namespace plumb
