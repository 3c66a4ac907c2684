// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/ramped_correction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace plumb {
namespace {

using Eigen::Vector3d;
using Wanted = RampedCorrection::Wanted;

constexpr double dt = 0.001, rate = 0.1, most = 1;

Wanted wanted(const Vector3d& offset, double limit = most) {
    return {offset, Vector3d::Zero(), limit};
}

TEST(RampedCorrection, MotionIsFollowedAtOnceAlsoWhileItRamps) {
    const auto f = [](double t) { return Vector3d(0.2 * std::sin(9 * t), 0.1 * t, -0.3 * std::cos(5 * t)); };
    RampedCorrection steady, ramped;
    steady.step(wanted(f(0)), wanted(Vector3d::Zero()), 1e3, dt);
    ramped.step(wanted(f(0)), wanted(Vector3d::Zero()), rate, dt);
    double rest = f(0).norm() - rate * dt;
    for (int n = 1; n < 4000; ++n) {
        steady.step(wanted(f(n * dt)), rate, dt);
        EXPECT_EQ(steady.offset(), f(n * dt));
        ramped.step(wanted(f(n * dt)), rate, dt);
        rest = std::max(0.0, rest - rate * dt);
        EXPECT_NEAR((ramped.offset() - f(n * dt)).norm(), rest, 1e-12);
    }
    EXPECT_FALSE(ramped.ramping());
}

TEST(RampedCorrection, ChangeArrivesStraightByTheRate) {
    RampedCorrection y;
    const Vector3d target(0.03, -0.04, 0.12);  // 0.13 long
    y.step(wanted(target), wanted(Vector3d::Zero()), rate, dt);
    for (int n = 1; n < 650; ++n) y.step(wanted(target), rate, dt);
    EXPECT_LT((y.offset() - target / 2).norm(), 1e-12);
    EXPECT_TRUE(y.ramping());
    for (int n = 0; n < 651; ++n) y.step(wanted(target), rate, dt);
    EXPECT_EQ(y.offset(), target);
    EXPECT_FALSE(y.ramping());
}

TEST(RampedCorrection, ChangeSlowerThanTheRateHasNoLag) {
    RampedCorrection y;
    for (int n = 1; n < 100; ++n) {
        const auto at = [](int k) { return wanted(Vector3d(0.9 * rate * dt * k, 0, 0)); };
        y.step(at(n), at(n - 1), rate, dt);
        EXPECT_EQ(y.offset(), at(n).offset);
        EXPECT_NEAR(y.velocity().x(), 0.9 * rate, 1e-9);
    }
}

// After any sequence of events.
TEST(RampedCorrection, OnlyMotionIsFasterThanTheRate) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-2, 2);
    std::uniform_int_distribution<int> event(0, 30);
    RampedCorrection y;
    Vector3d base = Vector3d::Zero();
    double limit = most, worst_step = 0, worst_excess = 0, travelled = 0;
    Vector3d motion = Vector3d::Zero();
    for (int n = 0; n < 100000; ++n) {
        const Vector3d moved = 1e-3 * (Vector3d(any(random), any(random), any(random)) - motion);
        motion += moved;
        const Wanted before = wanted(base + motion, limit);
        if (event(random) == 0) base = Vector3d(any(random), any(random), any(random));
        if (event(random) == 0) limit = std::abs(any(random));
        const Vector3d last = y.offset();
        y.step(wanted(base + motion, limit), before, rate, dt);
        const Vector3d step = y.offset() - last;
        worst_step = std::max(worst_step, step.norm() - moved.norm());
        for (int i = 0; i < 3; ++i)
            worst_excess =
                std::max(worst_excess, std::abs(y.offset()[i]) - std::max(limit, std::abs(last[i])));
        travelled += step.norm();
    }
    EXPECT_LE(worst_step, rate * dt * (1 + 1e-9));
    EXPECT_GT(worst_step, 0.9 * rate * dt);
    EXPECT_LE(worst_excess, 0);
    EXPECT_GT(travelled, 10);
}

TEST(RampedCorrection, VelocityAddsUpToTheWayBetweenTwoRests) {
    const auto f = [](double t) {
        const double s = std::clamp((t - 0.5) / 2, 0.0, 1.0);
        const double speed = t > 0.5 && t < 2.5 ? 0.5 * 30 * s * s * (1 - s) * (1 - s) : 0;
        return Wanted{Vector3d(0.4, 0.3 * s * s * s * (10 - 15 * s + 6 * s * s), 0),
                      Vector3d(0, 0.3 * speed, 0), most};
    };
    RampedCorrection y;
    Vector3d sum = Vector3d::Zero(), last = Vector3d::Zero();
    for (int n = 0; n < 6000; ++n) {
        y.step(f(n * dt), n == 0 ? wanted(Vector3d::Zero()) : f(n * dt), rate, dt);
        sum += (y.velocity() + last) / 2 * dt;
        last = y.velocity();
    }
    EXPECT_LT((sum - y.offset()).norm(), 1e-9);
    EXPECT_LT((y.offset() - Vector3d(0.4, 0.3, 0)).norm(), 1e-12);
}

TEST(RampedCorrection, MostBoundsItAndMovesItByTheRate) {
    RampedCorrection y;
    const auto run = [&](const Wanted& now, const Wanted& before, int periods) {
        for (int n = 0; n < periods; ++n) y.step(now, n == 0 ? before : now, rate, dt);
    };
    run(wanted({0.5, 0, 0}), wanted(Vector3d::Zero()), 6000);
    EXPECT_EQ(y.offset().x(), 0.5);
    EXPECT_FALSE(y.limited());
    run(wanted({0.5, 0, 0}, 0.2), wanted({0.5, 0, 0}), 1000);
    EXPECT_NEAR(y.offset().x(), 0.4, 1e-12);
    EXPECT_TRUE(y.limited());
    run(wanted({0.5, 0, 0}, 0.2), wanted({0.5, 0, 0}, 0.2), 2010);
    EXPECT_EQ(y.offset().x(), 0.2);
    EXPECT_EQ(y.velocity().x(), 0);
    // Motion takes it to the bound while it is on its way from elsewhere.
    RampedCorrection other;
    other.step({{0.15, 0, 0}, {0, 0, 0}, 0.2}, {{0.15, 0, 0}, {0, 0, 0}, 0.2}, rate, dt);
    other.step({{0, 0, 0}, {0, 0, 0}, 0.2}, {{0.15, 0, 0}, {0, 0, 0}, 0.2}, rate, dt);
    EXPECT_GT(other.offset().x(), 0.1);
    other.step({{0.19, 0, 0}, {50, 0, 0}, 0.2}, rate, dt);
    EXPECT_EQ(other.offset().x(), 0.2);
    EXPECT_EQ(other.velocity().x(), 0);
    EXPECT_TRUE(other.limited());
    // Out of the bound by motion, without lag.
    y.step(wanted({0.19, 0, 0}, 0.2), rate, dt);
    EXPECT_EQ(y.offset().x(), 0.19);
    EXPECT_FALSE(y.limited());
}

}  // namespace
}  // namespace plumb
