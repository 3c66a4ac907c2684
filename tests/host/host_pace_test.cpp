// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/pace.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace plumb::host {
namespace {

using namespace std::chrono_literals;
using Instant = Pace::Clock::time_point;

constexpr Nanoseconds rounding = 1;

Nanoseconds in_nanoseconds(std::chrono::nanoseconds span) {
    return span.count();
}

TEST(HostPace, TimePassesByTheFactor) {
    for (const double speed : {0.1, 1.0, 10.0, 1000.0}) {
        const Pace pace(speed);
        const Instant now = Pace::Clock::now();
        const Nanoseconds begin = pace.instant(now);
        EXPECT_NEAR(pace.instant(now + 50ms) - begin, in_nanoseconds(50ms) * speed, rounding);
        EXPECT_NEAR(pace.instant(now + 24h) - begin, in_nanoseconds(24h) * speed, 1e-12 * begin + 1000);
    }
}

TEST(HostPace, AnInstantIsDueWhenItsClockTimeHasCome) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> speeds(0.1, 100.0);
    std::uniform_int_distribution<int> spans(0, 1'000'000'000);
    for (int i = 0; i < 1000; ++i) {
        const Pace pace(speeds(random));
        const Instant now = Pace::Clock::now();
        const Nanoseconds instant = pace.instant(now) + spans(random);
        const Instant its_clock_time = now + pace.until(instant, now);
        EXPECT_GE(pace.instant(its_clock_time), instant - rounding);
        EXPECT_LT(pace.instant(its_clock_time - 2ns), instant);
    }
}

TEST(HostPace, ArrearsAreMadeUpToTheLimit) {
    Pace pace(10);
    const Instant now = Pace::Clock::now();
    const Nanoseconds reached = pace.instant(now);
    EXPECT_EQ(pace.due(now + 99ms, reached), pace.instant(now + 99ms));
    EXPECT_NEAR(pace.due(now + 99ms, reached) - reached, in_nanoseconds(990ms), rounding);
    EXPECT_EQ(pace.given_up(), 0ns);
}

TEST(HostPace, ArrearsBeyondTheLimitAreGivenUp) {
    Pace pace(10);
    const Instant now = Pace::Clock::now();
    const Nanoseconds reached = pace.instant(now);
    const Nanoseconds due = pace.due(now + 1s, reached);
    EXPECT_NEAR(due - reached, in_nanoseconds(1s), 10 * rounding) << "100 ms, ten times as fast";
    EXPECT_NEAR(in_nanoseconds(pace.given_up()), in_nanoseconds(900ms), rounding);
    // From there on, time passes as before.
    EXPECT_NEAR(pace.due(now + 1050ms, due) - due, in_nanoseconds(500ms), 10 * rounding);
    EXPECT_NEAR(in_nanoseconds(pace.until(due + in_nanoseconds(10ms), now + 1s)), in_nanoseconds(1ms),
                rounding);
    pace.due(now + 3s, pace.instant(now + 1050ms));
    EXPECT_NEAR(in_nanoseconds(pace.given_up()), in_nanoseconds(900ms + 1850ms), 3 * rounding);
}

TEST(HostPace, FreeTimeWaitsForNoClock) {
    Pace pace(std::numeric_limits<double>::infinity());
    const Instant now = Pace::Clock::now();
    EXPECT_TRUE(pace.free());
    EXPECT_EQ(pace.instant(now), never);
    EXPECT_EQ(pace.due(now + 1h, 0), never);
    EXPECT_EQ(pace.given_up(), 0ns);
    EXPECT_LE(pace.until(one_second, now), 0ns);
    EXPECT_FALSE(Pace(1000).free());
}

}  // namespace
}  // namespace plumb::host
