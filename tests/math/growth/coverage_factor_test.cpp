// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/coverage_factor.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(CoverageFactor,
     IsThatOfTheGuide) {  // to the expression of uncertainty in measurement, table G.2, 95.45 %
    EXPECT_NEAR(coverage_factor(1), 13.97, 0.005);
    EXPECT_NEAR(coverage_factor(2), 4.53, 0.005);
    EXPECT_NEAR(coverage_factor(3), 3.31, 0.005);
    EXPECT_NEAR(coverage_factor(5), 2.65, 0.005);
    EXPECT_NEAR(coverage_factor(10), 2.28, 0.005);
    EXPECT_NEAR(coverage_factor(50), 2.05, 0.005);
    EXPECT_NEAR(coverage_factor(1e6), 2.000, 0.0005);
}

}  // namespace
}  // namespace plumb
