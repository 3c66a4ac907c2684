// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_orders.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <limits>

namespace plumb {
namespace {

constexpr double farthest = 1e6, at = 40;  // mu

// How many of these positions, one a period, cross the coordinate.
int crossings(Crossing& it, std::initializer_list<double> positions, double coordinate = at) {
    int count = 0;
    for (const double position : positions) count += it.step(position, coordinate, farthest);
    return count;
}

TEST(Crossing, HappensOnceEitherWay) {
    Crossing it;
    EXPECT_EQ(crossings(it, {38, 39, 39.9}), 0);
    EXPECT_EQ(crossings(it, {40.1}), 1);
    EXPECT_EQ(crossings(it, {41, 45, 41, 40.1}), 0);
    EXPECT_EQ(crossings(it, {39.9}), 1);
    EXPECT_EQ(crossings(it, {30}), 0);
}

TEST(Crossing, HappensOnceWhereAMoveEndsAtTheCoordinate) {
    for (const double side : {-1.0, 1.0}) {
        Crossing it;
        EXPECT_EQ(crossings(it, {at + side}), 0);
        EXPECT_EQ(crossings(it, {at}), 1);
        EXPECT_EQ(crossings(it, {at, at, at}), 0) << "it stands there";
        EXPECT_EQ(crossings(it, {at - side, at - 2 * side}), 0) << "it has crossed already";
        EXPECT_EQ(crossings(it, {at, at}), 1);
        EXPECT_EQ(crossings(it, {at - side}), 1) << "back, the way that it came";
    }
}

TEST(Crossing, AnAxisThatBeginsAtTheCoordinateHasNotCrossedIt) {
    Crossing it;
    EXPECT_EQ(crossings(it, {at, at, at + 1, at + 2}), 0);
    EXPECT_EQ(crossings(it, {at - 1}), 1);
}

TEST(Crossing, ANewCoordinateIsNoCrossing) {
    Crossing it;
    EXPECT_EQ(crossings(it, {39, 39}), 0);
    EXPECT_EQ(crossings(it, {39, 39}, 30), 0) << "from below to above it";
    EXPECT_EQ(crossings(it, {29}, 30), 1);
    EXPECT_EQ(crossings(it, {28, 27}, 28), 0);
    EXPECT_EQ(crossings(it, {29}, 28), 1);
}

TEST(Crossing, AnInvalidValueIsNoCrossingAndForgetsNoSide) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    Crossing it;
    EXPECT_EQ(crossings(it, {39, nan, 1e7, -1e7, 39}), 0);
    EXPECT_EQ(crossings(it, {41}, nan), 0);
    EXPECT_EQ(crossings(it, {39}), 0);
    EXPECT_EQ(crossings(it, {nan, 41}), 1) << "a crossing meanwhile counts later";
}

}  // namespace
}  // namespace plumb
