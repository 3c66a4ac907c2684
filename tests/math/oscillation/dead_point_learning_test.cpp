// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/dead_point_learning.hpp"
#include "components/math/oscillation/dead_point_meter.hpp"

#include "components/math/blocks/pi.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3;
constexpr DeadPointLearning::Stroke stroke{10, 40, 100, 1000, 0};

DeadPointLearning::Settings usual() {
    return {0.3, 0.7, 1, 2 * um, 5 * um};
}

// An axis whose dead point lies `overshoot` (at full speed, grows with its square) and `constant` beyond
// the commanded end.
struct Axis {
    double overshoot = 0, constant = 0;

    // One cycle; returns the farthest error beyond a dead point.
    double cycle(DeadPointLearning& learning) const {
        const double k = learning.speed_factor(), acceleration = 600 * k * k;
        double farthest = -1e9;
        for (const bool upper : {false, true}) {
            const double used = learning.offset(upper, acceleration, 100 * k);
            const double error = used + overshoot * k * k + constant;
            farthest = std::max(farthest, error);
            learning.measured(upper, error, used, acceleration);
        }
        return farthest;
    }
};

TEST(DeadPointLearning, LearnsWithoutEverGoingBeyond) {
    for (const double overshoot : {-0.5, -0.2, -0.01, 0.0, 0.05, 0.2, 0.6})
        for (const double constant : {-5 * um, 0.0, 2 * um}) {
            const Axis axis{overshoot, constant};
            DeadPointLearning learning;
            learning.select(stroke, usual());
            EXPECT_EQ(learning.speed_factor(), DeadPointLearning::slow);
            double farthest = -1e9;
            int cycles = 0;
            for (; learning.speed_factor() < 1 && cycles < 50; ++cycles)
                farthest = std::max(farthest, axis.cycle(learning));
            EXPECT_LT(cycles, 30) << overshoot;
            for (int i = 0; i < 8; ++i) farthest = std::max(farthest, axis.cycle(learning));
            EXPECT_LE(farthest, 5 * um) << overshoot;
            EXPECT_LE(std::abs(axis.cycle(learning)), 2 * um) << overshoot;
            EXPECT_TRUE(learning.learned());
            EXPECT_EQ(learning.beyond(), 0);
        }
}

TEST(DeadPointLearning, RemembersTheStrokesThatItLearned) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    const double offset = learning.offset(true, 600, 100);
    EXPECT_NEAR(offset, 0.2, um);
    learning.select({10, 60, 100, 1000, 0}, usual());
    EXPECT_EQ(learning.speed_factor(), DeadPointLearning::slow);
    EXPECT_NEAR(learning.offset(true, 600, 100), -0.3, 1e-12);
    learning.select(stroke, usual());
    EXPECT_EQ(learning.speed_factor(), 1);
    EXPECT_EQ(learning.offset(true, 600, 100), offset);
    learning.forget();
    EXPECT_EQ(learning.speed_factor(), DeadPointLearning::slow);
}

TEST(DeadPointLearning, WhatIsRestoredIsInForceWithItsFirstCorrection) {
    const Axis axis{-0.2};
    DeadPointLearning first, next;
    first.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(first);
    ASSERT_EQ(first.size(), 1);
    EXPECT_TRUE(next.restore(first[0]));
    EXPECT_FALSE(next.restore(first[0])) << "twice";
    next.select(stroke, usual());
    EXPECT_EQ(next.speed_factor(), 1);
    EXPECT_NEAR(axis.cycle(next), 0, um);
    const Axis rougher{-0.23};
    for (int i = 0; i < 10; ++i) rougher.cycle(next);
    EXPECT_NEAR(next.drift(), 0.03, um);
    EXPECT_NEAR(next[0].offset[1], 0.23, um);
    EXPECT_NEAR(next[0].first_offset[1], 0.2, um);
}

TEST(DeadPointLearning, AnImpossibleRecordIsRefused) {
    const DeadPointLearning::Learned good{stroke, {0.1, 0.1}, {0.1, 0.1}, 600};
    DeadPointLearning learning;
    for (int i = 0; i < 4; ++i) {
        DeadPointLearning::Learned bad = good;
        (i == 0 ? bad.offset[0] : i == 1 ? bad.reversal : i == 2 ? bad.stroke.speed : bad.stroke.upper) = NAN;
        EXPECT_FALSE(learning.restore(bad)) << i;
    }
    EXPECT_TRUE(learning.restore(good));
}

TEST(DeadPointLearning, TheNinthStrokeTakesThePlaceOfTheFirst) {
    const Axis axis{-0.1};
    DeadPointLearning learning;
    for (int i = 0; i <= DeadPointLearning::most_strokes; ++i) {
        learning.select({10.0 - i, 40, 100, 1000, 0}, usual());
        for (int k = 0; k < 20; ++k) axis.cycle(learning);
        ASSERT_TRUE(learning.learned()) << i;
    }
    EXPECT_EQ(learning.size(), DeadPointLearning::most_strokes);
    EXPECT_EQ(learning[0].stroke.lower, 10.0 - DeadPointLearning::most_strokes);
    EXPECT_EQ(learning[1].stroke.lower, 9);
}

TEST(DeadPointLearning, AnEndBeyondComesBackWithTheAcceleration) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    EXPECT_NEAR(learning.offset(true, 300, 100), 0.1, um);
    EXPECT_NEAR(learning.offset(true, 6000, 100), 0.2, um) << "never farther than learned";
}

TEST(DeadPointLearning, AboveFullSpeedAnAxisThatOvershootsEndsFartherInside) {
    const Axis axis{0.1};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    EXPECT_NEAR(learning.offset(true, 600, 100), -0.1, um);
    EXPECT_NEAR(learning.offset(true, 600, 150), -0.225, 2.25 * um);
    EXPECT_NEAR(learning.offset(true, 600, 50), -0.1, um);
}

TEST(DeadPointLearning, StaysWithinTheLargestCorrection) {
    const Axis axis{-3};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 60; ++i) axis.cycle(learning);
    EXPECT_EQ(learning.offset(true, 600, 100), 1);
    EXPECT_FALSE(learning.learned());
    EXPECT_GE(learning.cycles(), 20);
}

TEST(DeadPointLearning, GoesBackAtOnceFromFarBeyond) {
    const Axis axis{-0.2};
    DeadPointLearning learning;
    learning.select(stroke, usual());
    for (int i = 0; i < 30; ++i) axis.cycle(learning);
    const double used = learning.offset(true, 600, 100);
    learning.measured(true, 0.05, used, 600);
    EXPECT_NEAR(learning.offset(true, 600, 100), used - 0.05, 1e-12);
    EXPECT_EQ(learning.beyond(), 1);
}

TEST(DeadPointMeter, FindsTheVertexBetweenSamples) {
    for (const bool upward : {true, false})
        for (double shift = 0; shift < 1; shift += 0.1) {
            DeadPointMeter meter;
            meter.begin(upward);
            const double sign = upward ? 1 : -1;
            for (int i = 0; i < 100; ++i) {
                const double t = (i - 50 + shift) * 0.001;
                meter.step(sign * (7 - 800 * t * t / 2));
                if (i < 50) {
                    EXPECT_FALSE(meter.found()) << i;
                }
            }
            ASSERT_TRUE(meter.found());
            EXPECT_NEAR(meter.position(), sign * 7, 1e-9);
        }
}

}  // namespace
}  // namespace plumb
