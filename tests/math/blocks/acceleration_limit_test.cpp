// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/acceleration_limit.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace plumb {
namespace {

constexpr double dt = 0.001;

// An AccelerationLimit that is watched.
struct Watched {
    explicit Watched(const AccelerationLimit::Limits& its, double its_period = dt)
        : limits(its), period(its_period) {}

    double step(double target) {
        const double y = limit.step(target, limits, period), now = (y - last) / period;
        hardest = std::max(hardest, std::abs(now - speed) / period);
        fastest = std::max(fastest, std::abs(now));
        speed = now;
        last = y;
        return y;
    }

    AccelerationLimit::Limits limits;
    double period;
    AccelerationLimit limit;
    double last = 0, speed = 0, hardest = 0, fastest = 0;
};

TEST(AccelerationLimit, FollowsWithoutLagATargetThatObeysIt) {
    Watched watched({0.1, 10, 100});
    const double amplitude = 0.5, w = 2 * pi * 2;  // 79 mm/s2
    for (int i = 0; i < 2000; ++i) {
        const double target = amplitude * (1 - std::cos(w * i * dt));
        ASSERT_NEAR(watched.step(target), target, 1e-12) << i;
    }
}

TEST(AccelerationLimit, StepTakesTheTimeOfATrapezoidAndDoesNotOvershoot) {
    Watched watched({5, 5, 50});
    double y = 0;
    int periods = 0;
    for (; y < 2 && periods < 10000; ++periods) {
        y = watched.step(2);
        ASSERT_LE(y, 2);
    }
    EXPECT_NEAR(periods * dt, 2.0 / 5 + 5.0 / 50, 2 * dt);
    EXPECT_EQ(watched.step(2), 2);
    EXPECT_LE(watched.hardest, 50 * (1 + 1e-9));
    EXPECT_LE(watched.fastest, 5 * (1 + 1e-9));
}

TEST(AccelerationLimit, ApproachIsRelativeToATargetThatMoves) {
    Watched watched({0.1, 10, 1000});
    watched.step(1);
    double target = 1;
    for (int i = 0; i < 500; ++i) watched.step(target += 2 * dt);
    EXPECT_NEAR(target - watched.last, 1 - 0.5 * 0.1 - 1 * 0.002, 0.01);
}

// Drawn steps, drifts and returns, limits of every size.
TEST(AccelerationLimit, NoSequenceOfTargetsBreaksALimitOrAddsUp) {
    Random random(1);
    for (int run = 0; run < 300; ++run) {
        const double approach = std::pow(10, random.uniform(-2, 1)), rate = approach * random.uniform(1, 10);
        const double acceleration = std::pow(10, random.uniform(1, 4));
        Watched watched({approach, rate, acceleration});
        double largest = 0, target = 0, drift = 0;
        for (int i = 0; i < 3000; ++i) {
            if (random.uniform(0, 1) < 0.01) target = random.uniform(-1, 1);
            if (random.uniform(0, 1) < 0.01) drift = random.uniform(-2, 2);
            target = std::clamp(target + drift * dt, -1.0, 1.0);
            largest = std::max(largest, std::abs(target));
            const double stopping = rate * rate / (2 * acceleration) + rate * dt;
            ASSERT_LE(std::abs(watched.step(target)), largest + stopping) << run;
        }
        EXPECT_LE(watched.hardest, acceleration * (1 + 1e-6)) << run;
        EXPECT_LE(watched.fastest, rate * (1 + 1e-9)) << run;
        for (int i = 0; i < 1000000 && watched.step(target) != target; ++i) {
        }
        EXPECT_EQ(watched.last, target) << run;
    }
}

TEST(AccelerationLimit, StepToATargetAtRestNeverOvershoots) {
    Random random(2);
    for (int run = 0; run < 300; ++run) {
        const double rate = std::pow(10, random.uniform(-2, 2));
        const AccelerationLimit::Limits limits{rate, rate, std::pow(10, random.uniform(0, 5))};
        const double target = std::pow(10, random.uniform(-6, 1));
        AccelerationLimit limit;
        for (int i = 0; i < 100000 && limit.value() != target; ++i)
            ASSERT_LE(limit.step(target, limits, dt), target * (1 + 1e-12)) << run;
    }
}

TEST(AccelerationLimit, ReducedRateIsReachedByBraking) {
    Watched watched({10, 10, 100});
    for (int i = 0; i < 200; ++i) watched.step(1000);
    EXPECT_NEAR(watched.speed, 10, 1e-9);
    watched.limits.approach = watched.limits.rate = 1;
    for (int i = 0; i < 89; ++i) watched.step(1000);
    EXPECT_GT(watched.speed, 1);
    for (int i = 0; i < 3; ++i) watched.step(1000);
    EXPECT_NEAR(watched.speed, 1, 1e-9);
    EXPECT_LE(watched.hardest, 100 * (1 + 1e-6));
}

TEST(AccelerationLimit, HeldItStandsAndBeginsFromRest) {
    Watched watched({10, 10, 100});
    for (int i = 0; i < 50; ++i) watched.step(5);
    const double place = watched.last;
    watched.limit.hold();
    EXPECT_EQ(watched.limit.value(), place);
    const double next = watched.limit.step(5, watched.limits, dt);
    EXPECT_NEAR(next - place, 100 * dt * dt, 1e-12);
}

constexpr std::initializer_list<double> periods{0.00025, 0.001, 0.004};  // s

AccelerationLimit::Limits within(double bound, double rate, double acceleration) {
    return {rate, rate, acceleration, rate, rate, bound};
}

TEST(AccelerationLimit, BrakesBeforeItsBoundAndNoEarlierThanItMust) {
    for (const double period : periods)
        for (const double acceleration : {1000.0, 20000.0})
            for (const double bound : {20.0, 50.0, 79.9}) {
                SCOPED_TRACE(testing::Message() << period << " s, " << acceleration << ", " << bound);
                Watched watched(within(bound, 1000, acceleration), period);
                const double w = 2 * pi * 0.7;  // 80 mm, 176 mm/s, 774 mm/s2
                double target = 0;
                bool free = true;
                int followed = 0;
                for (int i = 1; i * period < 5; ++i) {
                    const double before = target;
                    target = 40 * (1 - std::cos(w * i * period));
                    const double y = watched.step(target), v = (target - before) / period;
                    ASSERT_LE(std::abs(y), bound);
                    // The speeds v, v - a dt, ... take at most this distance.
                    const double way =
                        v * v / (2 * acceleration) + v * period / 2 + acceleration * period * period / 8;
                    free &= way <= bound - before;
                    if (!free) continue;
                    ASSERT_EQ(y, target) << i;
                    ++followed;
                }
                EXPECT_GT(followed * period, 0.1);
                EXPECT_LE(watched.hardest, acceleration * (1 + 1e-6) + 1e-6);
            }
}

// Amplitude of exactly the bound, and a stroke that brakes with all of the acceleration.
TEST(AccelerationLimit, TargetThatItselfStopsAtTheBoundPassesBitForBit) {
    for (const double period : periods)
        for (const double bound : {1.0, 80.0, 1000.0 / 3}) {
            SCOPED_TRACE(testing::Message() << period << " s, " << bound);
            const double w = 2 * pi * 0.5, acceleration = bound * w * w;
            Watched watched(within(bound, bound * w, acceleration), period);
            for (int i = 0; i * period < 6; ++i) {
                const double target = bound * (1 - std::cos(w * i * period)) / 2;
                ASSERT_EQ(watched.step(target), target) << i;
            }
            const double little = 0.1;  // mm/s2: the rounding of the target is no small part of a change
            Watched hard(within(bound, 1e6, little), period);
            const double half = std::sqrt(bound / little);  // s, to the middle
            for (int i = 0; i * period < 3 * half; ++i) {
                const double t = i * period, left = std::max(2 * half - t, 0.0);
                const double target = t < half ? little * t * t / 2 : bound - little * left * left / 2;
                ASSERT_EQ(hard.step(target), target) << i;
            }
        }
}

TEST(AccelerationLimit, NoSequenceOfTargetsPassesTheBoundOrBreaksTheAccelerationThere) {
    Random random(3);
    for (int run = 0; run < 300; ++run) {
        const double period = std::pow(10, random.uniform(-4, -2.4));
        const double bound = std::pow(10, random.uniform(-2, 2)), rate = std::pow(10, random.uniform(-1, 3));
        const double acceleration = std::pow(10, random.uniform(-1, 5));
        Watched watched(within(bound, rate, acceleration), period);
        double target = 0, drift = 0;
        for (int i = 0; i < 3000; ++i) {
            if (random.uniform(0, 1) < 0.01) target = random.uniform(-3, 3) * bound;
            if (random.uniform(0, 1) < 0.02) drift = random.uniform(-1, 1) * rate;
            target += drift * period;
            ASSERT_LE(std::abs(watched.step(random.uniform(0, 1) < 0.5 ? target
                                                                       : std::clamp(target, -bound, bound))),
                      bound)
                << run;
        }
        EXPECT_LE(watched.hardest, acceleration * (1 + 1e-6) + 1e-15 * bound / period / period) << run;
    }
}

// A smaller bound that it accepts is one that it respects.
TEST(AccelerationLimit, StopsWithinEveryBoundThatItPermits) {
    Random random(4);
    int taken = 0, left = 0;
    for (int run = 0; run < 300; ++run) {
        const double acceleration = std::pow(10, random.uniform(1, 4));
        Watched watched(within(10, 50, acceleration));
        for (int i = 0; i < 2000; ++i) {
            const double smaller = random.uniform(0, 10);
            if (watched.limit.stops_within(smaller, acceleration, dt)) {
                watched.limits.bound = smaller;
                ++taken;
            } else {
                watched.limits.bound = std::max(watched.limits.bound, smaller);
                ++left;
            }
            for (int k = 0; k < 5; ++k)
                ASSERT_LE(std::abs(watched.step(random.uniform(-1, 1) < 0 ? -20 : 20)), watched.limits.bound);
        }
        EXPECT_LE(watched.hardest, acceleration * (1 + 1e-6)) << run;
    }
    EXPECT_GT(taken, 1000);
    EXPECT_GT(left, 1000);
}

}  // namespace
}  // namespace plumb
