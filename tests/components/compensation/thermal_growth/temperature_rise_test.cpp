// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth/probed_growth.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(TemperatureRise, CountsFromTheFirstValidTemperatureToTheHighest) {
    TemperatureRise rise;
    EXPECT_TRUE(rise.reached(0.5, 0xff));  // no sensor was valid
    rise.take(1, NAN);
    rise.take(1, 20);
    EXPECT_FALSE(rise.reached(0.5, 0xff));
    EXPECT_TRUE(rise.reached(0.5, 0x01));  // another sensor is asked for
    rise.take(1, 20.5);
    rise.take(1, 19);
    EXPECT_TRUE(rise.reached(0.5, 0x02));
    EXPECT_FALSE(rise.reached(0.6, 0x02));
    EXPECT_EQ(rise.now()[1], 19);
    rise.take(1, NAN);
    EXPECT_TRUE(std::isnan(rise.now()[1]));
    rise.clear();
    EXPECT_TRUE(rise.reached(0.5, 0x02));
}

}  // namespace
}  // namespace plumb
