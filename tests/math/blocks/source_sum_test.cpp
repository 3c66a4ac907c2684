// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/source_sum.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

TEST(SourceSum, AnInvalidSourceKeepsItsLastGoodValue) {
    SourceSum<3> sum;
    std::array<double, 3> given{1, 20, 300};
    EXPECT_EQ(sum.value(), 0);
    EXPECT_TRUE(sum.read(given, 1000));
    EXPECT_EQ(sum.value(), 321);
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1000.1, -1e308}) {
        given = {2, bad, 300};
        EXPECT_FALSE(sum.read(given, 1000));
        EXPECT_EQ(sum.value(), 322);
    }
    given = {0, -1000, 1000};
    EXPECT_TRUE(sum.read(given, 1000));
    EXPECT_EQ(sum.value(), 0);
}

}  // namespace
}  // namespace plumb
