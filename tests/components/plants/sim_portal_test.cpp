// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"
#include "tests/support/near.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace plumb {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double urad = 1e-6;
constexpr double rounding = 1e-9;  // mm

Matrix3d turned(double ea, double eb, double ec) {
    return (AngleAxisd(ec, Vector3d::UnitZ()) * AngleAxisd(eb, Vector3d::UnitY()) *
            AngleAxisd(ea, Vector3d::UnitX()))
        .toRotationMatrix();
}

struct SimPortal : testing::Test {
    Bench bench;

    SimPortal() {
        bench.command("loadrt sim_portal names=machine,other");
        bench.command("addf machine.update servo-thread");
    }

    void set(const std::string& pin, double value) { bench.set("machine." + pin, value); }
    double get(const std::string& pin) { return bench.get("machine." + pin); }

    Vector3d three(const std::string& quantity) {
        return {get("truth-x-" + quantity), get("truth-y-" + quantity), get("truth-z-" + quantity)};
    }
    Vector3d error() { return three("error"); }

    void tilt(const std::string& axis, double ea, double eb, double ec) {
        set("ea0" + axis, ea);
        set("eb0" + axis, eb);
        set("ec0" + axis, ec);
    }

    // All axes there and at rest.
    void go(double x, double y, double z, double w = 0) {
        const double places[] = {x, y, z, w};
        for (int i = 0; i < 4; ++i) {
            const std::string axis(1, "xyzw"[i]);
            set(axis + "-position-cmd", places[i]);
            set(axis + "-nominal", places[i]);
        }
        set("servo-gain", 6000);
        bench.run(0.02);
        set("servo-gain", -1);
    }

    void mount(double length, double radial, double direction) {
        set("tool-length", length);
        set("radial-offset", radial);
        set("radial-direction", direction);
    }
};

TEST_F(SimPortal, WithoutTiltsTheTipIsWhereItShouldBe) {
    mount(200, 30, 90);
    go(100, 200, 300, 50);
    expect_near(three("tip"), {100, 230, 100}, rounding);
    set("portal", 1);
    bench.run(0.001);
    expect_near(three("tip"), {100, 230, 150}, rounding);
    expect_near(three("nominal"), {100, 230, 150}, rounding);
    expect_near(error(), Vector3d::Zero(), rounding);
}

TEST_F(SimPortal, ColumnLeansAsInTheWorkedExample) {
    tilt("y", 60 * urad, 0, -80 * urad);
    mount(-250, 25, 90);
    go(300, 800, 150);
    expect_near(error(), Vector3d(65.999, -15.004, 49.4995) * um, 0.001 * um);
}

TEST_F(SimPortal, ColumnIsTheProductOfItsBodies) {
    tilt("y", 300 * urad, 0, -450 * urad);
    mount(400, 50, 30);
    go(300, 800, 150);
    const Vector3d tool(50 * std::cos(M_PI / 6), 25, -400);
    expect_near(three("tip"),
                Vector3d(300, 0, 150) + turned(300 * urad, 0, -450 * urad) * (Vector3d(0, 800, 0) + tool),
                rounding);
    set("y-tool-follows", 0);
    bench.run(0.001);
    expect_near(three("tip"),
                Vector3d(300, 0, 150) + turned(300 * urad, 0, -450 * urad) * Vector3d(0, 800, 0) + tool,
                rounding);
}

struct SimPortalLeaning : SimPortal {
    const Matrix3d rail = turned(400 * urad, -300 * urad, 0), ram = turned(-200 * urad, 450 * urad, 0);
    const Vector3d tool{0, 50, -400}, saddle{0, 700, 0};
    const double z = -250, w = 600;

    SimPortalLeaning() {
        set("portal", 1);
        tilt("w", 400 * urad, -300 * urad, 0);
        tilt("z", -200 * urad, 450 * urad, 0);
        mount(400, 50, 90);
        go(300, 700, z, w);
    }

    void expect_tip(const Vector3d& on_rail) {
        bench.run(0.001);
        expect_near(three("tip"), Vector3d(300, 0, 0) + on_rail, rounding);
    }
};

TEST_F(SimPortalLeaning, PortalIsTheProductOfItsBodies) {
    expect_tip(rail * (Vector3d(0, 0, w) + saddle + ram * (Vector3d(0, 0, z) + tool)));
}

TEST_F(SimPortalLeaning, SaddleThatWasShimmedStaysLevel) {
    set("axis-direction", 1);
    expect_tip(saddle + rail * (Vector3d(0, 0, w) + ram * (Vector3d(0, 0, z) + tool)));
}

TEST_F(SimPortalLeaning, RamMeasuredAgainstTheBedDoesNotTurnWithTheRail) {
    set("to-bed", 1);
    expect_tip(rail * (Vector3d(0, 0, w) + saddle) + ram * (Vector3d(0, 0, z) + tool));
}

TEST_F(SimPortalLeaning, SquareToolTurnsWithTheOtherMembersOnly) {
    set("z-tool-follows", 0);
    expect_tip(rail * (Vector3d(0, 0, w) + saddle + ram * Vector3d(0, 0, z) + tool));
    set("w-tool-follows", 0);
    expect_tip(rail * (Vector3d(0, 0, w) + saddle + ram * Vector3d(0, 0, z)) + tool);
}

TEST_F(SimPortal, WorkOnATiltedAxisTurnsAndMovesWithIt) {
    set("portal", 1);
    tilt("x", 0, 200 * urad, 300 * urad);
    go(500, 200, -100, 50);
    const Matrix3d r = turned(0, 200 * urad, 300 * urad);
    expect_near(three("tip"), r.transpose() * (r * Vector3d(500, 0, 0) + Vector3d(0, 200, -50)), rounding);
}

TEST_F(SimPortal, AtThePivotTheTiltDisplacesTheToolAlone) {
    tilt("y", 60 * urad, 0, -80 * urad);
    set("y-pivot", 400);
    go(300, 400, 150);
    expect_near(error(), Vector3d::Zero(), rounding);
    expect_near(three("tip"), {300, 400, 150}, rounding);
    mount(250, 0, 0);
    bench.run(0.001);
    expect_near(error(), Vector3d(0, 15, 0) * um, 0.002 * um);
}

TEST_F(SimPortal, FollowingErrorIsNoneOfTheTipError) {
    tilt("y", 0, 0, 100 * urad);
    bench.command("loadrt siggen");
    bench.command("addf siggen.0.update servo-thread 1");
    bench.command("net y siggen.0.triangle => machine.y-position-cmd machine.y-nominal");
    bench.set("siggen.0.frequency", 0.05);
    bench.set("siggen.0.amplitude", 500);
    bench.run(4);  // 100 mm/s
    EXPECT_NEAR(get("y-position") - bench.get("siggen.0.triangle"), 100 / 30., 1e-3);
    EXPECT_NEAR(get("truth-y-nominal"), get("y-position"), rounding);
    expect_near(error(), Vector3d(-get("y-position") * 100 * urad, 0, 0), 0.01 * um);
}

TEST_F(SimPortal, AxisSettlesWithTheTimeConstantOfItsGain) {
    bench.run(0.01);
    set("z-position-cmd", 1);
    bench.run(1 / 30.);
    EXPECT_NEAR(get("z-position"), 1 - std::exp(-1), 0.02);
    bench.run(1);
    EXPECT_NEAR(get("z-position"), 1, 1e-9);
}

TEST_F(SimPortal, StartsAtRestAtItsCommand) {
    set("x-position-cmd", 300);
    set("x-nominal", 300);
    bench.run(0.001);
    EXPECT_NEAR(get("x-position"), 300, rounding);
    expect_near(error(), Vector3d::Zero(), rounding);
    set("x-position-cmd", 400);
    set("seed", 3);  // another machine, but no other place
    bench.run(0.001);
    EXPECT_LT(get("x-position"), 310);
}

TEST_F(SimPortal, ClampedRailStands) {
    set("portal", 1);
    go(0, 0, 0, 100);
    set("w-clamped", 1);
    go(0, 0, 0, 110);
    EXPECT_NEAR(get("w-position"), 100, rounding);
    EXPECT_NEAR(error().z(), -10, rounding);
    set("w-clamped", 0);
    go(0, 0, 0, 110);
    EXPECT_NEAR(get("w-position"), 110, 1e-6);
    set("w-position-cmd", 200);
    bench.run(0.03);
    const double under_way = get("w-position");
    set("w-clamped", 1);
    bench.run(0.1);
    EXPECT_NEAR(get("w-position"), under_way, rounding);
}

TEST_F(SimPortal, DriftTurnsTheTiltsByTheHour) {
    set("tilt-drift", 8 * urad);
    set("drift-start", 3600);
    tilt("y", 60 * urad, 0, -80 * urad);
    go(0, 1000, 0);
    const double ea = get("truth-ea0y") - 60 * urad, ec = get("truth-ec0y") + 80 * urad;
    for (const double drift : {ea, ec}) {
        EXPECT_GE(std::abs(drift), 4 * urad);
        EXPECT_LE(std::abs(drift), 8.001 * urad);
    }
    for (const char* other : {"eb0y", "ec0x", "ea0z", "eb0w"})
        EXPECT_EQ(get(std::string("truth-") + other), 0) << other;
    expect_near(three("beyond-tilts"), 1000 * Vector3d(-ec, 0, ea), 0.01 * um);
    bench.run(36);
    EXPECT_NEAR(get("truth-ea0y") - 60 * urad, ea * 1.01, 1e-3 * urad);
}

TEST_F(SimPortal, OnThePortalRailAndRamDrift) {
    set("portal", 1);
    set("seed", 3);
    set("drift-start", 3600);
    bench.run(0.001);
    for (const char* tilt : {"ea0w", "eb0w", "ea0z", "eb0z"}) {
        EXPECT_GT(std::abs(get(std::string("truth-") + tilt)), 1 * urad) << tilt;
        EXPECT_LT(std::abs(get(std::string("truth-") + tilt)), 10 * urad) << tilt;
    }
    EXPECT_EQ(get("truth-ea0y"), 0);
}

TEST_F(SimPortal, RamBendsWithTheSquareOfItsLengthOutside) {
    set("portal", 1);
    set("ram-sag", 0.02);
    set("z-min-limit", -500);
    set("z-max-limit", 0);
    go(0, 0, -250);
    expect_near(error(), Vector3d(5, 0, 0) * um, rounding);
    go(0, 0, -500);
    expect_near(error(), Vector3d(20, 0, 0) * um, rounding);
    set("portal", 0);
    bench.run(0.001);
    expect_near(error(), Vector3d::Zero(), rounding);
}

// The error motions of an axis over a travel of 1000 mm, there and back.
struct SimPortalGauged : SimPortal {
    SimPortalGauged() {
        bench.command("loadrt siggen");
        bench.command("addf siggen.0.update servo-thread 1");
        bench.command("net travel siggen.0.triangle => machine.gauge-position");
        bench.set("siggen.0.frequency", 2.5);
        bench.set("siggen.0.amplitude", 500);
        bench.set("siggen.0.offset", 500);
    }

    Table sweep() {
        bench.run(0.001);
        return bench.trace(0.399,
                           {"machine.gauge-position", "machine.truth-gauge-ex", "machine.truth-gauge-ey",
                            "machine.truth-gauge-ez", "machine.truth-gauge-ea", "machine.truth-gauge-eb",
                            "machine.truth-gauge-ec"});
    }
};

double range(const std::vector<double>& values) {
    const auto [lowest, highest] = std::minmax_element(values.begin(), values.end());
    return *highest - *lowest;
}

// The slope of the line that fits best.
double slope(const std::vector<double>& x, const std::vector<double>& y) {
    const auto n = static_cast<double>(x.size());
    const double mean = std::accumulate(x.begin(), x.end(), 0.0) / n;
    double moment = 0, squares = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        moment += (x[i] - mean) * y[i];
        squares += (x[i] - mean) * (x[i] - mean);
    }
    return moment / squares;
}

TEST_F(SimPortalGauged, StraightnessIsDrawnAndLeavesTheSquarenessAlone) {
    set("gauge-axis", 1);
    for (int seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        set("seed", seed);
        const Table table = sweep();
        for (const std::string error : {"ex", "ez"}) {
            const std::vector<double> e = table.column("machine.truth-gauge-" + error);
            EXPECT_NEAR(1000 * slope(table.column("machine.gauge-position"), e), 0, 0.005 * um);
            EXPECT_GT(range(e), 1.99 * um);
            EXPECT_LT(range(e), 5.01 * um);
        }
        EXPECT_EQ(range(table.column("machine.truth-gauge-ey")), 0);
    }
}

TEST_F(SimPortalGauged, PitchAndYawAreDrawnAndThereIsNoRoll) {
    set("gauge-axis", 2);
    for (int seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE(seed);
        set("seed", seed);
        const Table table = sweep();
        for (const std::string error : {"ea", "eb"}) {
            EXPECT_GT(range(table.column("machine.truth-gauge-" + error)), 4.98 * urad);
            EXPECT_LT(range(table.column("machine.truth-gauge-" + error)), 20.02 * urad);
        }
        EXPECT_EQ(range(table.column("machine.truth-gauge-ec")), 0);
    }
}

TEST_F(SimPortalGauged, ErrorsCountFromThePivot) {
    set("seed", 6);
    bench.set("siggen.0.amplitude", 0);
    bench.set("siggen.0.offset", 300);
    set("x-pivot", 300);
    bench.run(0.001);
    EXPECT_EQ(get("truth-gauge-ey"), 0);
    set("x-pivot", 0);
    bench.run(0.001);
    EXPECT_NE(get("truth-gauge-ey"), 0);
}

// Small errors add up: the tip moves as the gauge shows, with yaw by the lever behind it.
TEST_F(SimPortal, TipMovesByWhatTheGaugeShows) {
    set("seed", 4);
    set("tilt-drift", 0);
    const auto gauge = [&](int axis, double position) {
        set("gauge-axis", axis);
        set("gauge-position", position);
        bench.run(0.001);
        return std::pair(Vector3d(get("truth-gauge-ex"), get("truth-gauge-ey"), get("truth-gauge-ez")),
                         Vector3d(get("truth-gauge-ea"), get("truth-gauge-eb"), get("truth-gauge-ec")));
    };
    mount(300, 0, 0);
    go(700, 400, 500);
    const auto [straight_x, turn_x] = gauge(0, 700);
    const auto [straight_y, turn_y] = gauge(1, 400);
    const auto [straight_z, turn_z] = gauge(2, 500);
    const Vector3d tool(0, 0, -300), head = Vector3d(0, 400, 0) + tool;
    const Vector3d from_work = Vector3d(700, 400, 0) + tool + Vector3d(0, 0, 500);
    const Vector3d expected = straight_x + straight_y + straight_z + turn_x.cross(head) + turn_y.cross(tool) -
                              turn_z.cross(from_work);
    EXPECT_GT(expected.norm(), 3 * um);
    expect_near(error(), expected, 0.002 * um);
    expect_near(three("beyond-tilts"), expected, 0.002 * um);
}

TEST_F(SimPortal, WhatTiltsMakeIsNotBeyondThem) {
    set("portal", 1);
    set("seed", 7);
    go(600, 700, 300, 200);
    const Vector3d drawn = error();
    tilt("w", 40 * urad, -30 * urad, 0);
    bench.run(0.001);
    EXPECT_GT((error() - drawn).norm(), 20 * um);
    expect_near(three("beyond-tilts"), drawn, 0.05 * um);
}

TEST_F(SimPortal, TypicalMachineHasNothingButTilts) {
    set("portal", 1);
    set("drift-start", 36000);
    go(600, 700, 300, 200);
    expect_near(error(), Vector3d::Zero(), rounding);
}

TEST_F(SimPortal, ProbeTripsWhereItsBallTouchesTheBox) {
    set("artifact-width", 100);
    set("artifact-depth", 80);
    set("artifact-height", 50);
    set("artifact-x", 200);
    set("artifact-y", 300);
    set("artifact-z", -150);
    set("ball-radius", 3);
    mount(120, 0, 0);
    const auto gap = [&](double x, double y, double z) {  // of the ball there
        go(x, y, z + 120);
        EXPECT_EQ(get("probe-tripped"), get("truth-probe-gap") <= 0);
        return get("truth-probe-gap");
    };
    EXPECT_NEAR(gap(250, 340, -90), 7, 1e-6) << "above";
    EXPECT_NEAR(gap(250, 340, -97.5), -0.5, 1e-6);
    EXPECT_NEAR(gap(190, 340, -120), 7, 1e-6) << "beside";
    EXPECT_NEAR(gap(302, 340, -120), -1, 1e-6);
    EXPECT_NEAR(gap(304, 384, -120), std::sqrt(32) - 3, 1e-6) << "at an edge";
    EXPECT_NEAR(gap(196, 296, -96), std::sqrt(48) - 3, 1e-6) << "at a corner";
    EXPECT_NEAR(gap(210, 340, -130), -13, 1e-6) << "inside";
    set("artifact-bore", 40);
    EXPECT_NEAR(gap(250, 340, -120), 17, 1e-6) << "in the bore";
    EXPECT_NEAR(gap(266, 340, -120), 1, 1e-6);
    EXPECT_NEAR(gap(253, 344, -120), 12, 1e-6);
    EXPECT_NEAR(gap(267, 340, -96), 5 - 3, 1e-6) << "above the rim";
    EXPECT_NEAR(gap(275, 340, -120), -8, 1e-6) << "in the wall";
    set("artifact-height", 0);
    bench.run(0.001);
    EXPECT_EQ(get("probe-tripped"), 0);
}

TEST_F(SimPortal, ProbeFeelsTheTilt) {
    for (const char* size : {"artifact-width", "artifact-depth", "artifact-height"}) set(size, 1000);
    set("ball-radius", 2);
    go(-3, 800, 10);
    EXPECT_NEAR(get("truth-probe-gap"), 1, 1e-6);
    tilt("y", 0, 0, 100 * urad);
    bench.run(0.001);
    EXPECT_NEAR(get("truth-probe-gap"), 1.08, 1e-6);
}

TEST_F(SimPortal, InstancesAreIndependent) {
    bench.command("addf other.update servo-thread");
    bench.set("other.seed", 3);
    bench.set("other.eb0z", 50 * urad);
    bench.set("other.x-position-cmd", 20);
    go(10, 20, 30);
    expect_near(error(), Vector3d::Zero(), rounding);
    EXPECT_GT(bench.get("other.x-position"), 1);
}

// Two machines on the same signals: the effect of an impossible value on one must end with the value.
TEST(SimPortalPoison, IsForgotten) {
    Bench bench;
    bench.command("loadrt sim_portal names=machine,twin");
    bench.command("addf machine.update servo-thread");
    bench.command("addf twin.update servo-thread");
    for (const std::string machine : {"machine.", "twin."}) {
        bench.set(machine + "seed", 2);
        bench.set(machine + "portal", 1);
        bench.set(machine + "ea0w", 1e-4);
        bench.set(machine + "x-position-cmd", 50);
        bench.set(machine + "artifact-width", 10);
    }
    bench.run(1);
    const std::vector<std::string> outputs{"x-position",           "truth-x-tip", "truth-z-error",
                                           "truth-y-beyond-tilts", "truth-ea0w",  "truth-gauge-ey",
                                           "truth-probe-gap"};
    for (const std::string& pin : outputs) bench.expect("finite(x)", {{"x", "machine." + pin}});
    for (const std::string pin :
         {"x-position-cmd", "z-nominal",      "w-pivot",     "x-min-limit",    "y-max-limit",
          "ea0w",           "ec0x",           "tool-length", "radial-offset",  "radial-direction",
          "drift-start",    "gauge-position", "servo-gain",  "ram-sag",        "tilt-drift",
          "z-straightness", "w-pitch-yaw",    "artifact-x",  "artifact-width", "artifact-bore",
          "ball-radius"}) {
        SCOPED_TRACE(pin);
        bench.poison("machine." + pin, 0.01);
        bench.run(1.5);
        for (const std::string& output : outputs)
            EXPECT_NEAR(bench.get("machine." + output), bench.get("twin." + output), 0.01 * um) << output;
    }
}

TEST(SimPortalPeriod, DoesNotMatter) {
    const auto errors = [](const std::string& period) {
        Bench bench(Bench::Thread::none);
        bench.command("loadrt threads name1=t period1=" + period);
        bench.command("loadrt sim_portal names=machine");
        bench.command("addf machine.update t");
        bench.set("machine.seed", 5);
        bench.set("machine.ec0y", 1e-4);
        bench.set("machine.y-position-cmd", 900);
        bench.set("machine.y-nominal", 900);
        bench.command("start");
        bench.run(36);
        return Vector3d(bench.get("machine.truth-x-error"), bench.get("machine.truth-y-error"),
                        bench.get("machine.truth-z-error"));
    };
    expect_near(errors("500000"), errors("4000000"), 0.01 * um);
}

// A cycle of X between two places, and the load behind the motor at the end of each way.
TEST_F(SimPortal, TheLoadLagsByHalfThePlayInEitherDirection) {
    set("x-play", 0.02);
    set("x-stick", 0.001);
    go(0, 0, 0);
    go(100, 0, 0);
    EXPECT_NEAR(get("truth-x-load") - get("x-position"), -0.01, rounding);
    EXPECT_NEAR(get("truth-x-error"), -0.01, rounding);
    go(90, 0, 0);
    EXPECT_NEAR(get("truth-x-load") - get("x-position"), 0.01, rounding);
    EXPECT_NEAR(get("truth-x-error"), 0.01, rounding);
    EXPECT_NEAR(get("truth-x-beyond-tilts"), 0.01, rounding);
}

TEST_F(SimPortal, ALoadAtRestBreaksAwayWhenTheMotorHasWoundUpFurther) {
    set("x-play", 0.02);
    set("x-stick", 0.003);
    go(0, 0, 0);
    go(100, 0, 0);  // the load at 99.99
    go(99.979, 0, 0);
    EXPECT_NEAR(get("truth-x-load"), 99.99, rounding);  // wound up by 11 um, held until 13
    go(99.976, 0, 0);
    EXPECT_NEAR(get("truth-x-load"), 99.986, rounding);
}

TEST_F(SimPortal, PlayVariesAlongTheTravel) {
    set("seed", 3);
    for (const char* error : {"x-straightness", "x-pitch-yaw"}) set(error, 0);
    set("x-play", 0.02);
    set("x-play-variation", 0.3);
    double least = 1, most = 0;
    go(-5, 0, 0);
    for (double x = 0; x <= 1000; x += 50) {
        go(x + 5, 0, 0);
        const double low = get("truth-x-load") - get("x-position");
        least = std::min(least, -2 * low);
        most = std::max(most, -2 * low);
    }
    EXPECT_LT(least, 0.018);
    EXPECT_GT(least, 0.0139);
    EXPECT_GT(most, 0.021);
    EXPECT_LT(most, 0.0261);
}

TEST_F(SimPortal, ADriveWithAScaleAtTheLoadLosesNoMotion) {
    set("x-play", 0.02);
    set("x-scale-at-load", 1);
    go(0, 0, 0);
    go(100, 0, 0);
    EXPECT_NEAR(get("truth-x-error"), 0, 1e-6);
    go(90, 0, 0);
    EXPECT_NEAR(get("truth-x-error"), 0, 1e-6);
}

TEST_F(SimPortal, GuidesShiftAndTurnWithTheSideToWhichTheyArePushed) {
    set("x-play", 0.02);
    set("x-straightness-reversal", 0.002);
    set("x-yaw-reversal", 10 * urad);
    mount(0, 100, 0);
    go(0, 0, 0);
    go(100, 0, 0);
    EXPECT_NEAR(get("truth-y-error"), 0.002 + 0.001, 1e-8);
    go(90, 0, 0);
    EXPECT_NEAR(get("truth-y-error"), -0.002 - 0.001, 1e-8);
}

TEST_F(SimPortal, AnIndicatorReadsTheErrorWithItsNoise) {
    set("x-play", 0.02);
    set("gauge-noise", 0.001);
    go(0, 0, 0);
    go(100, 0, 0);
    double sum = 0, squares = 0;
    constexpr int count = 400;
    for (int i = 0; i < count; ++i) {
        bench.run(0.001);
        const double rest = get("x-indicator") + 0.01;
        sum += rest;
        squares += rest * rest;
    }
    EXPECT_NEAR(sum / count, 0, 0.0002);
    EXPECT_NEAR(std::sqrt(squares / count), 0.001, 0.0001);
}

}  // namespace
}  // namespace plumb
