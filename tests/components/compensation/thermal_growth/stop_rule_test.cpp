// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth/probed_growth.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(StopRule, ARiseCountsFromTheFirstValidTemperatureToTheHighest) {
    StopRule rule;
    const auto risen = [&](double least, std::uint32_t sensors) {
        StopRule::Settings settings;
        settings.sensors = sensors;
        return rule.has_risen(least, settings);
    };
    EXPECT_TRUE(risen(0.5, 0xff));  // no sensor was valid
    rule.sample(0, 1, NAN);
    rule.sample(60, 1, 20);
    EXPECT_FALSE(risen(0.5, 0xff));
    EXPECT_TRUE(risen(0.5, 0x01));  // another sensor is asked for
    rule.sample(120, 1, 20.5);
    rule.sample(180, 1, 19);
    EXPECT_TRUE(risen(0.5, 0x02));
    EXPECT_FALSE(risen(0.6, 0x02));
    rule.clear();
    EXPECT_TRUE(risen(0.5, 0x02));
}

}  // namespace
}  // namespace plumb
