// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_settings.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s

StrokeSettings good() {
    StrokeSettings its;
    its.max_acceleration = 1000;
    its.max_feed = 200;
    its.min_limit = -100;
    its.max_limit = 100;
    its.lower = -20;
    its.upper = -8;
    its.feed = 60;
    its.max_offset = 500;
    its.max_rate = 500;
    its.max_lead = 0.02;
    its.max_output_acceleration = 3000;
    its.inset = 0.3;
    its.in_range = true;
    return its;
}

TEST(StrokeInForce, ARefusedRegionLeavesTheLastOneWithItsSettings) {
    StrokeInForce it;
    ASSERT_EQ(it.take(good(), 0, dt), Fault::none);
    StrokeSettings given = good();
    given.lower = -8;
    given.feed = 70;
    EXPECT_EQ(it.take(given, 0, dt), Fault::region);
    given.lower = -200;
    EXPECT_EQ(it.take(given, 0, dt), Fault::soft_limit);
    EXPECT_EQ(it.stroke(1, 0).lower, -20);
    EXPECT_EQ(it.speed(1), 60);
}

TEST(StrokeInForce, ChangedSettingsComeAsAWholeOrNotAtAll) {
    StrokeInForce it;
    ASSERT_EQ(it.take(good(), 0, dt), Fault::none);
    StrokeSettings given = good();
    given.feed = 70;
    given.max_offset = 10;  // less than the stroke needs
    EXPECT_FALSE(it.judge(given, true, {0, true, 0, 0}, dt));
    EXPECT_EQ(it.refused(), Fault::soft_limit);
    EXPECT_EQ(it.speed(1), 60);
    given.max_offset = 500;
    EXPECT_TRUE(it.judge(given, true, {0, true, 0, 0}, dt));
    EXPECT_EQ(it.refused(), Fault::none);
    EXPECT_EQ(it.speed(1), 70);
}

TEST(StrokeInForce, TheLeadOfTheCommandThatRunsBoundsTheAcceleration) {
    StrokeInForce it;
    StrokeSettings given = good();
    given.lead = 0.002;
    given.jerk_time = 0.02;
    ASSERT_EQ(it.take(given, 0, dt), Fault::none);
    given.lead = 0;
    given.max_acceleration = 2900;  // times 1.2 is more than 3000
    EXPECT_FALSE(it.judge(given, true, {0, true, 0.002, 0.02}, dt));
    EXPECT_EQ(it.refused(), Fault::lead);
    EXPECT_FALSE(it.judge(given, true, {0, false, 0.002, 0.02}, dt));
    EXPECT_EQ(it.refused(), Fault::none) << "at rest the next start has the lead that is given";
    EXPECT_EQ(it.values().max_acceleration, 2900);
}

TEST(StrokeInForce, AWayToTheEndNeedsNoRegion) {
    StrokeInForce it;
    it.begin(good());
    StrokeSettings given = good();
    given.in_range = false;
    EXPECT_TRUE(it.take_end(given, 3, dt)) << "with the last settings";
    EXPECT_EQ(it.stroke(1, 3).end_position, 3);
    EXPECT_EQ(it.speed(1), 200);
    StrokeInForce other;
    EXPECT_FALSE(other.take_end(given, 3, dt));
}

TEST(StrokeInForce, TheSpeedIsStretchedWithinBoundsAndPartOfItIsLearned) {
    StrokeInForce it;
    ASSERT_EQ(it.take(good(), 0, dt), Fault::none);
    it.stretch(1.0001);
    EXPECT_EQ(it.speed(1), 60) << "within a thousandth";
    it.stretch(1.5);
    EXPECT_DOUBLE_EQ(it.speed(0.2), 18);
    for (int i = 0; i < 50; ++i) it.stretch(2);
    EXPECT_DOUBLE_EQ(it.speed(1), 600);
    it.begin_strokes();
    EXPECT_EQ(it.speed(1), 60);
}

TEST(StrokeInForce, ALearnedStrokeBelongsToTheCommandOfItsStart) {
    StrokeInForce it;
    StrokeSettings given = good();
    given.jerk_time = 0.02;
    ASSERT_EQ(it.take(given, 0, dt), Fault::none);
    it.begin_strokes();
    const auto before = it.learned_stroke();
    given.jerk_time = 0.03;
    ASSERT_TRUE(it.judge(given, true, {0, true, 0, 0.02}, dt));
    EXPECT_TRUE(it.learned_stroke() == before);
    it.begin_strokes();
    EXPECT_FALSE(it.learned_stroke() == before);
}

TEST(StrokeInForce, TheInsetIsAPartOfAShortStroke) {
    StrokeInForce it;
    StrokeSettings given = good();
    given.lower = -10;
    ASSERT_EQ(it.take(given, 0, dt), Fault::none);
    EXPECT_DOUBLE_EQ(it.learning().inset, 0.1);
}

}  // namespace
}  // namespace plumb
