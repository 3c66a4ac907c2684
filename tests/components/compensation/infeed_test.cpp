// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/infeed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double dt = 0.001;  // s

struct InfeedAlone : testing::Test {
    Infeed it;
    Infeed::Settings settings;
    Infeed::Now now;
    double follows = 1;  // part of the offset that the stage applies

    InfeedAlone() {
        settings.amount = -0.03;
        settings.total = 0.1;
        settings.clear = Infeed::upper;
        settings.most_amount = 0.05;
        settings.most = 1;
        settings.rate = 1;
        settings.acceleration = 50;
        settings.lowest = -10;
        settings.highest = 10;
        settings.tolerance = 0.001;
        settings.clearance = 0.02;
        settings.in_range = true;
        now.on = true;
        run(0.01);
        start();
    }

    void run(double seconds) {
        for (int i = 0; i < seconds / dt - 0.5; ++i) {
            now.applied = follows * it.value();
            it.step(now, settings, dt);
            now.starts = now.arrived = now.returns = now.aborts = false;
        }
    }
    void start() {
        now.starts = now.strokes = now.permitted = true;
        run(0.5);
    }
    // A stroke to this dead point, and the wait there.
    void stroke(bool upper) {
        now.runs = true;
        now.upward = upper;
        now.stands = false;
        run(0.1);
        now.runs = false;
        now.arrived = now.stands = true;
        run(0.2);
    }
    double deep() const { return std::abs(it.value()); }
};

TEST_F(InfeedAlone, TheLastAmountIsTheRestOfTheTotal) {
    for (const double expected : {0.03, 0.06, 0.09, 0.1, 0.1}) {
        EXPECT_EQ(it.done(), deep() == 0.1);
        stroke(false);
        stroke(true);
        EXPECT_NEAR(it.value(), -expected, 1e-12);
        EXPECT_FALSE(it.waits());
    }
}

TEST_F(InfeedAlone, WithoutAnInfeedNothingWaitsForTheAxisOrEndsTheStrokes) {
    settings.amount = 0;
    run(0.01);
    now.measured = 5;  // it follows a contour
    now.starts = true;
    run(0.002);
    EXPECT_FALSE(it.waits());
    stroke(true);
    EXPECT_FALSE(it.waits());
    now.aborts = now.ends = true;
    run(0.002);
    EXPECT_FALSE(it.done());
}

TEST_F(InfeedAlone, TheStrokeWaitsForTheMeasuredAxis) {
    now.measured = 0.0011;
    stroke(true);
    EXPECT_TRUE(it.waits());
    EXPECT_FALSE(it.late());
    run(0.6);
    EXPECT_TRUE(it.late());
    now.measured = std::numeric_limits<double>::quiet_NaN();
    run(0.1);
    EXPECT_TRUE(it.waits());
    now.measured = 0.0009;
    run(0.002);
    EXPECT_FALSE(it.waits());
    EXPECT_FALSE(it.late());
}

TEST_F(InfeedAlone, ASoftLimitIsKeptWithTheTaperOfTheStage) {
    now.position = now.measured = -9.85;
    settings.taper = 3;
    EXPECT_FALSE(settings.possible(now.position)) << "0.1 needs 0.3";
    EXPECT_TRUE(settings.possible(-9.7));
    stroke(true);
    stroke(true);
    EXPECT_NEAR(it.value(), -0.05, 1e-12);
    EXPECT_TRUE(it.cut());
    EXPECT_TRUE(it.done());
}

TEST_F(InfeedAlone, AnotherSignFeedsNothing) {
    stroke(true);
    settings.amount = 0.03;
    stroke(true);
    EXPECT_NEAR(it.value(), -0.03, 1e-12);
    now.starts = true;
    run(0.5);
    EXPECT_EQ(deep(), 0) << "a start begins at 0";
    stroke(true);
    EXPECT_NEAR(it.value(), 0.03, 1e-12);
}

TEST_F(InfeedAlone, BadSettingsLeaveTheLastGoodOnes) {
    stroke(true);
    settings.in_range = false;
    settings.amount = -1;
    settings.total = 5;
    EXPECT_FALSE(settings.possible(0));
    stroke(true);
    EXPECT_NEAR(it.value(), -0.06, 1e-12);
}

TEST_F(InfeedAlone, WhatTheStageDoesNotApplyIsGivenUp) {
    stroke(true);
    follows = 0.5;
    run(0.01);
    follows = 1;
    run(0.5);
    EXPECT_LT(deep(), 0.016);
}

TEST_F(InfeedAlone, MachineOffKeepsItUntilAStartOrAnOrder) {
    stroke(true);
    stroke(true);
    now.on = now.strokes = false;
    run(0.1);
    now.on = true;
    run(1);
    EXPECT_NEAR(deep(), 0.06, 1e-12);
    start();
    EXPECT_NEAR(deep(), 0.04, 1e-12);
    now.on = now.strokes = false;
    run(0.1);
    now.on = now.returns = true;
    run(1);
    EXPECT_EQ(deep(), 0);
}

TEST_F(InfeedAlone, AnAbortEndsItForThisStart) {
    stroke(true);
    now.aborts = true;
    run(0.5);
    EXPECT_EQ(deep(), 0);
    stroke(true);
    EXPECT_EQ(deep(), 0) << "also where the strokes go on for a moment";
    EXPECT_TRUE(it.done());
}

}  // namespace
}  // namespace plumb
