// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth/probed_growth.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(ProbedBore, SeparatesTheFaceFromTheCircle) {
    ProbedBore bore;
    EXPECT_FALSE(bore.has_circle() || bore.has_face());
    bore.add(-3, 7, 8, -100);
    bore.add(3, 7, 8, -100.5);
    EXPECT_TRUE(bore.has_face());
    EXPECT_FALSE(bore.has_circle());
    EXPECT_DOUBLE_EQ(bore.face(), -100.25);
    EXPECT_DOUBLE_EQ(bore.face_range(), 0.5);
    bore.add(1, 12, 5, -105);
    bore.add(-1, -8, 5, -105);
    EXPECT_FALSE(bore.centre().has_value());
    bore.add(2, 2, 15, -105);
    ASSERT_TRUE(bore.centre().has_value());
    EXPECT_NEAR(bore.centre()->place.x(), 2, 1e-9);
    EXPECT_NEAR(bore.centre()->place.y(), 5, 1e-9);
    bore.clear();
    EXPECT_FALSE(bore.has_circle() || bore.has_face());
    bore.add(3, 0, 0, 4);
    EXPECT_EQ(bore.face_range(), 0);
}

TEST(BoreReferences, LaterPassesDeviateFromTheFirstOne) {
    BoreReferences references;
    const std::size_t z = BoreReferences::value(3, true) + 2;
    EXPECT_EQ(references.deviation(z, 5, 1), 0);
    EXPECT_TRUE(references.known(z));
    EXPECT_FALSE(references.deviation(z, 5.1, 1).has_value());  // again in the same pass
    EXPECT_DOUBLE_EQ(*references.deviation(z, 5.25, 2), 0.25);
    EXPECT_FALSE(references.deviation(z - 1, 1, 2).has_value());  // not probed in the first pass
    EXPECT_FALSE(references.known(z - 1));
    references.clear();
    EXPECT_FALSE(references.known(z));
}

TEST(BoreReferences, EachCoordinateOfEachBoreHasAPlace) {
    EXPECT_EQ(BoreReferences::value(1, false), 0u);
    EXPECT_EQ(BoreReferences::value(BoreReferences::most_bores, true) + 3,
              static_cast<std::size_t>(StopRule::most_values));
}

}  // namespace
}  // namespace plumb
