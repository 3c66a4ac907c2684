// SPDX-License-Identifier: GPL-2.0-or-later
// chopping on the simulated axis; grinder_linuxcnc_test.py has it in LinuxCNC itself.
#include "components/math/blocks/random.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/chopping_axis.hpp"
#include "tests/support/live.hpp"
#include "tests/support/rounds.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Strokes far from R, so that the offset is about the same at any time.
void bring_to_life(Bench& bench) {
    bench.command("loadrt threads name1=servo-thread period1=1000000");
    wire(bench);
    for (const char* line : {"setp chop.upper -19", "setp chop.learn 1", "setp chop.run 1", "start"})
        bench.command(line);
    bench.run(1);
}

// A joint that moves away from its stroke, of -8 to -20, at 200 mm/s, so that max-offset stops the offset.
void stroke_beyond(Bench& bench, long period_ns) {
    bench.command("loadrt threads name1=servo-thread period1=" + std::to_string(period_ns));
    wire(bench);
    for (const char* line : {"setp chop.feed 200", "setp chop.max-offset 21", "start", "setp chop.run 1"})
        bench.command(line);
    bench.run(1);
    bench.set("chop.position", 5);
    bench.run(1);
}

// All inputs but those that stop an axis dead, without its drive, and the acceleration itself.
const Live live{{{"chopping", "chop"}},
                bring_to_life,
                3.6,
                1,
                {{},
                 {"run",          "stop",           "enable",     "feed-hold",      "go-to-end",
                  "shift",        "emergency-hold", "hold-kind",  "upper",          "lower",
                  "position",     "feed",           "override",   "max-offset",     "max-rate",
                  "lead",         "jerk-time",      "stop-kind",  "joint-feedback", "learn",
                  "program-word", "program-value",  "exact-stop", "exact-stop-time"},
                 {}},
                stroke_beyond};

using Chopping = ChoppingAxis;

TEST_F(Chopping, StrokesBetweenItsDeadPointsAndReturnsToR) {
    start();
    std::vector<double> z = commands(1.5);
    EXPECT_EQ(get("active"), 1);
    z.erase(z.begin(), z.begin() + 700);
    const auto [low, high] = std::minmax_element(z.begin(), z.end());
    EXPECT_NEAR(*low, -20, 1000 * dt * dt / 8);
    EXPECT_NEAR(*high, -8, 1000 * dt * dt / 8);
    EXPECT_GE(*low, -20);
    EXPECT_LE(*high, -8);
    EXPECT_LE(hardest(z), 1000 * 1.01);
    EXPECT_NEAR(get("planned-cycle-time"), 3.14159265 * 12 / 60, 0.001);
    EXPECT_NEAR(get("actual-cycle-time"), get("planned-cycle-time"), dt + 1e-9);
    set("run", 0);
    bench.run(2);
    EXPECT_EQ(get("offset"), 0);
    EXPECT_EQ(get("at-end"), 1);
    EXPECT_EQ(get("active"), 0);
}

TEST_F(Chopping, ABoundBelowItsOffsetIsRefusedAndMovesNothing) {
    set("stop-kind", 1);
    start();
    bench.run(1);
    set("run", 0);
    bench.run(1);
    const double rest = get("offset");
    EXPECT_LE(rest, -8);
    set("max-offset", 5);
    for (const double z : commands(0.5)) ASSERT_EQ(z, rest);
    EXPECT_EQ(get("fault-code"), 17);
    set("go-to-end", 1);
    bench.run(2);
    EXPECT_EQ(get("offset"), 0);
    EXPECT_EQ(get("fault-code"), 0);
}

// The joint moves away from its stroke.
TEST_F(Chopping, AtMaxOffsetItBrakesWithinTenTimesItsAcceleration) {
    for (const int period : {250000, 1000000, 4000000}) {  // ns
        SCOPED_TRACE(period);
        Bench own(Bench::Thread::none);
        own.command("loadrt threads name1=servo-thread period1=" + std::to_string(period));
        wire(own);
        for (const char* line :
             {"loadrt ddt names=speed", "net offset chop.offset speed.in", "addf speed servo-thread",
              "setp chop.feed 200", "setp chop.max-offset 21", "start", "setp chop.run 1"})
            own.command(line);
        own.run(1);
        own.expect("abs(v_rate) <= 10000.1", {{"v", "speed.out"}});
        for (const double place : {2.0, 7.0, -1.0, 5.0}) {
            own.set("chop.position", place);
            own.run(2);
        }
        const std::vector<double> z = own.trace(1, {"chop.offset"}).column("chop.offset");
        EXPECT_EQ(*std::min_element(z.begin(), z.end()), -21);
    }
}

TEST_F(Chopping, AMaxOffsetThatTheStrokeDoesNotFitIntoIsRefusedAndMovesNothing) {
    start();
    bench.run(1);
    for (const double bound : {19.9, 15.0, 1.0}) {
        set("max-offset", bound);
        bench.run(0.01);
        EXPECT_EQ(get("fault-code"), 9);
        const std::vector<double> z = commands(1);
        EXPECT_NEAR(*std::min_element(z.begin(), z.end()), -20, 1 * um);
        EXPECT_LE(hardest(z), 1000 * 1.01);
    }
    set("max-offset", 500);
    bench.run(0.01);
    EXPECT_EQ(get("fault-code"), 0);
}

// Where the joint has moved, max-offset has stopped the axis short of its dead point.
TEST_F(Chopping, ALargerMaxOffsetMovesNoAxisThatRests) {
    set("max-offset", 21);
    set("stop-kind", 2);
    start();
    bench.run(1);
    set("position", 15);
    bench.run(1);
    ASSERT_EQ(get("limited-code"), 5);
    set("run", 0);
    bench.run(1);
    EXPECT_EQ(get("active"), 0);
    const double rest = get("offset");
    EXPECT_EQ(rest, -21);
    for (const double bound : {22.0, 100.0, 500.0, 25.0}) {
        set("max-offset", bound);
        for (const double z : commands(0.5)) ASSERT_EQ(z, 15 + rest);
    }
}

TEST_F(Chopping, ALowerMaxRateLeavesTheStrokeThatRunsAsItIs) {
    set("feed", 300);
    set("override", 1.5);
    set("max-acceleration", 50000);
    start();
    bench.run(1);
    for (int i = 0; i < 10; ++i) {
        bench.run(0.01 + 0.003 * i);
        set("max-rate", i % 2 ? 500 : 310);
        const std::vector<double> z = commands(0.5);
        ASSERT_NEAR(*std::min_element(z.begin(), z.end()), -20, 20 * um);
        ASSERT_NEAR(*std::max_element(z.begin(), z.end()), -8, 20 * um);
        ASSERT_LE(hardest(z), 50000 * 1.01);
    }
}

// Every setting at every phase: the region, the largest acceleration of all that was in force, and no motion
// at rest.
// A position loop lags by atan(w / Kv), w = 2 F / S, and by its delay: 2 ms and a period.
TEST_F(Chopping, MeasuredPhaseShowsTheLagInDegrees) {
    for (const double gain : {20.0, 40.0}) {
        SCOPED_TRACE(gain);
        bench.set("axis.servo-gain", gain);
        start();
        bench.run(4);
        const Table trace = bench.trace(2, {"chop.phase-lag", "chop.phase", "chop.measured-phase"});
        const std::vector<double> lags = trace.column("chop.phase-lag"), phase = trace.column("chop.phase"),
                                  measured = trace.column("chop.measured-phase");
        const double w = 2 * 60.0 / 12, expected = (std::atan(w / gain) + 0.003 * w) * 180 / 3.14159265;
        double sum = 0;
        for (std::size_t i = 0; i < lags.size(); ++i) {
            ASSERT_NEAR(lags[i], expected, 4);  // friction holds it for a moment where it turns
            ASSERT_NEAR(std::remainder(phase[i] - measured[i] - lags[i], 360), 0, 1e-9);
            sum += lags[i];
        }
        EXPECT_NEAR(sum / static_cast<double>(lags.size()), expected, 0.05 * expected);
        set("run", 0);
        bench.run(2);
        EXPECT_NEAR(get("phase-lag"), 0, 1) << "at rest";
    }
}

TEST_F(Chopping, WithoutAValidFeedbackTheMeasuredPhaseStands) {
    start();
    bench.run(2);
    bench.command("unlinkp chop.joint-feedback");
    bench.set("chop.joint-feedback", std::nan(""));
    bench.run(0.001);
    const double phase = get("measured-phase");
    for (int i = 0; i < 100; ++i) {
        bench.run(0.005);
        ASSERT_EQ(get("measured-phase"), phase);
    }
    EXPECT_EQ(get("active"), 1);
}

TEST(ChoppingInstances, TwoStrokeEachForItself) {
    Bench bench;
    bench.command("loadrt chopping names=wheel,table interlock=no sections=4");
    bench.command("loadrt sim_grinder names=z,w");
    const auto set = [&](const std::string& name, const std::string& pin, double value) {
        bench.set(name + "." + pin, value);
    };
    for (const auto& [name, axis] : {std::pair<std::string, std::string>{"wheel", "z"}, {"table", "w"}}) {
        for (const auto& [pin, value] :
             std::vector<std::pair<std::string, double>>{{"max-acceleration", 1000},
                                                         {"min-limit", -300},
                                                         {"max-limit", 300},
                                                         {"homed", 1},
                                                         {"motion-enabled", 1}})
            set(name, pin, value);
        bench.command("net " + name + "-command " + name + ".command => " + axis + ".position-cmd");
        bench.command("net " + name + "-feedback " + axis + ".position => " + name + ".joint-feedback");
        bench.command("addf " + name + ".update servo-thread");
        bench.command("addf " + axis + ".update servo-thread");
    }
    set("wheel", "upper", -8);
    set("wheel", "lower", -20);
    set("wheel", "feed", 60);
    set("table", "upper", 100);
    set("table", "lower", -100);
    set("table", "feed", 300);
    set("wheel", "run", 1);
    bench.run(0.5);
    EXPECT_EQ(bench.get("table.command"), 0);
    set("table", "run", 1);
    bench.run(5);
    Table trace = bench.trace(5, {"wheel.command", "table.command"});
    const auto ends = [&](const std::string& name) {
        const std::vector<double> z = trace.column(name + ".command");
        return std::pair(*std::min_element(z.begin(), z.end()), *std::max_element(z.begin(), z.end()));
    };
    EXPECT_NEAR(ends("wheel").first, -20, 1 * um);
    EXPECT_NEAR(ends("wheel").second, -8, 1 * um);
    EXPECT_NEAR(ends("table").first, -100, 1 * um);
    EXPECT_NEAR(ends("table").second, 100, 1 * um);
    set("table", "max-following-error", 0.01);
    bench.run(1);
    EXPECT_EQ(bench.get("table.fault-code"), 10);
    EXPECT_EQ(bench.get("table.active"), 0);
    EXPECT_EQ(bench.get("wheel.fault-code"), 0);
    trace = bench.trace(2, {"wheel.command", "table.command"});
    EXPECT_EQ(ends("table").first, ends("table").second);
    EXPECT_NEAR(ends("wheel").first, -20, 1 * um);
}

TEST_F(Chopping, EntersTheStrokeInEachWay) {
    set("by-centre", 1);
    set("centre", -10);
    set("stroke", 5);
    struct Way {
        int kind;
        std::string pin;
        double value, cycle;
    };
    constexpr double pi = 3.14159265;
    for (const Way& way : std::vector<Way>{{0, "feed", 50, pi * 5 / 50},
                                           {1, "feed", 20, 2 * 5.0 / 20},
                                           {2, "frequency", 3, 1 / 3.0},
                                           {3, "cycle-time", 0.4, 0.4}}) {
        set("speed-kind", way.kind);
        set(way.pin, way.value);
        start();
        bench.run(2);
        EXPECT_EQ(get("fault-code"), 0) << way.kind;
        EXPECT_NEAR(get("planned-cycle-time"), way.cycle, 0.001 * way.cycle) << way.kind;
        set("run", 0);
        bench.run(2);
    }
}

// An extra joint whose drive is off while the machine is.
struct ExtraJoint : ChoppingAxis {
    Random random{54};

    ExtraJoint() {
        bench.command("net on => chop.motion-enabled axis.enabled");
        bench.command("setp axis.servo-gain 20");
        turn(true);
    }
    void turn(bool on) {
        bench.set("on", on);
        bench.run(0.1);
    }
    void stroke() {
        set("run", 0);
        bench.run(0.01);
        while (get("active") != 0) bench.run(0.01);
        start();
        bench.run(random.uniform(1, 2));
        ASSERT_EQ(get("active"), 1) << get("fault-code");
    }
    // How far the axis goes when the machine is turned on, mm.
    double moved_at_on() {
        const double place = bench.get("axis.truth-position");
        bench.set("on", 1);
        double farthest = 0;
        for (const double z : bench.trace(1, {"axis.truth-position"}).column("axis.truth-position"))
            farthest = std::max(farthest, std::abs(z - place));
        return farthest;
    }
    void push(double speed, double seconds) {
        bench.set("axis.push-speed", speed);
        bench.run(seconds);
        bench.set("axis.push-speed", 0);
        bench.run(0.01);
    }
};

TEST_F(ExtraJoint, TurningOnMovesNothingWhereverItStoppedOrWasPushed) {
    for (int i = 0; i < rounds(60, 12); ++i) {
        SCOPED_TRACE(i);
        stroke();
        turn(false);
        EXPECT_LE(moved_at_on(), 1 * um) << "stopped amid a stroke";
        bench.set("on", 0);
        bench.run(random.uniform(0, 0.01));
        push(random.uniform(-300, 300), random.uniform(0, 0.4));
        EXPECT_LE(moved_at_on(), 1 * um) << "pushed";
        EXPECT_EQ(get("fault-code"), 0);
        EXPECT_EQ(get("active"), 0);
        set("go-to-end", 1);
        bench.run(5);
        EXPECT_EQ(get("at-end"), 1);
        EXPECT_EQ(get("offset"), 0);
        set("go-to-end", 0);
    }
}

TEST_F(ExtraJoint, PushedBeyondMaxOffsetItStaysThere) {
    set("max-offset", 30);
    turn(false);
    push(-300, 0.4);
    EXPECT_LE(moved_at_on(), 1 * um);
    EXPECT_NEAR(get("command"), -120, 0.1);
    stroke();
    bench.run(2);
    EXPECT_EQ(get("fault-code"), 0);
    EXPECT_GE(get("command"), -20);
}

TEST_F(ExtraJoint, AtRestAtRTurningOffAndOnLeavesItAtR) {
    stroke();
    set("run", 0);
    bench.run(3);
    turn(false);
    turn(true);
    EXPECT_EQ(get("at-end"), 1);
    EXPECT_EQ(get("status-code"), 51) << "at rest at point R";
}

TEST_F(ExtraJoint, AnEncoderThatFailsOrJumpsWhileOffMovesNothingUntilHomedAgain) {
    for (const double reads : {0.0, 1e9, std::nan("")}) {
        SCOPED_TRACE(reads);
        stroke();
        turn(false);
        bench.command("unlinkp chop.joint-feedback");
        set("joint-feedback", reads);
        bench.run(0.1);
        EXPECT_LE(moved_at_on(), 1 * um);
        bench.command("net feedback chop.joint-feedback");
        EXPECT_LE(moved_at_on(), 1 * um) << "and when it reads again";
        EXPECT_EQ(get("fault-code"), 26);
        EXPECT_EQ(get("status-code"), 53);
        EXPECT_EQ(get("place-known"), 0);
        set("run", 0);
        set("go-to-end", 1);
        bench.run(0.01);
        start();
        EXPECT_LE(moved_at_on(), 1 * um) << "no order moves it";
        set("go-to-end", 0);
        turn(false);
        set("homed", 0);
        bench.run(0.1);
        EXPECT_EQ(get("place-known"), 1) << "homing needs the drive";
        turn(true);
        set("homed", 1);
        EXPECT_LE(moved_at_on(), 1 * um);
        EXPECT_EQ(get("place-known"), 1);
    }
    stroke();
    EXPECT_EQ(get("fault-code"), 0);
}

// It stood while the axis was pushed, and jumps when the drive comes on, which has moved for some periods
// then.
TEST_F(ExtraJoint, AnEncoderThatComesBackWithTheDriveStopsItAtOnce) {
    bench.command("loadrt and2 names=permit");
    for (const char* line :
         {"unlinkp axis.enabled", "net on permit.in0", "net known chop.place-known permit.in1",
          "net drive permit.out axis.enabled", "addf permit servo-thread 2"})
        bench.command(line);
    stroke();
    turn(false);
    bench.command("unlinkp chop.joint-feedback");
    set("joint-feedback", bench.get("axis.position"));
    push(-300, 0.4);
    bench.command("net feedback chop.joint-feedback");
    EXPECT_LE(moved_at_on(), 0.1);
    EXPECT_EQ(get("fault-code"), 26);
}

TEST_F(ExtraJoint, AFeedbackThatIsNotWiredMovesNothing) {
    bench.command("unlinkp chop.joint-feedback");
    stroke();
    turn(false);
    const double place = get("command");
    turn(true);
    for (const double z : commands(1)) ASSERT_EQ(z, place);
    EXPECT_EQ(get("fault-code"), 26);
}

// With learn the command ends beyond a dead point: held there, the axis would go on to it.
TEST_F(ExtraJoint, AHomedThatIsLostBrakesWithinTheRegionHoldsAndIsAFault) {
    for (const char* line : {"setp chop.learn 1", "setp chop.jerk-time 0.01", "setp chop.run 1"})
        bench.command(line);
    bench.run(40);
    ASSERT_EQ(get("learned"), 1);
    ASSERT_GT(get("upper-correction"), 0.3);
    bound_all_periods(-21, 0.001);
    bench.expect("z >= -20.005 && z <= 0.005", {{"z", "axis.truth-position"}});
    for (int i = 0; i < rounds(40, 12); ++i) {
        SCOPED_TRACE(i);
        stroke();
        bench.run(2);
        ASSERT_LE(bench.get("axis.truth-position"), -7.995);
        set("homed", 0);
        bench.run(random.uniform(0.002, 2));
        set("homed", 1);
        bench.run(1.5);
        EXPECT_EQ(get("fault-code"), 25);
        EXPECT_EQ(get("active"), 0);
        EXPECT_LE(bench.get("axis.truth-position"), -7.995);
        const double place = get("command");
        for (const double z : commands(1)) ASSERT_EQ(z, place);
        set("run", 0);
        set("go-to-end", 1);
        bench.run(4);
        EXPECT_EQ(get("at-end"), 1);
        set("go-to-end", 0);
    }
}

TEST_F(Chopping, AnExtraJointThatIsHomedAgainIsCommandedToR) {
    start();
    bench.run(1.123);
    set("motion-enabled", 0);
    bench.run(0.5);
    set("homed", 0);
    bench.run(0.5);
    EXPECT_LT(get("command"), -7);
    bench.command("unlinkp chop.joint-feedback");
    set("joint-feedback", 0);
    bench.run(0.5);
    set("homed", 1);
    for (const double z : commands(1)) ASSERT_EQ(z, 0);
}

TEST_F(Chopping, StartsAgainFromWhereItStands) {
    start();
    bench.run(1.123);
    set("motion-enabled", 0);
    bench.run(0.1);
    set("motion-enabled", 1);
    set("run", 0);
    bench.run(0.1);
    start();
    const std::vector<double> z = commands(2);
    EXPECT_LE(hardest(z), 1000 * 1.01);
    EXPECT_GE(get("stroke-count"), 4);
    set("run", 0);
    bench.run(2);
    EXPECT_EQ(get("at-end"), 1);
}

TEST_F(Chopping, GoesToTheEndOnlyWhenAskedAfterAStopAtOnce) {
    set("stop-kind", 2);
    start();
    bench.run(1);
    set("run", 0);
    bench.run(1);
    const double place = get("offset");
    EXPECT_NE(place, 0);
    bench.run(1);
    EXPECT_EQ(get("offset"), place);
    set("go-to-end", 1);
    const std::vector<double> z = commands(1);
    EXPECT_LE(hardest(z), 1000 * 1.01);
    EXPECT_EQ(get("offset"), 0);
    EXPECT_EQ(get("at-end"), 1);
}

// Codes in the order of chopping_codes.hpp.
TEST_F(Chopping, RefusesWhatIsImpossibleAndSaysWhy) {
    struct Case {
        std::string pin;
        double value;
        int code;
    };
    set("section-1-kind", 2);
    set("section-1-from", -15);
    set("section-1-to", -12);
    const auto try_it = [&](const std::vector<Case>& cases) {
        std::vector<double> before;
        for (const Case& each : cases) {
            before.push_back(get(each.pin));
            set(each.pin, each.value);
        }
        start();
        bench.run(0.5);
        EXPECT_EQ(get("fault-code"), cases[0].code) << cases[0].pin << " = " << cases[0].value;
        EXPECT_EQ(get("offset"), 0) << cases[0].pin;
        EXPECT_EQ(get("active"), 0) << cases[0].pin;
        set("run", 0);
        for (std::size_t i = 0; i < cases.size(); ++i) set(cases[i].pin, before[i]);
        bench.run(0.01);
    };
    try_it({{"motion-enabled", 0, 1}});
    try_it({{"homed", 0, 1}});
    try_it({{"enable", 0, 1}});
    try_it({{"stop-kind", 5, 3}});
    try_it({{"upper-dwell", -1, 3}});
    try_it({{"jerk-time", 1, 3}});
    try_it({{"max-limit", -200, 3}});
    try_it({{"upper", -20, 4}});
    try_it({{"upper", -30, 4}});
    try_it({{"feed", 0, 5}});
    try_it({{"feed", -5, 5}});
    try_it({{"feed", 501, 5}});
    try_it({{"speed-kind", 5, 5}});
    try_it({{"section-0-kind", 2, 6}, {"section-0-from", -13, 0}, {"section-0-to", -10, 0}});
    try_it({{"section-1-ratio", 0, 6}});
    try_it({{"refuse-slower", 1, 7}, {"feed", 100, 0}});
    try_it({{"lead", 0.01, 8}});
    try_it({{"lead", 0.03, 8}, {"jerk-time", 0.1, 0}});
    try_it({{"min-limit", -19, 9}});
    try_it({{"max-offset", 15, 9}});
    try_it({{"taper", 6, 9}});
    start();
    bench.run(0.5);
    EXPECT_EQ(get("fault-code"), 0);
    EXPECT_EQ(get("active"), 1);
}

TEST_F(Chopping, InvalidSettingsLeaveTheLastGoodSetInForce) {
    start();
    bench.run(1);
    bench.expect("z >= -20.000001 && z <= -7.999999", {{"z", "chop.command"}});
    set("feed", 1e9);
    set("upper-dwell", 1);
    bench.run(2);
    EXPECT_EQ(get("fault-code"), 5);
    EXPECT_NEAR(get("actual-cycle-time"), 0.628, 0.002);
    set("upper-dwell", 0);
    set("feed", 30);
    bench.run(4);
    EXPECT_EQ(get("fault-code"), 0);
    EXPECT_NEAR(get("actual-cycle-time"), 1.257, 0.002);
}

// Each stroke runs as it was planned, whatever is set meanwhile.
TEST_F(Chopping, AnAccelerationALeadOrAJerkTimeThatChangesAtAnyPhaseBreaksNoLimit) {
    Random random(7);
    set("jerk-time", 0.02);
    set("lead", 0.004);
    start();
    bench.run(1.5);
    bench.expect("z >= -20.05 && z <= -7.95", {{"z", "chop.command"}});
    const double accelerations[] = {1000, 10, 300, 1500, 50, 1000}, leads[] = {0, 0.01, 0.004},
                 times[] = {0.004, 0.02, 0.1};
    for (int i = 0; i < rounds(60, 12); ++i) {
        SCOPED_TRACE(i);
        switch (random.index(3)) {
            case 0: set("max-acceleration", accelerations[random.index(6)]); break;
            case 1: set("lead", leads[random.index(3)]); break;
            default: set("jerk-time", times[random.index(3)]); break;
        }
        EXPECT_LE(hardest(commands(random.uniform(0.05, 2))), 1500 * (1 + 2 * 0.004 / 0.02) * 1.01);
    }
}

TEST_F(Chopping, GoToEndKeepsTheRuleOfTheLead) {
    set("stop-kind", 1);
    start();
    bench.run(1);
    set("run", 0);
    bench.run(1);
    set("lead", 0.02);
    bench.run(0.01);
    EXPECT_EQ(get("fault-code"), 8);
    set("go-to-end", 1);
    EXPECT_LE(hardest(commands(2)), 1000 * 1.01);
    EXPECT_EQ(get("at-end"), 1);
}

TEST_F(Chopping, ShiftsItsRegionByCommandAndWhenAnAxisCrossesEitherWay) {
    start();
    bench.run(1);
    set("upper", -4);
    set("lower", -12);
    bench.run(2);
    EXPECT_LE(get("measured-upper"), -7) << "not before the command";
    set("shift", 1);
    std::vector<double> z = commands(2);
    EXPECT_LE(hardest(z), 1000 * 1.01);
    EXPECT_NEAR(*std::min_element(z.begin() + 1000, z.end()), -12, 0.001);
    EXPECT_NEAR(*std::max_element(z.begin() + 1000, z.end()), -4, 0.001);

    set("shift-at-crossing", 1);
    set("crossing-at", 50);
    set("crossing-position", 40);
    set("upper", -1);
    bench.run(1);
    set("crossing-position", 60);
    bench.run(2);
    EXPECT_NEAR(highest(), -1, 0.001);
    set("upper", -6);
    bench.run(1);
    EXPECT_NEAR(highest(), -1, 0.001);
    set("crossing-position", 49);
    bench.run(2);
    EXPECT_NEAR(highest(), -6, 0.001);

    set("upper", -13);
    set("shift", 0);
    bench.run(2);
    EXPECT_EQ(get("fault-code"), 4) << "below the lower dead point";
    EXPECT_NEAR(highest(), -6, 0.001);
}

TEST_F(Chopping, TheStrokeStaysWhenTheJointMovesAndEndsAtTheNewPlace) {
    bench.command("loadrt limit3 names=joint");
    bench.command("setp joint.maxv 50");
    bench.command("setp joint.maxa 500");
    bench.command("net place joint.out => chop.position");
    bench.command("addf joint servo-thread 1");
    start();
    bench.run(1);
    bench.expect("z >= -20.000001 && z <= -7.999999", {{"z", "chop.command"}});
    bench.set("joint.in", -5);
    bench.run(2);
    EXPECT_EQ(get("limited"), 0);
    bench.set("joint.in", 0);
    bench.run(1);
}

// At a dead point, or at R by way of one; only an emergency hold stands amid a stroke.
TEST_F(Chopping, HoldsWhereItsKindSaysAtAnyPhaseAndGoesOn) {
    Random random(21);
    bound_all_periods(-20, 0);
    start();
    bench.run(1);
    for (const std::string pin : {"feed-hold", "override", "emergency-hold"})
        for (const int kind : {0, 1})
            for (int i = 0; i < 12; ++i) {
                SCOPED_TRACE(pin + " " + std::to_string(kind) + " " + std::to_string(i));
                const bool emergency = pin == "emergency-hold", by_override = pin == "override";
                set("hold-kind", kind);
                bench.run(random.uniform(0.6, 1.3));
                set(pin, by_override ? 0 : 1);
                bench.run(emergency ? 0.1 : kind == 0 ? 1.4 : 0.33);  // a stroke is 0.314 s
                EXPECT_EQ(get("held"), 1);
                const double place = get("command");
                if (emergency) {
                    EXPECT_GE(place, -20);
                    EXPECT_LE(place, -8);
                } else if (kind == 0) {
                    EXPECT_EQ(place, 0);
                } else {
                    EXPECT_LT(std::min(std::abs(place + 8), std::abs(place + 20)), nm);
                }
                bench.run(random.uniform(0, 0.3));
                EXPECT_EQ(get("command"), place);
                set(pin, by_override ? 1 : 0);
                bench.run(1.6);
                EXPECT_EQ(get("held"), 0);
                EXPECT_EQ(get("stroking"), 1);
            }
    bench.run(1);
    EXPECT_NEAR(get("actual-cycle-time"), 0.628, 0.002);
}

// interlock holds a function that has not passed plumb commission, but for a trial: while somebody presses.
TEST(ChoppingOnTrial, StandsAtOnceWhenTheTrialIsOverAndTheNextOneGoesToR) {
    Random random(23);
    Bench bench;
    wire(bench, "sim_grinder", "yes");
    for (const char* line :
         {"loadrt interlock names=interlock stages=0", "net permit interlock.function-permit-0 chop.permit",
          "net state chop.state interlock.function-state-0", "setp interlock.function-services-0 0",
          "setp interlock.function-switch-0 1", "setp interlock.motion-enabled 1",
          "setp interlock.all-homed 1", "setp interlock.commissioning 1",
          "addf interlock.update servo-thread"})
        bench.command(line);
    bool beat = false;
    const auto press = [&](double seconds) {
        bench.set("interlock.trial-function", 0);
        for (double time = 0; time < seconds; time += 0.1) {
            bench.set("interlock.trial-beat", beat = !beat);
            bench.run(0.1);
        }
    };
    for (int i = 0; i < 8; ++i) {
        SCOPED_TRACE(i);
        press(0.3);
        bench.set("chop.run", 1);
        press(1);
        EXPECT_EQ(bench.get("chop.active"), 1);
        press(random.uniform(0.1, 0.6));
        bench.run(random.uniform(0.6, 0.7));  // nobody presses any more
        const double place = bench.get("chop.command");
        EXPECT_GE(place, -20);
        EXPECT_LE(place, -8);
        bench.set("chop.run", 0);
        bench.run(2);
        EXPECT_EQ(bench.get("chop.command"), place);
        bench.set("interlock.trial-function", -1);
        bench.run(0.1);
        press(2);
        EXPECT_EQ(bench.get("chop.command"), 0);
        bench.set("interlock.trial-function", -1);
        bench.run(0.1);
    }
}

// Also the kind, while it stands or is on its way there; released at any time.
TEST_F(Chopping, NoHoldBreaksALimitWhateverChangesMeanwhile) {
    Random random(22);
    bound_all_periods(-20.5, 0.5);
    set("jerk-time", 0.01);
    set("learn", 1);
    start();
    bench.run(30);
    for (int i = 0; i < rounds(300, 60); ++i) {
        SCOPED_TRACE(i);
        const double parts[] = {0, 0.5, 1};
        switch (random.index(6)) {
            case 0:
            case 1: set("feed-hold", random.index(2)); break;
            case 2: set("emergency-hold", random.index(4) == 0); break;
            case 3: set("hold-kind", random.index(2)); break;
            case 4: set("override", parts[random.index(3)]); break;
            case 5: set("run", random.index(3) > 0); break;
        }
        bench.run(random.uniform(0.01, 0.7));
        if (HasFailure()) return;
    }
    EXPECT_EQ(get("fault-code"), 0);
    set("run", 0);
    for (const char* pin : {"feed-hold", "emergency-hold"}) set(pin, 0);
    set("override", 1);
    bench.run(4);
    EXPECT_EQ(get("at-end"), 1);
}

TEST_F(Chopping, AHoldKindThatIsNoneIsRefused) {
    set("hold-kind", 2);
    start();
    bench.run(0.5);
    EXPECT_EQ(get("fault-code"), 3);
    EXPECT_EQ(get("active"), 0);
}

TEST_F(Chopping, GivesInfeedPulsesButNotInSparkOut) {
    bench.command("loadrt updown names=infeeds");
    bench.command("net upper-pulse chop.upper-pulse => infeeds.countup");
    bench.command("addf infeeds servo-thread");
    set("strokes", 6);
    set("spark-out", 4);
    start();
    bench.run(0.01);
    bench.expect("s == 0 || p == 0", {{"s", "chop.sparking-out"}, {"p", "chop.upper-pulse"}});
    bench.run(8);
    EXPECT_EQ(get("at-end"), 1);
    EXPECT_EQ(get("stroke-count"), 10);
    EXPECT_EQ(bench.get("infeeds.count"), 3);
}

TEST_F(Chopping, AJerkTimeBoundsTheJerkAndALeadTheOutput) {
    set("jerk-time", 0.04);
    set("lead", 0.01);
    set("max-output-accel", 1600);
    start();
    const std::vector<double> z = commands(3);
    EXPECT_EQ(get("fault-code"), 0);
    EXPECT_LE(hardest(z), 1600 * 1.01);
    EXPECT_GT(hardest(z), 600) << "the lead adds to the acceleration";
    set("lead", 0);
    set("run", 0);
    bench.run(2);
    start();
    const std::vector<double> y = commands(2);
    double jerk = 0;
    for (std::size_t i = 3; i < y.size(); ++i)
        jerk = std::max(jerk, std::abs(y[i] - 3 * y[i - 1] + 3 * y[i - 2] - y[i - 3]) / (dt * dt * dt));
    EXPECT_LE(jerk, 2 * 1000 / 0.04 * 1.01);
    EXPECT_LE(hardest(y), 1000 * 1.01);
}

TEST_F(Chopping, ASectionInHeightsSlowsTheStrokeThere) {
    set("section-2-kind", 2);
    set("section-2-from", -16);
    set("section-2-to", -12);
    set("section-2-ratio", 0.25);
    start();
    bench.run(2);
    bench.expect("z < -16 || z > -12 || abs(v) <= 15.1", {{"z", "chop.command"}, {"v", "chop.velocity"}});
    bench.run(2);
    EXPECT_GT(get("planned-cycle-time"), 1);
    EXPECT_EQ(get("limited"), 0);
}

// Learned ends make the stroke longer, and no cycle.
TEST_F(Chopping, ASetCycleTimeIsKeptToAMicrosecondInTheMean) {
    for (const char* line : {"setp chop.learn 1", "setp axis.servo-gain 20", "setp chop.jerk-time 0.01",
                             "setp chop.speed-kind 3", "setp chop.cycle-time 0.6283"})
        bench.command(line);
    start();
    bench.run(40);
    ASSERT_EQ(get("learned"), 1);
    EXPECT_GT(get("upper-correction"), 0.1);
    const auto next_lower = [this] {  // s, exact to less than a period by the speed at the middle
        while (get("velocity") > -10 || get("command") < -14) bench.run(0.001);
        double before = get("command");
        while (get("command") >= -14) before = get("command"), bench.run(0.001);
        return bench.time() - 0.001 * (-14 - get("command")) / (before - get("command"));
    };
    const double begin = next_lower(), strokes = get("stroke-count");
    bench.run(rounds(1200, 300));
    const double end = next_lower(), cycles = (get("stroke-count") - strokes) / 2;
    EXPECT_NEAR((end - begin) / cycles, 0.6283, 1e-6);
}

TEST_F(Chopping, ACycleTimeWithSectionsAndDwellsIsThatOfTheWholeCycle) {
    set("speed-kind", 4);
    set("cycle-time", 2);
    set("lower-dwell", 0.1);
    set("section-0-kind", 2);
    set("section-0-from", -16);
    set("section-0-to", -10);
    set("section-0-ratio", 0.5);
    start();
    bench.run(12);
    EXPECT_NEAR(get("planned-cycle-time"), 2, 0.002);
    EXPECT_NEAR(get("actual-cycle-time"), 2, 0.003);
    set("section-0-ratio", 1);
    bench.run(12);
    EXPECT_NEAR(get("actual-cycle-time"), 2, 0.003);
    set("cycle-time", 0.2);
    const std::vector<double> z = commands(8);
    EXPECT_LE(hardest(z), 1000 * 1.01);
    EXPECT_EQ(get("limited-code"), 1) << "max-acceleration does not permit it";
}

TEST_F(Chopping, HasThePinsOfItsSections) {
    bench.command("unloadrt chopping");
    bench.command("loadrt chopping names=none,two sections=0,2");
    EXPECT_ANY_THROW(bench.get("none.section-0-kind"));
    for (const char* part : {"kind", "from", "to", "ratio"}) bench.get(std::string("two.section-1-") + part);
    EXPECT_ANY_THROW(bench.get("two.section-2-kind"));
}

TEST_F(Chopping, ASectionThatIsTooFastForTheAccelerationIsReported) {
    set("section-3-kind", 1);
    set("section-3-from", 80);
    set("section-3-to", 100);
    set("section-3-ratio", 3);
    start();
    const std::vector<double> z = commands(3);
    EXPECT_EQ(get("limited-code"), 1);
    EXPECT_LE(hardest(z), 1000 * 1.01);
}

// Drawn axes: friction, delay, backlash, all gains.
TEST_F(Chopping, LearnsTheDeadPointsWithoutPassingThem) {
    const int axes = rounds(8, 2);
    for (int seed = 1; seed <= axes; ++seed) {
        SCOPED_TRACE(seed);
        Bench own;
        wire(own);
        for (const char* line :
             {"setp axis.seed 0", "setp chop.upper 22", "setp chop.feed 80", "setp chop.lower -8",
              "setp chop.max-acceleration 500", "setp chop.jerk-time 0.01", "setp chop.learn 1",
              "setp axis.load-resonance 0"})
            own.command(line);
        own.set("axis.seed", seed);
        own.set("chop.run", 1);
        own.run(4);
        own.expect("u <= 22.005 && l >= -8.005", {{"u", "axis.truth-upper"}, {"l", "axis.truth-lower"}});
        for (int i = 0; i < 100 && own.get("chop.speed-factor") < 1; ++i) own.run(0.5);
        ASSERT_EQ(own.get("chop.speed-factor"), 1);
        own.run(9 * own.get("chop.planned-cycle-time") + 2);
        own.expect("abs(u - 22) <= 0.002 && abs(l + 8) <= 0.002",
                   {{"u", "axis.truth-upper"}, {"l", "axis.truth-lower"}});
        own.run(10);
        EXPECT_EQ(own.get("chop.learned"), 1);
        EXPECT_EQ(own.get("chop.fault-code"), 0);
    }
}

// The command of a learned stroke is beyond its dead points, and leads; its acceleration has a limit of its
// own.
TEST_F(Chopping, LearnsWithALeadWithinTheLargestAccelerationOfTheOutput) {
    for (const char* line :
         {"setp chop.learn 1", "setp chop.jerk-time 0.02", "setp chop.lead 0.012",
          "setp chop.section-0-kind 1", "setp chop.section-0-to 360", "setp chop.section-0-ratio 2",
          "setp chop.max-output-accel 2201", "setp axis.servo-gain 25"})
        bench.command(line);
    start();
    bench.run(4);
    bench.expect("u <= -7.995 && l >= -20.005", {{"u", "axis.truth-upper"}, {"l", "axis.truth-lower"}});
    for (int i = 0; i < 60 && get("speed-factor") < 1; ++i) bench.run(0.5);
    bench.run(10);
    EXPECT_EQ(get("learned"), 1);
    EXPECT_EQ(get("fault-code"), 0);
    EXPECT_NEAR(bench.get("axis.truth-upper"), -8, 2 * um);
    EXPECT_NEAR(bench.get("axis.truth-lower"), -20, 2 * um);
    const std::vector<double> z = commands(4);
    EXPECT_GT(*std::max_element(z.begin(), z.end()), -7.95) << "learned ends lie beyond";
    EXPECT_LE(hardest(z), 2200 * 1.01);
    EXPECT_GT(hardest(z), 1050) << "the lead adds to the acceleration";
}

TEST_F(Chopping, ALearnedStrokeWithSectionsKeepsTheAcceleration) {
    for (const char* line :
         {"setp chop.learn 1", "setp axis.servo-gain 20", "setp chop.section-0-kind 2",
          "setp chop.section-0-from -16", "setp chop.section-0-to -11", "setp chop.section-0-ratio 0.4",
          "setp chop.section-1-kind 4", "setp chop.section-1-from -20", "setp chop.section-1-to -16",
          "setp chop.section-1-ratio 3"})
        bench.command(line);
    start();
    double worst = 0;
    for (int i = 0; i < 60; ++i) worst = std::max(worst, hardest(commands(1)));
    EXPECT_EQ(get("learned"), 1);
    EXPECT_GT(get("upper-correction"), 0.1);
    EXPECT_LE(worst, 1000 * 1.01);
}

struct Learned : Chopping {
    Learned() {
        bench.command("setp axis.servo-gain 20");
        set("learn", 1);
        set("jerk-time", 0.01);
        start();
        bench.run(30);
    }
};

TEST_F(Learned, AnAxisThatGoesBeyondStartsLearningAgain) {
    ASSERT_EQ(get("learned"), 1);
    bench.set("axis.servo-gain", 24);
    bench.run(4);
    EXPECT_EQ(get("fault-code"), 13);
    EXPECT_LT(get("speed-factor"), 1);
    bench.run(3);
    bench.expect("u <= -7.999 && l >= -20.001", {{"u", "axis.truth-upper"}, {"l", "axis.truth-lower"}});
    bench.run(30);
    EXPECT_EQ(get("learned"), 1);
}

// The way to R ends amid the stroke before it goes on: its dead point is not one of two strokes.
TEST_F(Learned, AnEndAtRSpoilsNoDeadPoint) {
    ASSERT_EQ(get("learned"), 1);
    const double lower = get("row-lower-offset"), error = get("lower-error");
    bench.expect("z >= -20.005", {{"z", "axis.truth-position"}});
    for (int i = 0; i < 6; ++i) {
        SCOPED_TRACE(i);
        while (get("velocity") > -50) bench.run(0.002);
        set(i % 2 == 0 ? "run" : "go-to-end", i % 2);
        bench.run(4);
        EXPECT_EQ(get("at-end"), 1);
        EXPECT_NEAR(get("row-lower-offset"), lower, 2 * um);
        EXPECT_NEAR(get("lower-error"), error, 2 * um);
        set("run", 0);
        set("go-to-end", 0);
        bench.run(0.01);
        start();
        bench.run(3);
        EXPECT_EQ(get("fault-code"), 0);
        EXPECT_EQ(get("speed-factor"), 1);
        EXPECT_LE(bench.get("axis.truth-upper"), -7.995);
    }
}

// A drive with 1.1 times the force of the stroke cannot stop as quickly as it turns.
TEST_F(Chopping, ADriveThatHardlyHasTheForceStopsAtRAndNotBehindIt) {
    const double stroke = 55.146, acceleration = 1902.8;
    for (const double end : {1.4 * stroke, 0.0}) {
        SCOPED_TRACE(end);
        Bench own;
        wire(own, "sim_elastic_axis");
        for (const char* line :
             {"setp chop.max-feed 2000", "setp chop.max-rate 2000", "setp chop.max-acceleration 20000",
              "setp chop.max-output-accel 100000", "setp chop.max-correction 8", "setp chop.jerk-time 0.02",
              "setp chop.learn 1", "setp chop.min-limit -300", "setp chop.max-limit 500", "setp chop.lower 0",
              "setp axis.seed 71010"})
            own.command(line);
        own.set("axis.force-limit", 1.1 * acceleration);
        own.set("chop.position", end);
        own.set("chop.upper", stroke);
        own.set("chop.feed", std::sqrt(acceleration * stroke / 2));
        own.run(1);
        own.set("chop.run", 1);
        own.run(40);
        ASSERT_EQ(own.get("chop.learned"), 1);
        own.expect("z > -0.006 && z < " + std::to_string(std::max(end, stroke) + 0.006),
                   {{"z", "axis.truth-position"}});
        for (int i = 0; i < 4; ++i) {
            own.run(1 + 0.13 * i);
            own.set("chop.run", 0);
            own.run(6);
            EXPECT_EQ(own.get("chop.at-end"), 1);
            EXPECT_NEAR(own.get("axis.truth-position"), end, 0.005);
            own.set("chop.run", 1);
        }
        EXPECT_EQ(own.get("chop.fault-code"), 0);
    }
}

// It turns Ti a / Kv beyond its command, 1.2 mm at the speed of the first strokes: more than the inset, and
// more than max-correction.
TEST_F(Chopping, APositionLoopWithAnIntegralPassesNoDeadPointInItsFirstStrokes) {
    Bench own;
    wire(own, "sim_elastic_axis");
    for (const char* line :
         {"setp chop.max-feed 2000", "setp chop.max-rate 2000", "setp chop.max-acceleration 20000",
          "setp chop.max-output-accel 100000", "setp chop.jerk-time 0.02", "setp chop.learn 1",
          "setp chop.min-limit -300", "setp chop.max-limit 500", "setp chop.lower 0", "setp chop.upper 60",
          "setp axis.servo-gain 20", "setp axis.integral-time 0.3", "setp axis.feed-forward 0"})
        own.command(line);
    own.set("chop.feed", std::sqrt(2000 * 60 / 2));
    own.run(0.1);
    own.expect("z > -0.005 && z < 60.005", {{"z", "axis.truth-position"}});
    own.set("chop.run", 1);
    while (own.get("chop.stroke-count") < 12) own.run(0.1);
    EXPECT_EQ(own.get("chop.fault-code"), 0);
    EXPECT_GT(own.get("chop.speed-factor"), 0.21);
}

// Its turn falls from 0.5 mm beyond to 0.1 inside as the speed rises, and moves with both ends.
TEST_F(Chopping, APositionLoopWithAnIntegralIsLearnedAtFullSpeedAndPassesNoDeadPoint) {
    Bench own;
    wire(own, "sim_elastic_axis");
    for (const char* line :
         {"setp chop.max-feed 2000", "setp chop.max-rate 2000", "setp chop.max-acceleration 20000",
          "setp chop.max-output-accel 100000", "setp chop.jerk-time 0.02", "setp chop.learn 1",
          "setp chop.min-limit -300", "setp chop.max-limit 500", "setp chop.lower 0",
          "setp chop.upper 11.604", "setp chop.feed 93.68", "setp axis.seed 81012",
          "setp axis.force-limit 2404", "setp axis.friction 216", "setp axis.servo-gain 43.37",
          "setp axis.integral-time 0.1508", "setp axis.feed-forward 0"})
        own.command(line);
    own.run(0.1);
    own.expect("z > -0.005 && z < 11.609", {{"z", "axis.truth-position"}});
    own.set("chop.run", 1);
    own.run(25);
    EXPECT_EQ(own.get("chop.learned"), 1);
    EXPECT_EQ(own.get("chop.fault-code"), 0);
}

// A feed-forward that is too large takes an axis beyond any place where its command stops.
TEST_F(Learned, AnAxisThatPassesRIsToldAndComesSlowerTheNextTime) {
    ASSERT_EQ(get("learned"), 1);
    const auto end = [this](double forward) {
        set("run", 0);
        while (get("offset") < -3) bench.run(0.01);
        bench.set("axis.feed-forward", forward);
        const double acceleration = -get("acceleration");
        double farthest = -1;
        for (const double z : bench.trace(6, {"axis.truth-position"}).column("axis.truth-position"))
            farthest = std::max(farthest, z);
        EXPECT_EQ(get("at-end"), 1);
        EXPECT_EQ(farthest > 0.005, forward > 1) << farthest;
        EXPECT_EQ(get("fault-code"), forward > 1 ? 24 : 0);
        bench.set("axis.feed-forward", 0);
        bench.run(1);
        start();
        bench.run(3);
        EXPECT_EQ(get("fault-code"), 0);
        return acceleration;
    };
    const double first = end(0), second = end(1.25);
    EXPECT_NEAR(second, 1.6 * first, 0.01 * first);
    const double third = end(0);
    EXPECT_LT(third, second / 2);
    EXPECT_NEAR(end(0), 1.6 * third, 0.01 * third);
}

// The way to R, a hold and an end at a dead point are no lag of the axis.
TEST_F(Learned, NoEndAndNoHoldIsTakenForALackOfForce) {
    ASSERT_EQ(get("learned"), 1);
    bench.expect("f == 0", {{"f", "chop.fault-code"}});
    for (int i = 0; i < 40; ++i) {
        bench.run(0.3 + 0.037 * i);
        set("stop-kind", i % 3);
        set(i % 4 == 3 ? "feed-hold" : "run", i % 4 == 3 ? 1 : 0);
        bench.run(1.5);
        set("feed-hold", 0);
        set("run", 0);
        bench.run(0.2);
        while (get("active")) bench.run(0.01);
        set("run", 1);
        bench.run(0.01);
    }
}

// Axes that turn an eighth of the stroke inside, or that a full feed-forward takes beyond where the command
// stands or leaves slowly.
TEST_F(Chopping, NothingThatAnOperatorDoesTakesAQuickAxisBeyondOrIntoAFault) {
    struct Axis {
        double gain, forward;
    };
    for (const Axis& axis : {Axis{22, 0}, Axis{30, 0.5}, Axis{50, 1}}) {
        SCOPED_TRACE(axis.gain);
        Bench own;
        wire(own);
        for (const char* line :
             {"setp chop.feed 130", "setp chop.max-feed 500", "setp chop.max-rate 500",
              "setp chop.max-acceleration 10000", "setp chop.max-output-accel 100000",
              "setp chop.max-correction 8", "setp chop.jerk-time 0.02", "setp chop.learn 1",
              "setp axis.force-limit 20000", "setp axis.friction 0.1"})
            own.command(line);
        own.set("axis.servo-gain", axis.gain);
        own.set("axis.feed-forward", axis.forward);
        own.set("chop.run", 1);
        own.run(25);
        ASSERT_EQ(own.get("chop.learned"), 1);
        own.expect("z <= -7.995 && z >= -20.005", {{"z", "axis.truth-position"}});
        own.expect("f == 0", {{"f", "chop.fault-code"}});
        const struct {
            const char* pin;
            double value, then;
        } changes[] = {{"chop.override", 0.5, 1},    {"chop.override", 0.2, 1},     {"chop.feed-hold", 1, 0},
                       {"chop.lower-dwell", 0.3, 0}, {"chop.upper-dwell", 0.05, 0}, {"chop.feed", 100, 130},
                       {"chop.exact-stop", 0.01, 0}, {"chop.override", 0.9, 1}};
        for (const auto& [pin, value, then] : changes)
            for (const double now : {value, then}) {
                own.set(pin, now);
                own.run(2.5);
            }
        EXPECT_EQ(own.get("chop.learned"), 1);
    }
}

TEST_F(Learned, AJamAndADriveWithoutForceAreToldInTheStroke) {
    ASSERT_EQ(get("learned"), 1);
    const double stroke = 3.1416 * 12 / 60 / 2;
    for (const bool jam : {true, false}) {
        bench.run(jam ? 0.4 : 0.55);
        bench.set(jam ? "axis.friction" : "axis.force-limit", jam ? 20 : 200);
        const double begin = bench.time();
        while (get("fault-code") != 21 && bench.time() < begin + 5) bench.run(0.005);
        EXPECT_EQ(get("fault-code"), 21);
        EXPECT_LE(bench.time() - begin, stroke);
        bench.run(1);
        EXPECT_EQ(get("active"), 0);
        bench.set(jam ? "axis.friction" : "axis.force-limit", jam ? 0.15 : 5000);
        bench.run(1);
        set("run", 0);
        bench.run(0.5);
        start();
        bench.run(3);
        EXPECT_EQ(get("fault-code"), 0) << "strokes again";
    }
}

TEST_F(Learned, AnAxisThatChangesOverTimeIsReported) {
    ASSERT_EQ(get("learned"), 1);
    EXPECT_LT(get("drift"), 0.001);
    set("max-drift", 0.002);
    bench.set("axis.servo-gain", 19);
    bench.run(30);
    EXPECT_GT(get("drift"), 0.002);
    EXPECT_EQ(get("fault-code"), 16);
    EXPECT_NEAR(get("upper-error"), 0, 0.002) << "corrected nevertheless";
}

// The friction of guides that run dry, on a drive that has hardly enough force.
TEST_F(Chopping, FrictionThatGrowsOverWeeksIsReported) {
    for (const char* line : {"setp chop.learn 1", "setp chop.jerk-time 0.01", "setp chop.max-drift 0.05",
                             "setp axis.servo-gain 20", "setp axis.force-limit 800"})
        bench.command(line);
    start();
    bench.run(30);
    ASSERT_EQ(get("learned"), 1);
    double before = get("drift");
    for (const double friction : {0.4, 0.5, 0.6}) {
        EXPECT_EQ(get("fault-code"), 0) << friction;
        for (int i = 9; i >= 0; --i) {
            bench.set("axis.friction", friction - 0.01 * i);
            bench.run(4);
        }
        EXPECT_GT(get("drift"), 2 * before) << friction;
        EXPECT_NEAR(bench.get("axis.truth-upper"), -8, 2 * um) << "corrected nevertheless";
        before = get("drift");
    }
    EXPECT_EQ(get("fault-code"), 16);
}

TEST_F(Chopping, DeadPointsThatDoNotConvergeAreReported) {
    for (const char* line : {"setp chop.learn 1", "setp chop.jerk-time 0.01", "setp axis.resolution 0.02"})
        bench.command(line);
    start();
    bench.run(30);
    EXPECT_EQ(get("speed-factor"), 1);
    EXPECT_EQ(get("fault-code"), 0) << "not yet 30 cycles";
    bench.run(20);
    EXPECT_EQ(get("learned"), 0);
    EXPECT_EQ(get("fault-code"), 14);
    EXPECT_EQ(get("active"), 1) << "it strokes on";
}

TEST_F(Chopping, AScaleOfAnotherUnitStopsTheStrokeWhileItIsSlow) {
    for (const char* line :
         {"loadrt scale names=wrong", "unlinkp chop.joint-feedback", "setp wrong.gain 1.3",
          "net feedback => wrong.in", "net wrong-feedback wrong.out => chop.joint-feedback",
          "addf wrong servo-thread", "setp chop.learn 1", "setp chop.jerk-time 0.01"})
        bench.command(line);
    start();
    bench.expect("f == 0.2", {{"f", "chop.speed-factor"}});
    bench.run(15);
    EXPECT_EQ(get("fault-code"), 12);
    EXPECT_EQ(get("active"), 0);
}

TEST_F(Learned, WhatItLearnedIsShownAndRestored) {
    ASSERT_EQ(get("rows"), 1);
    EXPECT_NEAR(get("row-upper-offset"), get("upper-correction"), 0.001);
    Bench later;
    wire(later);
    later.set("axis.servo-gain", 20);
    for (const char* field : {"lower", "upper", "speed", "acceleration", "sections", "lower-offset",
                              "upper-offset", "lower-first", "upper-first", "reversal", "proven",
                              "lower-slow", "upper-slow", "lower-shown", "upper-shown"})
        later.set(std::string("chop.restore-") + field, get(std::string("row-") + field));
    later.set("chop.restore", 1);
    later.run(0.01);
    EXPECT_EQ(later.get("chop.restores"), 1);
    for (const char* line : {"setp chop.learn 1", "setp chop.jerk-time 0.01", "setp chop.run 1"})
        later.command(line);
    later.run(0.5);
    EXPECT_NEAR(later.get("chop.speed-factor"), std::sqrt(0.671), 0.001) << "confirmed first";
    later.expect("z <= 0.001 && z >= -20.002", {{"z", "axis.truth-position"}});
    while (later.get("chop.stroke-count") < 9) later.run(0.01);
    later.expect("abs(u + 8) <= 0.002 && abs(l + 20) <= 0.002",
                 {{"u", "axis.truth-upper"}, {"l", "axis.truth-lower"}});  // after three cycles
    EXPECT_EQ(later.get("chop.speed-factor"), 1);
    EXPECT_NEAR(later.get("chop.upper-correction"), get("upper-correction"), 1 * um);
    later.run(8);
    EXPECT_EQ(later.get("chop.learned"), 1);
    EXPECT_EQ(later.get("chop.row-upper-first"), get("row-upper-first"));
}

TEST_F(Learned, ALowerOverrideNeverTakesTheAxisBeyond) {
    ASSERT_EQ(get("learned"), 1);
    bench.expect("u <= -7.99 && l >= -20.01", {{"u", "axis.truth-upper"}, {"l", "axis.truth-lower"}});
    const double before = get("row-upper-offset");
    set("override", 0.5);
    bench.run(8);
    EXPECT_EQ(get("row-upper-offset"), before) << "not learned at another speed";
    for (const double part : {0.5, 0.1, 1.0, 0.3, 1.0}) {
        set("override", part);
        bench.run(3);
    }
    set("feed-hold", 1);
    bench.run(1);
    EXPECT_GE(bench.get("axis.truth-position"), -20.001);
    EXPECT_LE(bench.get("axis.truth-position"), -7.999);
}

// A correction holds for the command that was in force when it was learned.
TEST_F(Learned, AnotherJerkTimeOrLeadIsLearnedForItself) {
    ASSERT_EQ(get("learned"), 1);
    bench.expect("z >= -20.005", {{"z", "axis.truth-position"}});
    set("max-output-accel", 10000);
    for (const auto& [pin, value] :
         {std::pair{"jerk-time", 0.03}, {"lead", 0.01}, {"jerk-time", 0.06}, {"lead", 0}}) {
        set(pin, value);  // while it strokes, and in force with the next start
        bench.run(20);
        set("run", 0);
        bench.run(2);
        start();
        bench.run(25);
        EXPECT_EQ(get("learned"), 1) << pin << " " << value;
        EXPECT_EQ(get("fault-code"), 0) << pin << " " << value;
    }
}

TEST_F(Learned, NoOverrideAndNoWayFromRNeedsMoreThanTheJointHasProven) {
    ASSERT_EQ(get("learned"), 1);
    bench.set("axis.force-limit", 900);  // for 600 mm/s2 and friction
    bench.run(3);
    ASSERT_EQ(get("fault-code"), 0);
    bench.expect("z >= -20.005", {{"z", "axis.truth-position"}});
    set("override", 1.5);
    bench.run(10);
    EXPECT_EQ(get("fault-code"), 0);
    set("override", 1);
    bench.run(3);
    for (const double end : {-9.0, -14.0, -19.0}) {
        set("run", 0);
        bench.run(3);
        set("position", end);
        bench.run(3);
        start();
        bench.run(8);
        EXPECT_EQ(get("fault-code"), 0) << end;
        EXPECT_EQ(get("learned"), 1) << end;
    }
}

TEST_F(Learned, AnotherRegionFeedOrSectionIsAtFullSpeedAtOnceAndSoonLearned) {
    ASSERT_EQ(get("learned"), 1);
    bench.expect("z >= -20.005", {{"z", "axis.truth-position"}});
    const auto stroke = [this](int cycles, const std::vector<std::pair<const char*, double>>& settings) {
        set("run", 0);
        bench.run(3);
        for (const auto& [pin, value] : settings) set(pin, value);
        start();
        bench.run(0.1);
        while (get("stroke-count") < 2 * cycles + 1) {
            bench.run(0.01);
            EXPECT_EQ(get("speed-factor"), 1);
        }
        bench.run(0.1);
        EXPECT_NEAR(bench.get("axis.truth-lower"), get("lower"), 2 * um) << settings[0].first;
        EXPECT_NEAR(bench.get("axis.truth-upper"), get("upper"), 2 * um) << settings[0].first;
        while (get("stroke-count") < 2 * cycles + 4) bench.run(0.01);
        EXPECT_EQ(get("learned"), 1) << settings[0].first;
    };
    stroke(3, {{"feed", 45}});
    stroke(3, {{"upper", -11}, {"feed", 50}});
    stroke(3, {{"upper", -6}, {"feed", 60.5}});
    stroke(4, {{"section-0-kind", 2},
               {"section-0-from", -16},
               {"section-0-to", -12},
               {"section-0-ratio", 0.5},
               {"max-acceleration", 600}});
}

TEST_F(Learned, AScaleThatDoesNotFollowStopsTheStroke) {
    bench.command("unlinkp chop.joint-feedback");
    bench.run(1);
    EXPECT_EQ(get("fault-code"), 21);
    EXPECT_EQ(get("active"), 0);
    const double place = get("command");
    EXPECT_GE(place, -20);
    EXPECT_LE(place, -8);
}

TEST_F(Chopping, AScaleThatSlipsIsNamedAndNeverLearned) {
    for (const char* line :
         {"loadrt sum2 names=scale", "unlinkp chop.joint-feedback", "net feedback scale.in0",
          "net slipped scale.out chop.joint-feedback", "addf scale servo-thread", "setp axis.servo-gain 20",
          "setp chop.learn 1", "setp chop.jerk-time 0.01"})
        bench.command(line);
    start();
    bench.run(30);
    ASSERT_EQ(get("learned"), 1);
    bench.expect("z >= -20.005 && z <= -7.995", {{"z", "axis.truth-position"}});
    bench.set("scale.in1", 0.03);
    bench.run(3);
    EXPECT_EQ(get("fault-code"), 19);
    EXPECT_EQ(get("active"), 0);
}

TEST(ChoppingSlips, NoStrokeLearnsAfterASlipBeforeSomebodyHasAnswered) {
    for (const std::string answer : {"homed", "forget"}) {
        SCOPED_TRACE(answer);
        Bench bench;
        wire(bench);
        for (const char* line :
             {"loadrt sum2 names=scale", "unlinkp chop.joint-feedback", "net feedback scale.in0",
              "net slipped scale.out chop.joint-feedback", "addf scale servo-thread",
              "setp axis.servo-gain 20", "setp chop.learn 1", "setp chop.jerk-time 0.01"})
            bench.command(line);
        const auto start = [&] {
            bench.set("chop.run", 0);
            bench.run(0.1);
            bench.set("chop.run", 1);
            bench.run(0.1);
            return bench.get("chop.active") != 0;
        };
        EXPECT_TRUE(start());
        for (const double slip : {0.03, -0.05}) {
            bench.run(40);
            ASSERT_EQ(bench.get("chop.learned"), 1);
            bench.set("scale.in1", bench.get("scale.in1") + slip);
            bench.run(0.003);
            EXPECT_EQ(bench.get("chop.fault-code"), 19);
            bench.run(1);
            EXPECT_FALSE(start());
            EXPECT_EQ(bench.get("chop.fault-code"), 19);
            const double given = bench.get("chop." + answer);
            bench.set("chop." + answer, 1 - given);
            if (answer == "homed") bench.set("scale.in1", 0);
            bench.run(0.1);
            bench.set("chop." + answer, given);
            bench.run(0.1);
            EXPECT_TRUE(start());
        }
    }
}

TEST_F(Learned, AnAxisThatIsTooWeakForTheCorrectionIsReported) {
    set("max-correction", 0.1);
    bench.run(30);
    EXPECT_EQ(get("fault-code"), 15);
    EXPECT_LE(get("upper-correction"), 0.1);
}

// Holds, overrides, shifts, stops, starts and sections of a learned axis, at drawn times.
TEST_F(Chopping, NothingThatAnOperatorDoesTakesTheAxisBeyond) {
    for (const int seed : {8, 10}) {
        SCOPED_TRACE(seed);
        Random random(static_cast<std::uint64_t>(seed));
        Bench own;
        wire(own);
        for (const char* line : {"setp chop.max-acceleration 600", "setp chop.learn 1",
                                 "setp chop.jerk-time 0.01", "setp axis.load-resonance 0"})
            own.command(line);
        own.set("axis.seed", seed);
        own.set("chop.run", 1);
        own.run(40);
        ASSERT_EQ(own.get("chop.learned"), 1);
        own.expect("z <= -7.995 && z >= -20.005", {{"z", "axis.truth-position"}});
        for (int i = 0; i < rounds(80, 20); ++i) {
            switch (random.index(5)) {
                case 0: own.set("chop.feed-hold", random.uniform() < 0.3); break;
                case 1: {
                    const double parts[] = {1, 1, 0.5, 0.1, 1.5};
                    own.set("chop.override", parts[random.index(5)]);
                    break;
                }
                case 2:
                    own.set("chop.upper", random.uniform() < 0.6 ? -8 : -10);
                    own.set("chop.shift", random.uniform() < 0.5);
                    break;
                case 3:
                    own.set("chop.stop-kind", 1 + random.index(2));
                    own.set("chop.run", random.uniform() < 0.7);
                    break;
                case 4:
                    own.set("chop.section-0-from", random.uniform(-18, -15));
                    own.set("chop.section-0-to", random.uniform(-14, -10));
                    own.set("chop.section-0-ratio", random.uniform(0.3, 0.8));
                    own.set("chop.section-0-kind", random.uniform() < 0.7 ? 2 : 0);
                    break;
            }
            own.run(random.uniform(0.05, 1.5));
        }
    }
}

TEST_F(Chopping, AFollowingErrorStopsTheStroke) {
    set("max-following-error", 5);
    start();
    bench.run(2);
    EXPECT_EQ(get("fault-code"), 0);
    bench.set("axis.enabled", 0);
    bench.run(1);
    EXPECT_EQ(get("fault-code"), 10);
    EXPECT_EQ(get("active"), 0);
}

}  // namespace
}  // namespace plumb
