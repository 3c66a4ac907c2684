// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/chopping/stroke_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumb {
namespace {

using State = StrokeMotion::State;
using Stop = StrokeMotion::Stop;

constexpr double dt = 0.001;  // s

// Strokes from 10 to 40 below point R, 50.
struct Motion : testing::Test {
    StrokeMotion it;
    StrokeMotion::Settings settings;
    StrokeMotion::Orders now;
    double hardest = 0;  // mu/s2
    std::vector<double> places = std::vector<double>(3, 50.0);

    Motion() {
        settings.lower = 10;
        settings.upper = 40;
        settings.speed = 100;
        settings.acceleration = 1000;
        settings.largest_speed = 500;
        settings.lowest = -1000;
        settings.highest = 1000;
        settings.end_position = 50;
    }

    void start() { it.start(settings, places.back(), {}); }
    void run(double seconds) {
        for (int i = 0; i < seconds / dt; ++i) {
            it.step(now, settings, dt, 64, [](bool, double, double, double) { return 0.0; });
            now.returns = false;
            places.push_back(it.moves() ? it.leading().position() : it.leading().mean());
            const std::size_t n = places.size();
            hardest =
                std::max(hardest, std::abs(places[n - 1] - 2 * places[n - 2] + places[n - 3]) / (dt * dt));
        }
    }
    double place() const { return it.leading().mean(); }
};

TEST_F(Motion, StrokesUntilItIsStoppedAndRestsAtTheEnd) {
    EXPECT_EQ(it.state(), State::rest);
    start();
    run(2);
    EXPECT_EQ(it.state(), State::stroking);
    now.runs = false;
    run(dt);
    EXPECT_EQ(it.state(), State::stopping);
    run(3);
    EXPECT_EQ(it.state(), State::rest);
    EXPECT_EQ(place(), 50);
    EXPECT_LE(hardest, 1010);
}

TEST_F(Motion, AStopIsNotTakenBack) {
    start();
    run(2);
    now.runs = false;
    run(0.01);
    now.runs = true;
    run(3);
    EXPECT_EQ(it.state(), State::rest);
    EXPECT_EQ(place(), 50);
}

TEST_F(Motion, ALostPermissionReturnsItWhateverComesLater) {
    now.usual = Stop::dead_point;
    start();
    run(2);
    now.permitted = false;
    run(dt);
    EXPECT_EQ(it.state(), State::returning);
    now.permitted = true;
    now.hold = Stop::at_once;
    now.runs = false;
    run(4);
    EXPECT_EQ(it.state(), State::rest);
    EXPECT_EQ(place(), 50);
}

TEST_F(Motion, AnOrderToReturnPassesTheHoldThatIsThereAndALaterOneStopsIt) {
    start();
    run(2);
    now.hold = Stop::at_once;
    run(1);
    EXPECT_TRUE(it.oscillation().held());
    now.returns = true;
    run(0.1);
    EXPECT_EQ(it.state(), State::returning);
    EXPECT_FALSE(it.oscillation().held());
    now.hold = Stop::none;
    run(dt);
    now.hold = Stop::at_once;
    run(3);
    EXPECT_TRUE(it.oscillation().held());
    now.hold = Stop::none;
    run(3);
    EXPECT_EQ(it.state(), State::rest);
    EXPECT_EQ(place(), 50);
}

TEST_F(Motion, AHoldThatComesRightAfterAnOrderWithoutOneStopsIt) {
    start();
    run(2);
    now.returns = true;
    run(dt);
    now.hold = Stop::at_once;
    run(3);
    EXPECT_TRUE(it.oscillation().held());
}

TEST_F(Motion, AFailureStopsEachMotionAtOnce) {
    for (const bool returns : {false, true}) {
        start();
        run(1.5);
        now.returns = returns;
        run(0.01);
        it.fail();
        EXPECT_EQ(it.state(), State::stopping);
        run(0.5);
        EXPECT_EQ(it.state(), State::rest);
        EXPECT_NE(place(), 50);
    }
    EXPECT_LE(hardest, 1010);
}

TEST_F(Motion, ReturnsFromRestAnywhere) {
    places.assign(3, 20.0);
    it.return_to_end(settings, 20, {});
    EXPECT_EQ(it.state(), State::returning);
    run(2);
    EXPECT_EQ(it.state(), State::rest);
    EXPECT_EQ(place(), 50);
}

TEST_F(Motion, FrozenItRestsInThatPeriod) {
    start();
    run(1.234);
    it.freeze(22);
    EXPECT_EQ(it.state(), State::rest);
    const double before = place();
    run(0.1);
    EXPECT_EQ(place(), before);
    EXPECT_EQ(it.leading().velocity(), 0);
}

TEST_F(Motion, TheCommandOfAStartKeepsItsLeadAndItsJerkTime) {
    it.start(settings, 50, {0.002, 0.02, 20});
    settings.acceleration = 800;
    run(3);
    EXPECT_EQ(it.command().lead, 0.002);
    EXPECT_EQ(it.command().samples, 20u);
    EXPECT_LE(hardest, 1000 * (1 + 2 * 0.002 / 0.02) * 1.01);
}

}  // namespace
}  // namespace plumb
