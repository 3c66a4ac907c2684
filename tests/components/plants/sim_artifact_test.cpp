// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"
#include "tests/support/near.hpp"

#include <Eigen/Core>

#include <cmath>

namespace plumb {
namespace {

using Eigen::Vector3d;

// A machine that follows commands, in periods of a millisecond; nothing disturbs a touch until a test wants
// it.
struct SimArtifact : testing::Test {
    Bench bench;

    SimArtifact() {
        bench.command("loadrt sim_artifact names=it");
        bench.command("addf it.update servo-thread");
        for (const char* pin :
             {"probe-repeatability", "probe-seating", "probe-drift", "probe-false-triggers"})
            set(pin, 0);
        go(0, 0, 0);
    }

    void set(const std::string& pin, double value) { bench.set("it." + pin, value); }
    double get(const std::string& pin) { return bench.get("it." + pin); }
    Vector3d three(const std::string& first, const std::string& rest) {
        return {get(first + "x" + rest), get(first + "y" + rest), get(first + "z" + rest)};
    }
    void command(double x, double y, double z) {
        set("x-position-cmd", x);
        set("y-position-cmd", y);
        set("z-position-cmd", z);
    }
    void go(double x, double y, double z) {
        command(x, y, z);
        bench.run(0.1);
    }

    // Moves along an axis at 1 mm/s from the present place until the probe touches.
    double touch(int axis, double direction) {
        Vector3d at(get("x-position"), get("y-position"), get("z-position"));
        const double start = at[axis];
        for (int step = 0; step < 4000 && get("probe") == 0; ++step) {
            at[axis] = start + direction * 0.001 * step;
            command(at.x(), at.y(), at.z());
            bench.run(0.001);
        }
        EXPECT_EQ(get("probe"), 1);
        return get(std::string(1, "xyz"[axis]) + "-position");
    }
};

TEST_F(SimArtifact, ProbeMeetsTheFaceBesideTheBoreAndItsWalls) {
    go(25, -60, -136);
    EXPECT_EQ(get("probe"), 0);
    EXPECT_NEAR(touch(2, -1), -137, 0.01);  // the face at -140, and the ball
    go(25, -60, -100);
    go(0, -60, -100);
    go(0, -60, -150);
    EXPECT_EQ(get("probe"), 0);
    go(11, -60, -150);
    EXPECT_NEAR(touch(0, 1), 12, 0.02);  // the wall at 15, and the ball, and the pre-travel
    go(0, -60, -150);
    go(0, -71, -150);
    EXPECT_NEAR(touch(1, -1), -72, 0.02);
}

TEST_F(SimArtifact, ProbeMeetsTheSphereOnTopAndAtItsEquator) {
    go(0, 0, -106);
    EXPECT_EQ(get("probe"), 0);
    EXPECT_NEAR(touch(2, -1), -120 + 13, 0.01);
    go(0, 0, -100);
    go(-14, 0, -100);
    go(-14, 0, -120);
    EXPECT_EQ(get("probe"), 0);
    EXPECT_NEAR(touch(0, 1), -13, 0.02);
    go(-20, 0, -120);
    go(-20, 14, -120);
    go(0, 14, -120);
    EXPECT_NEAR(touch(1, -1), 13, 0.02);
    go(0, 0, -100);
    set("table-position-cmd", 180);
    go(0, 0, -106);
    EXPECT_NEAR(touch(2, -1), -120 + 13, 0.01);
}

TEST_F(SimArtifact, ProbeThatTouchesStaysSoWhileAnOffsetCreeps) {
    go(25, -60, -136);
    const double z = touch(2, -1) - 0.001;
    for (int step = 0; step < 200; ++step) {
        command(25 + 1e-6 * step, -60, z);
        bench.run(0.001);
    }
    EXPECT_EQ(get("probe"), 1);
    for (int step = 0; step < 200; ++step) {  // the trip ends once
        const double before = get("probe");
        command(25, -60, z + 0.0001 * step);
        bench.run(0.001);
        EXPECT_LE(get("probe"), before);
    }
    EXPECT_EQ(get("probe"), 0);
}

TEST_F(SimArtifact, BoreIsAtTheOtherSideWhenTheTableIsTurned) {
    set("table-position-cmd", 180);
    go(25, -60, -136);
    EXPECT_NEAR(touch(2, -1), -137, 0.01);
    go(0, 0, 0);
    set("trunnion", 1);
    go(25, 60, -136);
    EXPECT_NEAR(touch(2, -1), -137, 0.01);
}

TEST_F(SimArtifact, WarmSpindleGrowsTowardsTheArtifact) {
    set("tau-turning", 2);
    set("spindle-speed-cmd", 8000);
    bench.run(1000);
    const Vector3d d = three("truth-", "-deviation");
    EXPECT_GT(d.z(), 30 * um);
    go(25, -60, -136);
    // The pre-travel of this machine is 3 um; a period at 1 mm/s is 1 um.
    EXPECT_NEAR(touch(2, -1), -137 + d.z(), 6 * um);
}

TEST_F(SimArtifact, CompensationFollowsTheTemperaturesAndIsConfirmedWhenItIsThere) {
    set("tau-turning", 2);
    set("sensor-lag", 1);
    set("spindle-speed-cmd", 8000);
    bench.run(600);
    EXPECT_EQ(get("compensation-on"), 0);
    EXPECT_EQ(get("z-offset"), 0);
    set("compensation-request", 1);
    bench.run(1);
    EXPECT_EQ(get("compensation-on"), 0);
    bench.run(5);
    EXPECT_EQ(get("compensation-on"), 1);
    const double drift = get("truth-z-deviation");
    EXPECT_NEAR(get("z-offset"), drift, 0.3 * drift);
    EXPECT_NEAR(get("truth-z-residual"), drift - get("z-offset"), 1e-9);
    const double good = get("z-offset");
    set("compensation-fault", 2);
    bench.run(5);
    EXPECT_LT(get("z-offset"), -0.5 * good);
    set("compensation-fault", 1);
    bench.run(0.1);
    EXPECT_EQ(get("z-offset"), 0);
    set("compensation-request", 0);
    bench.run(1);
    EXPECT_EQ(get("compensation-on"), 1);
    bench.run(5);
    EXPECT_EQ(get("compensation-on"), 0);
}

TEST_F(SimArtifact, FaultsOfSensorsShowAtTheirPins) {
    set("sensor-dropouts", 0);
    set("compensation-fault", 6);
    set("tau-turning", 2);
    set("spindle-speed-cmd", 8000);
    bench.run(10);
    const double frozen = get("temperature-0");
    bench.run(300);
    EXPECT_EQ(get("temperature-0"), frozen);
    set("compensation-fault", 0);
    bench.run(10);
    EXPECT_GT(get("temperature-0"), frozen + 3);
    const double spindle = get("temperature-0"), bed = get("temperature-1");
    set("compensation-fault", 8);
    bench.run(10);
    EXPECT_NEAR(get("temperature-0"), bed, 1);
    EXPECT_NEAR(get("temperature-1"), spindle, 1);
    set("compensation-fault", 7);
    bench.run(10);
    EXPECT_NEAR(get("temperature-0"), spindle + 4, 1);
}

TEST_F(SimArtifact, SensorThatGivesNothingBecomesOldAndInvalid) {
    set("sensor-dropouts", 1);
    bench.run(30);
    EXPECT_GT(get("temperature-age-2"), 10);
    EXPECT_EQ(get("temperature-valid-2"), 1);
    bench.run(60);
    EXPECT_EQ(get("temperature-valid-2"), 0);
}

TEST_F(SimArtifact, ReplayedGrowthIsTheGrowth) {
    set("use-replay", 1);
    set("replay-z", 0.05);
    set("replay-x", -0.01);
    bench.run(0.01);
    const Vector3d d = three("truth-", "-deviation");
    EXPECT_NEAR(d.z(), 0.05, 1 * um);
    EXPECT_NEAR(d.x(), 0.01, 1 * um);
}

}  // namespace
}  // namespace plumb
