// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/error_table.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace plumb {
namespace {

int after(DirectionOfMotion& watch, const std::vector<double>& positions) {
    for (const double p : positions) watch.step(p, 0.5);
    return watch.direction();
}

TEST(DirectionOfMotion, IsUnknownUntilItHasMovedByTheDistance) {
    DirectionOfMotion watch;
    EXPECT_EQ(after(watch, {100, 100.4, 99.95}), 0);
    EXPECT_EQ(after(watch, {100.46}), 1);
}

TEST(DirectionOfMotion, TurnsWhenItHasGoneBackByTheDistance) {
    DirectionOfMotion watch;
    EXPECT_EQ(after(watch, {0, 10}), 1);
    EXPECT_EQ(after(watch, {9.5}), 1);
    EXPECT_EQ(after(watch, {9.49}), -1);
    EXPECT_EQ(after(watch, {9.9}), -1);
    EXPECT_EQ(after(watch, {10}), 1);
}

TEST(DirectionOfMotion, SmallJogsAddUpAndDitherTurnsNothing) {
    DirectionOfMotion watch;
    after(watch, {0, 10});
    for (int i = 0; i < 1000; ++i) EXPECT_EQ(after(watch, {9.76, 10.24}), 1);
    EXPECT_EQ(after(watch, {10.1, 9.9, 9.8}), 1);
    EXPECT_EQ(after(watch, {9.7}), -1);
}

TEST(DirectionOfMotion, APositionSetAnewTurnsNothing) {
    DirectionOfMotion watch;
    after(watch, {0, 10});
    watch.shift(-300);
    EXPECT_EQ(after(watch, {-290}), 1);
    EXPECT_EQ(after(watch, {-290.4}), 1);
    EXPECT_EQ(after(watch, {-290.6}), -1);
}

// Play of a sled between two stops: it is pushed by the distance behind the position.
TEST(DirectionOfMotion, IsThatOfASledThatIsPushedThroughAMillionMoves) {
    std::mt19937 random(20);
    std::uniform_real_distribution<double> way(-1, 1);
    DirectionOfMotion watch;
    double position = 0, left = 0;  // the sled reaches from left to left + distance
    int pushed = 0;
    watch.step(position, 0.25);
    bool first = true;
    for (int i = 0; i < 1'000'000; ++i) {
        position += way(random) * (i % 7 == 0 ? 2 : 0.1);
        watch.step(position, 0.25);
        if (first) {  // the sled is where the first move to one side takes it
            if (watch.direction() == 0) continue;
            first = false;
            pushed = watch.direction();
            left = pushed > 0 ? position - 0.25 : position;
        }
        if (position > left + 0.25) left = position - 0.25, pushed = 1;
        if (position < left) left = position, pushed = -1;
        ASSERT_EQ(watch.direction(), pushed) << i;
    }
}

}  // namespace
}  // namespace plumb
