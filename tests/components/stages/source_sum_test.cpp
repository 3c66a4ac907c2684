// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/stages/stage_permit.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

TEST(SourceSum, AnInvalidSourceKeepsItsLastGoodValue) {
    SourceSum sum;
    std::array<double, 4> given{1, 20, 300, 0};
    EXPECT_EQ(sum.value(), 0);
    EXPECT_TRUE(sum.read(given, Permit{}));
    EXPECT_EQ(sum.value(), 321);
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1000.1, -1e308}) {
        given = {2, bad, 300, 0};
        EXPECT_FALSE(sum.read(given, Permit{}));
        EXPECT_EQ(sum.value(), 322);
    }
    given = {0, -1000, 1000, 0};
    EXPECT_TRUE(sum.read(given, Permit{}));
    EXPECT_EQ(sum.value(), 0);
}

}  // namespace
}  // namespace plumb
