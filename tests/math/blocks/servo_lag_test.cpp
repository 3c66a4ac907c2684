// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/servo_lag.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TEST(ServoLag, FollowsARampAtSpeedOverGainForAnyPeriod) {
    for (const double dt : {0.0005, 0.001, 0.01, 0.1}) {
        ServoLag axis;
        double u = 0;
        for (double t = 0; t < 2; t += dt) axis.step(u += 5 * dt, 30, dt);
        EXPECT_NEAR(u - axis.value(), 5 / 30., 1e-9) << dt;
    }
}

TEST(ServoLag, AnswersToTheStartOfARampAsInTheTextbook) {
    // y = v (t - (1 - exp(-K t)) / K)
    ServoLag axis;
    for (int i = 1; i <= 50; ++i) axis.step(5 * 0.001 * i, 30, 0.001);
    EXPECT_NEAR(axis.value(), 5 * (0.05 - (1 - std::exp(-30 * 0.05)) / 30), 1e-12);
}

TEST(ServoLag, ComesToRestAtItsCommand) {
    ServoLag axis;
    axis.reset(3);
    EXPECT_EQ(axis.step(3, 30, 0.001), 3);
    for (int i = 0; i < 2000; ++i) axis.step(7, 30, 0.001);
    EXPECT_NEAR(axis.value(), 7, 1e-12);
}

}  // namespace
}  // namespace plumb
