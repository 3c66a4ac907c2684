// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth/probed_growth.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

TEST(MeanOverTime, WeighsByTimeAndIgnoresInvalidValues) {
    MeanOverTime mean;
    EXPECT_FALSE(mean.take().has_value());
    mean.step(1000, 1e6, 1);
    mean.step(std::numeric_limits<double>::quiet_NaN(), 1e6, 5);
    mean.step(2e6, 1e6, 5);
    mean.step(4000, 1e6, 2);
    EXPECT_DOUBLE_EQ(*mean.take(), 3000);
    EXPECT_FALSE(mean.take().has_value());  // it begins again
}

}  // namespace
}  // namespace plumb
