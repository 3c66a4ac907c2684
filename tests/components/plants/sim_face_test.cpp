// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

namespace plumb {
namespace {

constexpr double um = 0.001;

// The wheel goes towards smaller X, into a face from Z -20 to -10.
struct SimFace : testing::Test {
    SimFace() {
        bench.command("loadrt sim_face names=face");
        bench.command("addf face.update servo-thread");
        for (const auto& [pin, value] : {std::pair<const char*, double>{"low", -20},
                                         {"high", -10},
                                         {"z-position", -15},
                                         {"size", -0.1},
                                         {"cutting-time", 1},
                                         {"wear-ratio", 0.05}})
            set(pin, value);
    }
    void set(const std::string& pin, double value) { bench.set("face." + pin, value); }
    double get(const std::string& pin) { return bench.get("face." + pin); }

    Bench bench;
};

TEST_F(SimFace, ADeflectionIsGroundAwayAndWearStays) {
    set("x-position", -0.2);
    bench.run(0.002);
    EXPECT_NEAR(get("truth-deflection"), 0.2, 1 * um);
    bench.run(1);
    EXPECT_NEAR(get("truth-face"), -0.2 * (1 - std::exp(-1.05)) / 1.05, 1 * um);
    bench.run(20);
    EXPECT_NEAR(get("truth-deflection"), 0, 0.1 * um);
    EXPECT_NEAR(get("truth-face"), -0.2 / 1.05, 0.1 * um) << "too large by the wear";
    EXPECT_NEAR(get("truth-wear"), 0.05 * 0.2 / 1.05, 0.1 * um);
}

TEST_F(SimFace, OnlyAWheelThatTurnsAtTheFaceCuts) {
    set("wheel-on", 0);
    set("x-position", -0.2);
    bench.run(1);
    EXPECT_EQ(get("truth-face"), 0);
    for (const double beside : {-20.1, -9.9}) {
        set("z-position", beside);
        bench.run(0.002);
        set("wheel-on", 1);
        bench.run(1);
        EXPECT_EQ(get("truth-face"), 0) << beside;
        set("wheel-on", 0);
    }
    set("z-position", -10);
    set("wheel-on", 1);
    bench.run(1);
    EXPECT_LT(get("truth-face"), -0.1);
    set("x-position", 0.5);
    bench.run(0.002);
    const double ground = get("truth-face");
    bench.run(1);
    EXPECT_EQ(get("truth-face"), ground) << "in air";
    EXPECT_EQ(get("truth-deflection"), 0);
}

TEST_F(SimFace, TheGaugeActsAtSizeAndAFreshFaceIsNew) {
    set("x-position", -0.2);
    for (int i = 0; i < 1000 && get("truth-face") > -0.099; ++i) {
        EXPECT_EQ(get("at-size"), 0);
        bench.run(0.001);
    }
    bench.run(1);
    EXPECT_EQ(get("at-size"), 1);
    set("x-position", 1);
    set("fresh", 1);
    bench.run(0.002);
    EXPECT_EQ(get("truth-face"), 0);
    EXPECT_EQ(get("truth-wear"), 0);
    EXPECT_EQ(get("at-size"), 0);
}

TEST_F(SimFace, AnInvalidPositionLeavesTheLastOneInForce) {
    set("x-position", -0.2);
    bench.run(1);
    for (const double bad : {std::nan(""), 1e308}) {
        set("x-position", bad);
        set("z-position", bad);
        bench.run(0.5);
        EXPECT_TRUE(std::isfinite(get("truth-face")));
    }
    bench.run(20);
    EXPECT_NEAR(get("truth-face"), -0.2 / 1.05, 0.1 * um);
}

}  // namespace
}  // namespace plumb
