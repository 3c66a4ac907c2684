// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/slew_limit.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

TEST(SlewLimit, ArrivesAfterDistanceOverRate) {
    SlewLimit slew;
    for (int i = 0; i < 499; ++i) slew.step(-1, 2, 0.001);
    EXPECT_GT(slew.value(), -1);
    slew.step(-1, 2, 0.001);
    EXPECT_NEAR(slew.value(), -1, 1e-12);
}

TEST(SlewLimit, ReachesItsTargetExactlyAndStays) {
    SlewLimit slew;
    for (int i = 0; i < 1000; ++i) slew.step(0.1, 1, 0.001);
    EXPECT_EQ(slew.value(), 0.1);
}

TEST(SlewLimit, NeverMovesFasterThanItsRate) {
    SlewLimit slew;
    double before = 0;
    for (const double target : {5.0, -3.0, 1e308, -1e308, 0.0}) {
        for (int i = 0; i < 100; ++i) {
            const double now = slew.step(target, 2, 0.001);
            EXPECT_LE(std::abs(now - before), 2 * 0.001 * (1 + 1e-12));
            before = now;
        }
    }
}

TEST(SlewLimit, HoldsOnWhatIsNotFinite) {
    SlewLimit slew;
    const double held = slew.step(1, 2, 0.001);
    for (const double bad : {infinity, -infinity, not_a_number}) {
        EXPECT_EQ(slew.step(bad, 2, 0.001), held);
        EXPECT_EQ(slew.step(1, bad, 0.001), held);
    }
    EXPECT_EQ(slew.step(1, -2, 0.001), held);
}

}  // namespace
}  // namespace plumb
