// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/edge.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(Edge, RisesOnceForEachRisingBit) {
    Edge edge;
    EXPECT_TRUE(edge.rises(true));
    EXPECT_FALSE(edge.rises(true));
    EXPECT_FALSE(edge.rises(false));
    EXPECT_TRUE(edge.rises(true));
}

TEST(Edge, ChangesBothWays) {
    Edge edge;
    EXPECT_FALSE(edge.changes(false));
    EXPECT_TRUE(edge.changes(true));
    EXPECT_FALSE(edge.changes(true));
    EXPECT_TRUE(edge.changes(false));
}

TEST(Edge, ABitThatIsTrueAlreadyDoesNotRise) {
    Edge edge{true};
    EXPECT_FALSE(edge.rises(true));
    EXPECT_FALSE(edge.rises(false));
    EXPECT_TRUE(edge.rises(true));
}

}  // namespace
}  // namespace plumb
