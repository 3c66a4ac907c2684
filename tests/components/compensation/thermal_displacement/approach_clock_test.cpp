// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_finder.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

// Z comes down at 10 mm/s from 1.2345 mm above the start height at -17 mm.
struct Descent {
    double dt;
    ApproachClock clock;
    double height = -17 + 1.2345;

    void step(double velocity) {
        height += velocity * dt;
        clock.step(velocity, dt);
        clock.start_below(height, -17, velocity, dt);
    }
    void run(double seconds, double velocity) {
        for (int i = 0; i < std::lround(seconds / dt); ++i) step(velocity);
    }
};

TEST(ApproachClock, StartsBetweenSamplesForAnyPeriod) {
    for (const double dt : {0.0005, 0.001, 0.002}) {
        Descent descent{dt, {}};
        descent.run(0.2, -10);
        EXPECT_NEAR(descent.clock.time(), 0.2 - 0.12345, 1e-9) << dt;
        EXPECT_NEAR(descent.clock.lost_time(-10), 0, 1e-9) << dt;
    }
}

TEST(ApproachClock, RunsOnlyAfterTheHeightWasPassed) {
    Descent descent{0.001, {}};
    descent.run(0.1, -10);
    EXPECT_FALSE(descent.clock.running());
    EXPECT_EQ(descent.clock.time(), 0);
    EXPECT_EQ(descent.clock.lost_time(-10), 0);
}

TEST(ApproachClock, DoesNotStartWhenFirstSeenBelowTheHeight) {
    Descent descent{0.001, {}, -18};
    descent.run(0.1, -10);
    EXPECT_FALSE(descent.clock.running());
}

TEST(ApproachClock, StartsAgainWithEachApproach) {
    Descent descent{0.001, {}};
    descent.run(0.5, -10);
    descent.run(0.5, 10);
    descent.run(0.2, -10);
    EXPECT_NEAR(descent.clock.time(), 0.2 - 0.12345, 1e-9);
}

TEST(ApproachClock, StopForgetsTheHeightToo) {
    Descent descent{0.001, {}};
    descent.run(0.1, -10);
    descent.clock.stop();
    descent.height = -17.1;
    descent.step(-10);
    EXPECT_FALSE(descent.clock.running());
}

TEST(ApproachClock, AFeedHoldShowsAsLostTime) {
    Descent descent{0.001, {}};
    descent.run(0.2, -10);
    descent.run(0.05, 0);
    descent.run(0.1, -10);
    EXPECT_NEAR(descent.clock.lost_time(-10), 0.05, 1e-9);
}

TEST(ApproachClock, AnOverrideOnTheWayShowsAsLostTime) {
    Descent descent{0.001, {}};
    descent.run(0.2, -10);
    descent.run(0.1, -8);
    descent.run(0.1, -10);
    EXPECT_NEAR(descent.clock.lost_time(-10), 0.1 * 0.2, 1e-9);
}

}  // namespace
}  // namespace plumb
