// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

constexpr double dt = 0.001, lead = 0.01;  // s

TEST(LeadingCommand, LeadsByItsTimeTimesTheVelocity) {
    LeadingCommand it;
    it.begin(5, 1);
    double place = 5;
    for (int i = 0; i < 100; ++i) it.step(place += 60 * dt, lead, dt);
    EXPECT_NEAR(it.velocity(), 60, 1e-9);
    EXPECT_NEAR(it.acceleration(), 0, 1e-6);
    EXPECT_NEAR(it.mean(), place, 1e-9);
    EXPECT_NEAR(it.position(), place + 60 * lead, 1e-9);
}

TEST(LeadingCommand, IsTheMeanOfTheSamplesThatLimitTheJerk) {
    constexpr int samples = 20;
    LeadingCommand it;
    it.begin(0, samples);
    double place = 0;
    for (int i = 0; i < 100; ++i) it.step(place += 60 * dt, 0, dt);
    EXPECT_NEAR(it.mean(), place - 60 * dt * (samples - 1) / 2, 1e-9);  // half of their time later
    EXPECT_EQ(it.position(), it.mean()) << "without a lead";
}

// Of a mean over T of a motion with the acceleration a: the velocity steps by no more than a dt, so the lead
// adds lead a / T to the acceleration in each period, and the jerk is at most 2 a / T.
TEST(LeadingCommand, ALeadAddsItsTimeTimesTheJerkToTheAcceleration) {
    constexpr int samples = 20;
    constexpr double a = 1000;
    LeadingCommand it;
    it.begin(0, samples);
    double place = 0, speed = 0, last[3] = {0, 0, 0}, hardest = 0;
    for (int i = 0; i < 400; ++i) {
        const double now = i % 100 < 50 ? a : -a;
        speed += now * dt;
        it.step(place += speed * dt, lead, dt);
        last[0] = last[1];
        last[1] = last[2];
        last[2] = it.position();
        if (i > 2) hardest = std::max(hardest, std::abs(last[2] - 2 * last[1] + last[0]) / (dt * dt));
        EXPECT_LE(std::abs(it.acceleration()), a * (1 + 1e-6));
    }
    EXPECT_LE(hardest, a * (1 + 2 * lead / (samples * dt)) * (1 + 1e-6));
    EXPECT_GT(hardest, 1.2 * a);
}

TEST(LeadingCommand, HasSettledWhenAllItsSamplesAreTheSame) {
    LeadingCommand it;
    it.begin(0, 20);
    EXPECT_TRUE(it.settled());
    it.step(1, lead, dt);
    for (int i = 0; i < 18; ++i) {
        it.step(1, lead, dt);
        ASSERT_FALSE(it.settled()) << i;
    }
    it.step(1, lead, dt);
    EXPECT_TRUE(it.settled());
    EXPECT_EQ(it.mean(), 1);
    it.step(1, lead, dt);
    EXPECT_EQ(it.position(), 1) << "at rest it leads by nothing";
}

TEST(LeadingCommand, BeginsAndRestsWithoutVelocity) {
    LeadingCommand it;
    it.begin(0, 1);
    it.step(1, lead, dt);
    it.rest();
    EXPECT_EQ(it.velocity(), 0);
    EXPECT_EQ(it.acceleration(), 0);
    it.step(2, lead, dt);
    it.begin(-7, 5);
    EXPECT_EQ(it.position(), -7);
    EXPECT_EQ(it.velocity(), 0);
    it.step(-7, lead, dt);
    EXPECT_EQ(it.position(), -7);
}

}  // namespace
}  // namespace plumb
