// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/oscillation_settings.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

const Reciprocation example{20, 120, 200};  // a stroke of 100 mm at 200 mm/s

TEST(Reciprocation, HasTheFiguresOfTheTextbook) {
    EXPECT_NEAR(example.cycle_time(), 1.570796, 1e-6);
    EXPECT_DOUBLE_EQ(example.peak_acceleration(), 800);
    EXPECT_DOUBLE_EQ(example.position(0), 20);
    EXPECT_DOUBLE_EQ(example.position(pi / 2), 70);
    EXPECT_DOUBLE_EQ(example.position(pi), 120);
}

TEST(Reciprocation, PhaseIsTheInverseOfPositionInBothDirections) {
    for (double phase = 0.001; phase < 2 * pi; phase += 0.01)
        EXPECT_NEAR(example.phase(example.position(phase), phase < pi), phase, 1e-9) << phase;
    EXPECT_EQ(example.phase(20, true), 0);
    EXPECT_NEAR(example.phase(120, true), pi, 1e-12);
    EXPECT_NEAR(example.phase(130, true), pi, 1e-12) << "beyond the upper dead point";
    EXPECT_EQ(example.phase(10, true), 0) << "beyond the lower dead point";
}

TEST(Reciprocation, SpeedAtAPositionIsThatAtItsPhase) {
    for (double phase = 0; phase <= pi; phase += 0.01)
        EXPECT_NEAR(std::sqrt(example.speed_squared(example.position(phase))), 200 * std::sin(phase), 1e-6);
    EXPECT_EQ(example.speed_squared(121), 0);
}

TEST(Reciprocation, MeanSpeedAndCycleTimeGiveThePeakSpeed) {
    const double mean = 2 * example.stroke() / example.cycle_time();
    EXPECT_NEAR(Reciprocation::speed_of_mean(mean), 200, 1e-9);
    EXPECT_NEAR(Reciprocation::speed_of_cycle(example.cycle_time(), example.stroke()), 200, 1e-9);
}

}  // namespace
}  // namespace plumb
