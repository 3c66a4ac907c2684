// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/oscillation_settings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

const Reciprocation base{0, 100, 200};

SpeedSections::Table table(const SpeedSection& first, const SpeedSection& second = {}) {
    SpeedSections::Table result{};
    result[0] = first;
    result[1] = second;
    return result;
}

TEST(SpeedSections, AHeightHoldsForBothStrokesOrForOne) {
    const SpeedSection window{SpeedSection::height, 30, 70, 0.5};
    for (const bool upward : {false, true}) {
        const auto spans = SpeedSections::spans(table(window), base, upward);
        ASSERT_EQ(spans.count, 1u);
        EXPECT_EQ(spans.list[0], (SpeedSpan{30, 70, 0.5}));
    }
    const SpeedSection up{SpeedSection::height_upward, 30, 70, 0.5};
    EXPECT_EQ(SpeedSections::spans(table(up), base, true).count, 1u);
    EXPECT_EQ(SpeedSections::spans(table(up), base, false).count, 0u);
    const SpeedSection down{SpeedSection::height_downward, 30, 70, 0.5};
    EXPECT_EQ(SpeedSections::spans(table(down), base, true).count, 0u);
    EXPECT_EQ(SpeedSections::spans(table(down), base, false).count, 1u);
}

TEST(SpeedSections, APhaseBeyondPiIsOnTheDownwardStroke) {
    const SpeedSection down{SpeedSection::phase, 1.25 * pi, 1.5 * pi, 0.5};
    EXPECT_EQ(SpeedSections::spans(table(down), base, true).count, 0u);
    const auto spans = SpeedSections::spans(table(down), base, false);
    ASSERT_EQ(spans.count, 1u);
    EXPECT_NEAR(spans.list[0].from, base.position(1.5 * pi), 1e-9);
    EXPECT_NEAR(spans.list[0].to, base.position(1.25 * pi), 1e-9);
}

TEST(SpeedSections, ASectionAroundADeadPointIsOnBothStrokes) {
    const SpeedSection wraps{SpeedSection::phase, 1.75 * pi, 0.25 * pi, 0.5};
    for (const bool upward : {false, true}) {
        const auto spans = SpeedSections::spans(table(wraps), base, upward);
        ASSERT_EQ(spans.count, 1u) << upward;
        EXPECT_NEAR(spans.list[0].from, 0, 1e-9);
        EXPECT_NEAR(spans.list[0].to, base.position(0.25 * pi), 1e-9);
    }
    const SpeedSection upper{SpeedSection::phase, 0.75 * pi, 1.25 * pi, 0.5};
    for (const bool upward : {false, true}) {
        const auto spans = SpeedSections::spans(table(upper), base, upward);
        ASSERT_EQ(spans.count, 1u) << upward;
        EXPECT_NEAR(spans.list[0].to, 100, 1e-9);
    }
}

TEST(SpeedSections, AreAscendingAndCutAtTheDeadPoints) {
    const auto spans = SpeedSections::spans(
        table({SpeedSection::height, 60, 200, 2}, {SpeedSection::height, -50, 10, 3}), base, true);
    ASSERT_EQ(spans.count, 2u);
    EXPECT_EQ(spans.list[0], (SpeedSpan{0, 10, 3}));
    EXPECT_EQ(spans.list[1], (SpeedSpan{60, 100, 2}));
    EXPECT_EQ(SpeedSections::ratio_at(spans, 0), 3);
    EXPECT_EQ(SpeedSections::ratio_at(spans, 30), 1);
}

TEST(SpeedSections, OverlapIsFoundInEitherDirection) {
    const SpeedSection window{SpeedSection::height, 30, 70, 0.5};
    EXPECT_FALSE(SpeedSections::overlap(table(window, {SpeedSection::height, 70, 80, 2}), base));
    EXPECT_TRUE(SpeedSections::overlap(table(window, {SpeedSection::height, 60, 80, 2}), base));
    EXPECT_TRUE(SpeedSections::overlap(table(window, {SpeedSection::phase, 1.4 * pi, 1.6 * pi, 2}), base));
    EXPECT_FALSE(SpeedSections::overlap(
        table({SpeedSection::height_upward, 30, 70, 0.5}, {SpeedSection::phase, 1.4 * pi, 1.6 * pi, 2}),
        base));
}

TEST(SpeedSections, ImpossibleOnesAreRefused) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(SpeedSections::valid(table({SpeedSection::phase, 6, 1, 0.5})));
    for (const SpeedSection& bad : {SpeedSection{SpeedSection::height, 30, 70, 0},
                                    {SpeedSection::height, 30, 70, -1},
                                    {SpeedSection::height, 30, 70, nan},
                                    {SpeedSection::height, 70, 30, 1},
                                    {SpeedSection::height, nan, 30, 1},
                                    {SpeedSection::phase, -1, 1, 1},
                                    {SpeedSection::phase, 1, 7, 1},
                                    {SpeedSection::phase, 1, 1, 1},
                                    {9, 0, 1, 1}})
        EXPECT_FALSE(SpeedSections::valid(table(bad)));
}

}  // namespace
}  // namespace plumb
