// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/bounded.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

TEST(Bounded, KeepsWhatLiesWithinTheLimit) {
    EXPECT_EQ(bounded(0.3, 1), 0.3);
    EXPECT_EQ(bounded(-1, 1), -1);
}

TEST(Bounded, CutsBothSidesAtTheLimit) {
    EXPECT_EQ(bounded(3, 1), 1);
    EXPECT_EQ(bounded(-infinity, 1), -1);
}

TEST(Bounded, AnUnusableLimitMeansZero) {
    EXPECT_EQ(bounded(3, -1), 0);
    EXPECT_EQ(bounded(3, not_a_number), 0);
}

TEST(Bounded, WhatIsNotANumberBecomesZero) {
    EXPECT_EQ(bounded(not_a_number, 1), 0);
}

}  // namespace
}  // namespace plumb
