// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/trapezoidal_move.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

// Moves until it arrives, and checks the invariants in each period. Returns the time that it took.
double move(TrapezoidalMove& move, double target, double speed, double acceleration, double dt) {
    int periods = 0;
    while (!move.arrived(target) && periods < 1000000) {
        const double position = move.position(), velocity = move.velocity();
        move.step(target, speed, acceleration, dt);
        EXPECT_LE(std::abs(move.velocity()), speed * (1 + 1e-12));
        EXPECT_LE(std::abs(move.velocity() - velocity), acceleration * dt * (1 + 1e-9));
        EXPECT_NEAR(move.position() - position, move.velocity() * dt, 1e-3 * acceleration * dt * dt + 1e-12);
        ++periods;
    }
    return periods * dt;
}

TEST(TrapezoidalMove, TakesTheTimeOfATrapezoid) {
    TrapezoidalMove z;
    EXPECT_NEAR(move(z, 100, 50, 200, 0.001), 100 / 50. + 50 / 200., 0.003);
    EXPECT_NEAR(move(z, 0, 50, 200, 0.001), 100 / 50. + 50 / 200., 0.003);
}

TEST(TrapezoidalMove, TakesTheTimeOfATriangleWhenItIsShort) {
    TrapezoidalMove z;
    EXPECT_NEAR(move(z, 4, 50, 200, 0.001), 2 * std::sqrt(4 / 200.), 0.003);
}

TEST(TrapezoidalMove, ArrivesExactlyWithoutPassingItsTarget) {
    for (const double dt : {0.0001, 0.001, 0.01})
        for (const double target : {1.0, 0.001, 123.456, -7.89}) {
            TrapezoidalMove z;
            double farthest = 0;
            for (int i = 0; i < 1000000 && !z.arrived(target); ++i) {
                z.step(target, 20, 100, dt);
                farthest = std::max(farthest, z.position() / target);
            }
            EXPECT_EQ(z.position(), target);
            EXPECT_LE(farthest, 1 + 1e-6);
            z.step(target, 20, 100, dt);
            EXPECT_EQ(z.velocity(), 0);
        }
}

TEST(TrapezoidalMove, SpeedZeroHoldsItAndAnotherSpeedSendsItOn) {
    TrapezoidalMove z;
    for (int i = 0; i < 1000; ++i) z.step(100, 10, 100, 0.001);
    EXPECT_DOUBLE_EQ(z.velocity(), 10);
    for (int i = 0; i < 101; ++i) z.step(100, 0, 100, 0.001);
    EXPECT_EQ(z.velocity(), 0);
    const double held = z.position();
    for (int i = 0; i < 1000; ++i) z.step(100, 0, 100, 0.001);
    EXPECT_EQ(z.position(), held);
    move(z, 100, 10, 100, 0.001);
    EXPECT_EQ(z.position(), 100);
}

TEST(TrapezoidalMove, TurnsWithinItsAccelerationWhenTheTargetMovesBehindIt) {
    TrapezoidalMove z;
    for (int i = 0; i < 1000; ++i) z.step(100, 10, 100, 0.001);
    const double seen = z.position();
    move(z, 0, 10, 100, 0.001);
    EXPECT_EQ(z.position(), 0);
    EXPECT_GT(seen, 9);
}

}  // namespace
}  // namespace plumb
