// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_supervision.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double dt = 0.001, pulse = CycleClock::pulse_time;  // s

struct Clock : testing::Test {
    CycleClock it;

    void run(double seconds) {
        for (int i = 0; i < seconds / dt - 0.5; ++i) it.step(dt);
    }
};

TEST_F(Clock, ACycleIsFromOneLowerDeadPointToTheNext) {
    it.begin();
    run(0.3);
    it.arrive(false, false);
    EXPECT_EQ(it.time(), 0) << "the first way is no cycle";
    run(0.4);
    it.arrive(true, false);
    EXPECT_EQ(it.time(), 0);
    run(0.6);
    it.arrive(false, false);
    EXPECT_NEAR(it.time(), 1, 1e-9);
    run(0.25);
    it.arrive(true, false);
    run(0.25);
    it.arrive(false, false);
    EXPECT_NEAR(it.time(), 0.5, 1e-9);
}

TEST_F(Clock, ARestBetweenTwoMotionsIsNoCycle) {
    it.begin();
    for (const double seconds : {0.1, 0.5}) {
        run(seconds);
        it.arrive(false, false);
    }
    it.begin();
    run(7);
    it.arrive(false, false);
    EXPECT_NEAR(it.time(), 0.5, 1e-9) << "the last whole one";
    run(0.7);
    it.arrive(false, false);
    EXPECT_NEAR(it.time(), 0.7, 1e-9);
}

TEST_F(Clock, APulseLastsItsTimeAtItsDeadPointAlone) {
    it.begin();
    for (const bool upper : {false, true}) {
        it.arrive(upper, true);
        run(pulse - dt);
        EXPECT_TRUE(it.pulse(upper));
        EXPECT_FALSE(it.pulse(!upper));
        run(2 * dt);
        EXPECT_FALSE(it.pulse(upper));
    }
    it.arrive(false, false);
    EXPECT_FALSE(it.pulse(false)) << "a dead point without infeed";
}

}  // namespace
}  // namespace plumb
