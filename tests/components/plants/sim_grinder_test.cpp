// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/pi.hpp"
#include "tests/support/bench.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumb {
namespace {

// Without any disturbance but those that a test adds.
struct SimGrinder : testing::Test {
    Bench bench;

    SimGrinder() {
        bench.command("loadrt siggen names=path");
        bench.command("loadrt sim_grinder names=axis");
        bench.command("net path path.sine => axis.position-cmd");
        for (const char* pin : {"feed-forward", "friction", "stiction", "backlash", "load-resonance",
                                "command-delay", "wheel-force", "resolution"})
            bench.set(std::string("axis.") + pin, 0);
        bench.set("axis.force-limit", 1e5);
        bench.set("path.amplitude", 0);
        bench.command("addf path.update servo-thread");
        bench.command("addf axis.update servo-thread");
        bench.run(0.01);
    }
    void set(const std::string& pin, double value) { bench.set("axis." + pin, value); }
    double get(const std::string& pin) { return bench.get("axis." + pin); }
    void swing(double amplitude, double frequency) {
        bench.set("path.amplitude", amplitude);
        bench.set("path.frequency", frequency);
        bench.run(3);
    }
};

// The transfer function of position loop and velocity loop, at one frequency.
TEST_F(SimGrinder, HasTheAmplitudeOfItsLoops) {
    swing(10, 2);
    const double w = 2 * pi * 2, loop = 2 * pi * 60, gain = 35;
    const double re = 1 - w * w / (loop * loop), im = 2 * 0.7 * w / loop;
    // vc = gain (c - x), x = vc / (s (re + j im)): x/c = gain / (gain + s (re + j im))
    const double amplitude = gain / std::hypot(gain - w * im, w * re);
    EXPECT_NEAR(get("truth-upper"), 10 * amplitude, 0.01);
    EXPECT_NEAR(get("truth-lower"), -10 * amplitude, 0.01);
    EXPECT_NEAR(get("truth-cycle-time"), 0.5, 0.0011);
}

TEST_F(SimGrinder, FeedForwardTakesTheLagAway) {
    swing(10, 2);
    const double lagging = get("truth-upper");
    set("feed-forward", 1);
    bench.run(3);
    EXPECT_LT(lagging, 9.7);
    EXPECT_GT(get("truth-upper"), 10) << "the velocity loop overshoots";
    EXPECT_LT(get("truth-upper"), 10.2);
}

TEST_F(SimGrinder, AHandPushesItOnlyWhileTheDriveIsOff) {
    set("push-speed", 300);
    bench.run(0.4);
    EXPECT_NEAR(get("truth-position"), 0, 1e-9);
    set("enabled", 0);
    bench.run(0.4);
    EXPECT_NEAR(get("truth-position"), 120, 1e-6);
    set("push-speed", 0);
    bench.run(0.4);
    EXPECT_NEAR(get("position"), 120, 1e-6);
}

TEST_F(SimGrinder, BacklashIsBetweenMotorAndLoad) {
    set("backlash", 0.1);
    set("scale-at-load", 0);
    swing(10, 1);
    const Table table = bench.trace(2, {"axis.position", "axis.truth-position"});
    double largest = 0;
    for (const auto& row : table.rows) largest = std::max(largest, std::abs(row[1] - row[2]));
    EXPECT_NEAR(largest, 0.05, 1e-9);
    const double motor = get("position");
    set("scale-at-load", 1);
    bench.run(0.001);
    EXPECT_NEAR(get("position"), get("truth-position"), 1e-12);
    EXPECT_NE(motor, get("position"));
}

TEST_F(SimGrinder, ForceIsLimited) {
    set("force-limit", 2000);
    swing(10, 4);
    EXPECT_LE(get("truth-acceleration"), 2000);
    EXPECT_GT(get("truth-acceleration"), 1999);
    EXPECT_LT(get("truth-upper"), 10 * 0.9);
}

TEST_F(SimGrinder, FrictionTakesForceAndHoldsAtRest) {
    set("force-limit", 5000);
    swing(10, 1);
    const double free = get("truth-acceleration");
    set("friction", 0.3);
    bench.run(3);
    EXPECT_GT(get("truth-acceleration"), free + 0.9 * 0.3 * 5000);
    bench.set("path.amplitude", 0);
    bench.run(5);
    const double rest = get("truth-position");
    bench.run(1);
    EXPECT_EQ(get("truth-position"), rest);
}

TEST_F(SimGrinder, ALoadOnASpringSwingsFartherNearItsResonance) {
    swing(1, 10);
    const double rigid = get("truth-upper");
    set("load-resonance", 40);
    bench.run(3);
    EXPECT_NEAR(get("truth-upper") / rigid, 1 / (1 - 1.0 / 16), 0.02);
}

TEST_F(SimGrinder, TheCommandIsDelayed) {
    bench.command("unlinkp axis.position-cmd");
    set("command-delay", 0.0025);
    set("position-cmd", 1);
    const std::vector<double> z = bench.trace(0.02, {"axis.truth-position"}).column("axis.truth-position");
    int first = 0;
    while (z[static_cast<std::size_t>(first)] == 0) ++first;
    EXPECT_GE(first, 3);
    EXPECT_LE(first, 4);
}

TEST_F(SimGrinder, TheScaleHasItsStepAndTheWheelItsForce) {
    set("resolution", 0.01);
    swing(10, 1);
    const double read = get("position");
    EXPECT_NEAR(read / 0.01, std::round(read / 0.01), 1e-6);
    set("resolution", 0);
    set("contact-low", -5);
    set("contact-high", 5);
    bench.run(3);
    const std::vector<double> free = bench.trace(1, {"axis.position"}).column("axis.position");
    set("wheel-force", 0.01);
    bench.run(3);
    const std::vector<double> cuts = bench.trace(1, {"axis.position"}).column("axis.position");
    double largest = 0;
    for (std::size_t i = 0; i < free.size(); ++i) largest = std::max(largest, std::abs(free[i] - cuts[i]));
    EXPECT_GT(largest, 0.001);
}

TEST_F(SimGrinder, ASeedDrawsAnotherAxisAndTheSameOneAgain) {
    for (const char* pin : {"feed-forward", "force-limit"}) set(pin, -1);
    swing(10, 1);
    set("seed", 7);
    bench.run(3);
    const double seventh = get("truth-upper"), limit = get("truth-force-limit");
    set("seed", 8);
    bench.run(3);
    EXPECT_NE(get("truth-upper"), seventh);
    EXPECT_NE(get("truth-force-limit"), limit);
    set("seed", 7);
    bench.run(3);
    EXPECT_NEAR(get("truth-upper"), seventh, 1e-6);
    EXPECT_EQ(get("truth-force-limit"), limit);
}

TEST_F(SimGrinder, SwitchedOffItStandsAndOnItDoesNotJump) {
    swing(10, 1);
    set("enabled", 0);
    bench.run(0.1);
    const double place = get("truth-position");
    bench.run(0.3);
    EXPECT_EQ(get("truth-position"), place);
}

}  // namespace
}  // namespace plumb
