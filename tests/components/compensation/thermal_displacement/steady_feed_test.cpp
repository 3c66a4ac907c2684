// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_displacement/contact_finder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s
constexpr double forever = std::numeric_limits<double>::infinity();

// Changes its speed by `acceleration`, in mm/s², and stays there for a while.
struct Feed {
    SteadyFeed steady{};
    double velocity = 0;  // mm/s

    void go(double target, double seconds, double acceleration = 500) {
        const double end = seconds + std::abs(target - velocity) / acceleration;
        for (int i = 0; i < std::lround(end / dt); ++i) {
            const double most = acceleration * dt;
            velocity += std::fmax(-most, std::fmin(most, target - velocity));
            steady.step(velocity, 0.02, dt);
        }
    }
};

TEST(SteadyFeed, AnApproachWithoutDisturbanceIsSteadyFromItsStart) {
    for (const double acceleration : {200.0, 500.0, 1e6}) {
        Feed feed;
        feed.steady.begin();
        feed.go(-25, 0.01, acceleration);
        EXPECT_EQ(feed.steady.time(), forever);
        feed.go(-25, 1);
        EXPECT_EQ(feed.steady.time(), forever);
    }
}

TEST(SteadyFeed, CountsFromTheEndOfAHoldOrAChangeOfFeed) {
    for (const double held_at : {0.0, -1.0, -1.9, -2.1, -4.0}) {
        Feed feed;
        feed.steady.begin();
        feed.go(-2, 1);
        feed.go(held_at, 3);
        if (held_at != 0) {
            EXPECT_NEAR(feed.steady.time(), 3, 2 * dt) << held_at;
        }
        feed.go(-2, 0.1);
        EXPECT_NEAR(feed.steady.time(), 0.1, 2 * dt) << held_at;
    }
}

TEST(SteadyFeed, IgnoresWhatIsWithinTheTolerance) {
    Feed feed;
    feed.steady.begin();
    feed.go(-2, 1);
    feed.go(-2.03, 0.1);
    feed.go(-1.97, 0.1);
    EXPECT_EQ(feed.steady.time(), forever);
}

TEST(SteadyFeed, TheNextApproachBeginsWithoutTheDisturbance) {
    Feed feed;
    feed.steady.begin();
    feed.go(-2, 1);
    feed.go(0, 1);
    feed.steady.begin();
    feed.go(-2, 0.1);
    EXPECT_EQ(feed.steady.time(), forever);
}

}  // namespace
}  // namespace plumb
