// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/stages/joint_offset/offset_release.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

using Release = OffsetRelease<2>;
using Sources = std::array<double, 2>;

constexpr Release::Which first{true, false};

// A period in which the offset follows its sources.
void follow(Release& it, const Sources& sources, bool on = true) {
    const auto sums = it.sum(sources, first);
    it.step(on);
    it.note(sums.all, sums.others, true);
}

TEST(OffsetRelease, ReleasesOnlyTheSourcesThatAreToBeReleased) {
    Release it;
    follow(it, {-35, 0.05});
    EXPECT_EQ(it.in_feedback(-34.95), -34.95);
    EXPECT_FALSE(it.step(false)) << "motion has not copied the feedback yet";
    EXPECT_TRUE(it.pending());
    EXPECT_EQ(it.in_feedback(-34.95), 0.05);
    EXPECT_TRUE(it.released()) << "for the source, which comes after motion";
    EXPECT_TRUE(it.step(false));
    EXPECT_FALSE(it.pending());
    EXPECT_EQ(it.stays(), 0.05);
    EXPECT_EQ(it.in_feedback(0.05), 0.05);
    EXPECT_TRUE(it.released());
    it.step(true);
    EXPECT_FALSE(it.released());
}

TEST(OffsetRelease, OnAgainInThatPeriodReleasesNothing) {
    Release it;
    follow(it, {-35, 0.05});
    it.step(false);
    it.in_feedback(-34.95);
    EXPECT_FALSE(it.step(true));
    EXPECT_FALSE(it.released());
    EXPECT_EQ(it.in_feedback(-34.95), -34.95);
}

TEST(OffsetRelease, AReleasedSourceCountsAgainWhenItHasBeenZero) {
    Release it;
    follow(it, {-35, 0.05});
    it.step(false);
    it.in_feedback(-34.95);
    it.step(false);
    EXPECT_EQ(it.sum(Sources{-35, 0.05}, first).all, 0.05);
    EXPECT_TRUE(it.ignores());
    it.sum(Sources{0, 0.05}, first);
    EXPECT_FALSE(it.ignores());
    EXPECT_EQ(it.sum(Sources{-3, 0.05}, first).all, -2.95);
}

TEST(OffsetRelease, AnOffsetThatDoesNotFollowKeepsWhatTheOthersExplain) {
    Release it;
    follow(it, {-35, 0.05});
    it.sum(Sources{-20, 0.05}, first);
    it.note(-35, 0.05, false);  // it is held
    EXPECT_TRUE(it.out());
    EXPECT_EQ(it.stays(), 0);
    it.note(0.03, 0.05, false);
    EXPECT_EQ(it.stays(), 0.03);
}

TEST(OffsetRelease, WithoutAStrokeNothingIsTaken) {
    Release it;
    follow(it, {0, 0.05});
    it.sum(Sources{0, 0.01}, first);
    it.note(0.04, 0.01, false);  // it ramps
    EXPECT_FALSE(it.out());
    EXPECT_EQ(it.stays(), 0.04);
}

}  // namespace
}  // namespace plumb
