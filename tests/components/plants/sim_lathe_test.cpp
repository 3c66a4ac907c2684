// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace plumb {
namespace {

struct SimLathe : testing::Test {
    SimLathe() {
        bench.command("loadrt sim_lathe names=lathe");
        bench.command("addf lathe.update servo-thread");
        set("gauge-time", 0.001);
    }

    void set(const std::string& pin, double value) { bench.set("lathe." + pin, value); }
    double get(const std::string& pin) { return bench.get("lathe." + pin); }

    // A lathe with no error but the height of its tool.
    void make_ideal() {
        for (const char* pin : {"x-scale", "x-backlash", "y-scale", "y-backlash", "x-growth", "spindle-lift",
                                "cutting-force", "built-up-edge", "wear", "laser-noise", "linearity",
                                "coolant-film", "work-warmth", "micrometer-noise"})
            set(pin, 0);
    }
    void go(double x, double y, double z) {
        set("x-position", x);
        set("y-position", y);
        set("z-position", z);
        bench.run(0.002);
    }
    // Plunges at Z, and leaves the work again.
    double land(double x, double y, double z) {
        go(50, y, z);
        go(x, y, z);
        const double diameter = get("truth-diameter");
        go(50, y, z);
        return diameter;
    }
    double measured() {
        set("measure", 1);
        bench.run(0.005);
        const double diameter = get("diameter");
        EXPECT_EQ(get("value-ready"), 1);
        set("measure", 0);
        bench.run(0.002);
        EXPECT_EQ(get("value-ready"), 0);
        return diameter;
    }

    Bench bench;
};

TEST_F(SimLathe, CutsNothingWhileTheWorkStands) {
    make_ideal();
    set("spindle-speed", 0);
    EXPECT_EQ(land(4, 0, 20), 12);
    set("spindle-speed", -500);
    EXPECT_NEAR(land(4, 0, 20), 2 * std::hypot(4, 0.1), 1e-9);
}

TEST_F(SimLathe, LeavesTheRadiusOfItsTip) {
    make_ideal();
    set("height-error", 0.1);
    EXPECT_NEAR(land(5, 0, 50), 2 * std::hypot(5, 0.1), 1e-12);
    EXPECT_NEAR(land(4, 0.2, 60), 2 * std::hypot(4, 0.3), 1e-12);
    set("axes-angle", 80);
    EXPECT_NEAR(land(4, 0.2, 70),
                2 * std::hypot(4 + 0.2 * std::cos(80 * M_PI / 180), 0.1 + 0.2 * std::sin(80 * M_PI / 180)),
                1e-12);
    EXPECT_NEAR(measured(), get("truth-diameter"), 1e-12);
}

TEST_F(SimLathe, StockKeepsItsState) {
    make_ideal();
    EXPECT_NEAR(land(5, 0, 50), 2 * std::hypot(5, 0.1), 1e-12);
    EXPECT_EQ(get("truth-cuts"), 1);
    const double first = get("truth-diameter");
    EXPECT_EQ(land(5.1, 0, 50), first) << "an air cut";
    EXPECT_EQ(get("truth-cuts"), 1);
    EXPECT_LT(land(4.9, 0, 50), first);
    set("gauge-z", 55);
    bench.run(0.002);
    EXPECT_EQ(get("truth-diameter"), 12) << "no cut there";
    set("new-stock", 1);
    set("gauge-z", 50);
    bench.run(0.002);
    EXPECT_EQ(get("truth-diameter"), 12);
}

TEST_F(SimLathe, OffCentreAToolLeavesANib) {
    make_ideal();
    set("height-error", 0.03);
    go(50, 0, 20);
    for (double x = 1; x > -1; x -= 0.01) go(x, 0, 20);
    EXPECT_NEAR(get("truth-diameter"), 0.06, 0.001);
}

TEST_F(SimLathe, ASlowMoveTurnsAllOnItsWay) {
    make_ideal();
    go(50, 0, 50);
    go(5, 0, 50);
    for (double z = 50; z > 45; z -= 0.4) go(5, 0, z);
    set("gauge-z", 47.23);
    bench.run(0.002);
    EXPECT_NEAR(get("truth-diameter"), 2 * std::hypot(5, 0.1), 1e-12);
}

TEST_F(SimLathe, WorkBendsMoreFurtherOut) {
    make_ideal();
    set("cutting-force", 20);
    land(5, 0, 20);
    const double near = get("truth-bend");
    EXPECT_NEAR(get("truth-effective-height"), 0.1 - 0.9 * near, 1e-12);
    land(5, 0, 90);
    EXPECT_GT(get("truth-bend"), 2 * near);
    set("guide-bush", 1);
    land(5, 0, 40);
    EXPECT_LT(get("truth-bend"), near);
}

TEST_F(SimLathe, AnotherToolBendsTheWorkOfThisOne) {
    make_ideal();
    const double r = std::hypot(5, 0.1), near = 20, far = 60;
    const double bend =
        100 * (1 / 50000.0 + near * near * (3 * far - near) / (6 * 206e3 * M_PI * std::pow(r, 4) / 4));
    set("other-force-x", -100);
    set("other-force-y", 100);
    set("other-z", far);
    EXPECT_NEAR(land(5, 0, near), 2 * std::hypot(5 + bend, 0.1 - bend), 1e-12);
    EXPECT_NEAR(get("truth-effective-height"), 0.1 - bend, 1e-12);
    set("x-reversed", 1);
    go(-50, 0, near + 1);
    set("z-position", near - 1);
    set("other-z", near - 1);
    go(-5, 0, near - 1);
    EXPECT_LT(get("truth-diameter"), 2 * r) << "it pushes the work towards this tool";
    for (const double inverted : {0, 1}) {
        set("inverted", inverted);
        set("other-force-x", 0);
        set("other-force-y", 0);
        set("cutting-force", 20);
        set("x-position", -5);
        set("z-position", near + 4 + 2 * inverted);
        bench.run(0.001);
        EXPECT_GT(get("force-x"), 1) << "away from the tool, which is on the side of -X";
        EXPECT_NEAR(get("force-y"), (inverted != 0 ? -9 : 9) / 4.0 * get("force-x"), 1e-9);
        EXPECT_NEAR(2 * get("cut-radius"), get("truth-diameter"), 1e-12);
        EXPECT_EQ(get("cut-z"), near + 4 + 2 * inverted);
    }
    go(-50, 0, near);
    EXPECT_EQ(get("force-x"), 0);
    EXPECT_EQ(get("cut-radius"), 0);
}

TEST_F(SimLathe, OfTwoToolsTheDeeperOneMakesTheDiameter) {
    make_ideal();
    set("other-z", 45);
    set("other-radius", 4);
    bench.run(0.002);
    for (double z = 44.6; z > 40; z -= 0.4) {
        set("other-z", z);
        bench.run(0.001);
    }
    set("other-radius", 0);
    bench.run(0.001);
    EXPECT_EQ(land(5, 0, 42), 12) << "this tool has not cut yet, and meets nothing";
    EXPECT_EQ(get("truth-cuts"), 0);
    set("gauge-z", 42.33);
    bench.run(0.002);
    EXPECT_EQ(get("truth-diameter"), 8);
    EXPECT_NEAR(land(3, 0, 42.33), 2 * std::hypot(3, 0.1), 1e-12);
}

TEST_F(SimLathe, BacklashWearEdgeAndWarmingShowInTheWork) {
    make_ideal();
    const double ideal = land(5, 0, 20);
    set("y-backlash", 0.004);
    go(50, 1, 20);
    go(50, 0, 20);
    EXPECT_NEAR(get("truth-height"), 0.102, 1e-12);
    go(50, -1, 20);
    go(50, 0, 20);
    EXPECT_NEAR(get("truth-height"), 0.098, 1e-12);
    set("y-backlash", 0);
    set("wear", 0.001);
    EXPECT_NEAR(land(5, 0, 30) - ideal, 0, 1e-5);
    EXPECT_NEAR(land(5, 0, 40) - ideal, 0.002, 1e-5);
    set("wear", 0);
    set("built-up-edge", 0.005);
    double least = 1, most = -1;
    for (int i = 0; i < 30; ++i) {
        const double deeper = ideal + 0.004 - land(5, 0, 41 + i);
        least = std::min(least, deeper);
        most = std::max(most, deeper);
    }
    EXPECT_GT(least, 0.0018);
    EXPECT_LT(least, 0.004);
    EXPECT_GT(most, 0.007);
    EXPECT_LT(most, 0.0102);
    set("built-up-edge", 0);
    set("x-growth", 0.02);
    set("spindle-lift", 0.01);
    const double before = get("truth-height");
    set("elapsed", 1800);
    EXPECT_NEAR(ideal + 0.004 - land(5, 0, 80), 0.04, 0.002);
    EXPECT_NEAR(before - get("truth-height"), 0.01, 0.001);
}

TEST_F(SimLathe, InsideTheToolWidensABore) {
    make_ideal();
    set("inside", 1);
    set("stock-diameter", 8);
    set("new-stock", 1);
    go(1, 0, 50);
    go(5, 0, 50);
    go(1, 0, 50);
    EXPECT_NEAR(get("truth-diameter"), 2 * std::hypot(5, 0.1), 1e-12);
    go(3, 0, 50);
    EXPECT_NEAR(get("truth-diameter"), 2 * std::hypot(5, 0.1), 1e-12);
}

TEST_F(SimLathe, OperatorsMakeSlips) {
    make_ideal();
    set("micrometer", 1);
    const double first = land(5, 0, 50);
    EXPECT_NEAR(measured(), first, 1e-12);
    set("slip", 1);
    EXPECT_NEAR(measured(), first / 2, 1e-12);
    set("slip", 2);
    EXPECT_NEAR(measured(), first / 25.4, 1e-12);
    set("slip", 3);
    land(4, 0, 60);
    EXPECT_NEAR(measured(), first, 1e-12);
}

TEST_F(SimLathe, BeamsLoseWhatTheWorkCovers) {
    make_ideal();
    const double d = land(5, 0, 50);
    measured();
    EXPECT_NEAR(get("emitted-area") - get("received-area"), 2 * d, 1e-9);
    set("beam-offset", 0.5);
    measured();
    EXPECT_NEAR(get("emitted-area") - get("received-area"), 2 * d, 1e-9);
    set("beam-round", 1);
    measured();
    const double off = get("emitted-area") - get("received-area");
    set("beam-offset", 0);
    measured();
    const double a = d / 2, middle = get("emitted-area") - get("received-area");
    EXPECT_NEAR(middle, 2 * (a * std::sqrt(400 - a * a) + 400 * std::asin(a / 20)), 1e-9);
    EXPECT_LT(off, middle);
}

TEST_F(SimLathe, SeedsDrawTheSameLathesAgain) {
    std::vector<double> heights, again;
    for (std::vector<double>* list : {&heights, &again})
        for (int seed = 1; seed <= 20; ++seed) {
            set("seed", seed);
            go(50, 0, 0);
            list->push_back(get("truth-height"));
        }
    EXPECT_EQ(heights, again);
    EXPECT_LT(*std::min_element(heights.begin(), heights.end()), -0.1);
    EXPECT_GT(*std::max_element(heights.begin(), heights.end()), 0.1);
}

}  // namespace
}  // namespace plumb
