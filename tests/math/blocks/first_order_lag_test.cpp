// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/first_order_lag.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

double step_response(double tau, double t, double dt) {
    FirstOrderLag lag;
    double y = 0;
    for (int i = 0; i < std::lround(t / dt); ++i) y = lag.step(1, tau, dt);
    return y;
}

TEST(FirstOrderLag, FollowsOneMinusExpOfTimeOverTau) {
    EXPECT_NEAR(step_response(600, 300, 0.001), 1 - std::exp(-0.5), 1e-9);
    EXPECT_NEAR(step_response(600, 600, 0.001), 1 - std::exp(-1.0), 1e-9);
}

TEST(FirstOrderLag, DoesNotDependOnTheThreadPeriod) {
    EXPECT_NEAR(step_response(600, 600, 0.001), step_response(600, 600, 10), 1e-9);
}

TEST(FirstOrderLag, FollowsAChangeOfItsTimeConstantAtOnce) {
    FirstOrderLag lag;
    lag.step(1, 1000, 1);
    const double before = lag.value();
    EXPECT_NEAR(lag.step(1, 1, 1), before + (1 - before) * (1 - std::exp(-1.0)), 1e-12);
}

TEST(FirstOrderLag, WithoutLagPassesItsInput) {
    EXPECT_EQ(step_response(0, 1, 1), 1);
    EXPECT_EQ(step_response(std::numeric_limits<double>::quiet_NaN(), 1, 1), 1);
}

TEST(FirstOrderLag, RefusesToBecomeNotFinite) {
    FirstOrderLag lag(0.5);
    for (const double bad :
         {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        EXPECT_EQ(lag.step(bad, 1, 0.001), 0.5);
        EXPECT_EQ(lag.step(bad, 0, 0.001), 0.5);
    }
    lag.set(-1.7e308);
    EXPECT_TRUE(std::isfinite(lag.step(1.7e308, 1, 0.001)));
    EXPECT_TRUE(std::isfinite(lag.step(1.7e308, 1e-300, 0.001)));
}

}  // namespace
}  // namespace plumb
