// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/pi.hpp"
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace plumb {
namespace {

// Without any disturbance but those that a test adds.
struct SimElasticAxis : testing::Test {
    Bench bench;

    SimElasticAxis() {
        for (const char* line : {"loadrt siggen names=path", "loadrt sim_elastic_axis names=axis",
                                 "net path path.sine => axis.position-cmd", "setp path.amplitude 0"})
            bench.command(line);
        for (const char* pin : {"feed-forward", "friction", "command-delay", "resolution"})
            bench.set(std::string("axis.") + pin, 0);
        bench.set("axis.force-limit", 1e5);
        bench.command("addf path.update servo-thread");
        bench.command("addf axis.update servo-thread");
        bench.run(0.01);
    }
    void set(const std::string& pin, double value) { bench.set("axis." + pin, value); }
    double get(const std::string& pin) { return bench.get("axis." + pin); }
    void swing(double amplitude, double frequency) {
        bench.set("path.amplitude", amplitude);
        bench.set("path.frequency", frequency);
        bench.run(4);
    }
};

// Far below the resonance both masses are one: x/c = Kv / (Kv + s g), g = (s^2 + K s + K^2/4) / (K s +
// K^2/4).
TEST_F(SimElasticAxis, HasTheAmplitudeOfItsLoops) {
    set("resonance", 1000);
    swing(10, 2);
    const double w = 2 * pi * 2, k = 150, gain = 30;
    const double top_re = k * k / 4 - w * w, top_im = k * w, low_re = k * k / 4, low_im = k * w;
    const double norm = low_re * low_re + low_im * low_im;
    const double re = (top_re * low_re + top_im * low_im) / norm,
                 im = (top_im * low_re - top_re * low_im) / norm;
    EXPECT_NEAR(get("truth-upper"), 10 * gain / std::hypot(gain - w * im, w * re), 0.03);
    EXPECT_NEAR(get("truth-lower"), -get("truth-upper"), 0.03);
}

// A ramp, which the speed of a triangle is: e'' = -(e' Kv + e Kv / Ti), so e goes to 0, and to v / Kv
// without.
TEST_F(SimElasticAxis, AnIntegralLeavesNoLagAtAConstantSpeed) {
    bench.command("unlinkp axis.position-cmd");
    bench.command("net ramp path.sawtooth => axis.position-cmd");
    bench.set("path.amplitude", 1000);
    bench.set("path.frequency", 0.01);  // 20 mm/s
    for (const double time : {0.0, 0.2}) {
        set("integral-time", time);
        bench.run(8);
        const double lag = bench.get("path.sawtooth") - get("position");
        EXPECT_NEAR(lag, time > 0 ? 0 : 20.0 / 30, 0.05) << time;
    }
}

TEST_F(SimElasticAxis, AForceThatDropsLimitsItsAcceleration) {
    set("force-limit", 2000);
    swing(10, 2);  // 1579 mm/s2
    const double before = get("truth-upper");
    set("force-part", 0.5);
    bench.run(3);
    EXPECT_GT(std::abs(get("truth-upper") - before), 0.5);
}

TEST_F(SimElasticAxis, ALoadThatIsJammedStandsAndAScaleSlips) {
    swing(10, 1);
    set("jammed", 1);
    bench.run(0.1);
    const double place = get("truth-position");
    bench.run(1);
    EXPECT_EQ(get("truth-position"), place);
    set("slip", 0.25);
    bench.run(0.01);
    EXPECT_NEAR(get("position"), place + 0.25, 1e-9);
}

// A force below the friction moves the load by its travel at most, and it comes back.
TEST_F(SimElasticAxis, FrictionHasAMemory) {
    set("friction", 100);
    set("friction-travel", 0.02);
    swing(0, 1);
    bench.set("path.offset", 0.001);
    bench.run(0.05);
    EXPECT_GT(get("truth-position"), 0);
    EXPECT_LT(get("truth-position"), 0.001);
    bench.run(5);
    EXPECT_NEAR(get("truth-position"), 0.001, 1e-4) << "the integral overcomes it";
}

}  // namespace
}  // namespace plumb
