// SPDX-License-Identifier: GPL-2.0-or-later
// Machine off amid a stroke: chopping, joint_offset and a model of LinuxCNC's motion make the offset of the
// stroke part of the position. grinder_linuxcnc_test.py has it in LinuxCNC itself.
#include "components/math/blocks/random.hpp"
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace plumb {
namespace {

constexpr double nm = 1e-6;  // mm

// A wheel that strokes from -8 to -38 below point R, which is 10, on a joint with a correction of 20 um as
// well.
struct StrokeRelease : testing::Test {
    Bench bench{Bench::Thread::none, with_specimens()};

    StrokeRelease() {
        for (const char* line :
             {"loadrt threads name1=servo-thread period1=1000000",
              "loadrt joint_offset names=z-stage interlock=no",
              "loadrt chopping names=chop interlock=no sections=4",
              "loadrt motion_joint names=motion",
              "loadrt lowpass names=drive",
              "setp z-stage.min-limit -1000",
              "setp z-stage.max-limit 1000",
              "setp z-stage.joint-acceleration 2000",
              "setp z-stage.offset-acceleration 20000",
              "setp z-stage.max-offset 500",
              "setp z-stage.max-rate 1000",
              "setp z-stage.ramp-rate 10",
              "setp z-stage.release-at-off-0 1",
              "setp z-stage.offset-1 0.02",
              "setp chop.min-limit -900",
              "setp chop.max-limit 900",
              "setp chop.upper 2",
              "setp chop.lower -28",
              "setp chop.feed 100",
              "setp drive.gain 0.283469",
              "setp motion.max-error 5",
              "setp motion.acceleration 2000",
              "net homed      motion.homed           => z-stage.homed chop.homed",
              "net enabled    motion.enabled         => z-stage.motion-enabled chop.motion-enabled",
              "net position   motion.command         => z-stage.position chop.position",
              "net command    motion.motor-command   => z-stage.joint-command",
              "net stroke     chop.offset            => z-stage.offset-0 chop.applied-offset",
              "net released   z-stage.released       => chop.stage-released",
              "net to-drive   z-stage.drive-command  => drive.in",
              "net from-drive drive.out              => z-stage.drive-feedback",
              "net feedback   z-stage.joint-feedback => motion.motor-feedback",
              "addf z-stage.update-feedback servo-thread",
              "addf motion.update servo-thread",
              "addf chop.update servo-thread",
              "addf z-stage.update servo-thread",
              "addf drive servo-thread",
              "start"})
            bench.command(line);
        bench.set("motion.on", 1);
        bench.set("motion.home", 1);
        bench.set("motion.program", 10);
        bench.run(2);
    }

    double get(const std::string& pin) { return bench.get(pin); }
    void set(const std::string& pin, double value) { bench.set(pin, value); }

    void start() {
        set("chop.run", 0);
        bench.run(0.002);
        set("chop.run", 1);
        bench.run(2);
        ASSERT_EQ(get("chop.active"), 1);
    }

    // LinuxCNC shows where the wheel is, but for the correction, and nothing has an offset in force.
    void expect_truth(int fault = 0) {
        EXPECT_NEAR(get("motion.command"), get("drive.out") - get("z-stage.applied-offset"), 1 * nm);
        EXPECT_LE(std::abs(get("z-stage.applied-offset")), 0.021);
        EXPECT_EQ(get("chop.offset"), 0);
        EXPECT_EQ(get("chop.at-end"), 1);
        EXPECT_EQ(get("z-stage.fault-code"), 0);
        EXPECT_EQ(get("chop.fault-code"), fault);
    }

    // Turns the machine on, where the program wants the axis to be where it is.
    void turn_on() {
        set("motion.program", get("motion.command"));
        set("motion.on", 1);
    }
};

TEST_F(StrokeRelease, MachineOffMakesTheStrokePartOfThePosition) {
    Random random(5);
    for (int i = 0; i < 40; ++i) {
        SCOPED_TRACE(i);
        start();
        bench.run(random.uniform(0, 1));
        const double r = get("motion.command");
        set("motion.on", 0);
        const Table off = bench.trace(0.2, {"z-stage.drive-command", "drive.out", "chop.offset"});
        const std::vector<double> z = off.column("z-stage.drive-command"), is = off.column("drive.out");
        for (std::size_t n = 1; n < z.size(); ++n) ASSERT_LT(std::abs(z[n] - z[n - 1]), 0.5) << n;
        EXPECT_LT(std::abs(is.back() - is.front()), 0.5);
        expect_truth();
        EXPECT_NEAR(get("z-stage.applied-offset"), 0.02, 1 * nm) << "the correction stays";
        EXPECT_LT(get("motion.command"), r - 0.1);
        turn_on();
        bench.run(0.001);
        for (const double each : bench.trace(1, {"drive.out"}).column("drive.out"))
            ASSERT_NEAR(each, is.back(), 1 * um);
        expect_truth();
        set("motion.program", 10);
        bench.run(3);
    }
}

TEST_F(StrokeRelease, TheCorrectionAloneHoldsAsBefore) {
    const double before = get("z-stage.applied-offset");
    EXPECT_NEAR(before, 0.02, 1 * nm);
    set("motion.on", 0);
    bench.run(0.5);
    EXPECT_EQ(get("z-stage.applied-offset"), before);
    EXPECT_NEAR(get("motion.command"), 10, 1 * nm);
}

// A homed that is lost at the same instant, or while the machine is off.
TEST_F(StrokeRelease, ALostHomedMovesNothingOnEitherWayIn) {
    for (const int order : {0, 1, 2}) {
        SCOPED_TRACE(order);
        start();
        bench.command("unlinkp z-stage.homed");
        bench.command("unlinkp chop.homed");
        const auto homed = [&](double value) {
            set("z-stage.homed", value);
            set("chop.homed", value);
        };
        homed(1);
        bench.run(0.3);
        if (order != 1) homed(0);
        if (order == 0) {  // the machine is on: the stroke brakes, its offset is held, and that is told
            bench.run(1);
            const double held = get("drive.out");
            for (const double each : bench.trace(3, {"drive.out"}).column("drive.out"))
                ASSERT_NEAR(each, held, 0.1 * um);
            EXPECT_EQ(get("z-stage.inhibit-homing"), 1);
            EXPECT_EQ(get("z-stage.fault-code"), 9);
        }
        set("motion.on", 0);
        bench.run(0.05);
        if (order == 1) homed(0);
        const double stood = get("drive.out");
        bench.run(1);
        EXPECT_NEAR(get("drive.out"), stood, 21 * um) << "the correction is released";
        expect_truth(order == 0 ? 25 : 0);
        EXPECT_EQ(get("z-stage.inhibit-homing"), 0) << "LinuxCNC may home";
        turn_on();
        homed(1);
        bench.run(1);
        EXPECT_NEAR(get("drive.out"), stood, 21 * um);
        bench.command("net homed z-stage.homed chop.homed");
        set("motion.program", 10);
        bench.run(3);
    }
}

TEST_F(StrokeRelease, AHomedThatIsLostForAMomentBrakesTheStrokeAndHolds) {
    bench.command("loadrt ddt names=speed,growth");
    for (const char* line : {"net to-drive speed.in", "net v speed.out growth.in", "addf speed servo-thread",
                             "addf growth servo-thread"})
        bench.command(line);
    start();
    bench.command("unlinkp z-stage.homed");
    bench.command("unlinkp chop.homed");
    bench.expect("abs(a) <= 1010", {{"a", "growth.out"}});
    for (const int value : {0, 1}) {
        set("z-stage.homed", value);
        set("chop.homed", value);
        bench.run(1);
        const double stood = get("drive.out");
        for (const double each : bench.trace(1.5, {"drive.out"}).column("drive.out"))
            ASSERT_NEAR(each, stood, 0.1 * um);
        EXPECT_EQ(get("z-stage.fault-code"), value ? 0 : 9);
        EXPECT_EQ(get("chop.fault-code"), 25);
    }
    EXPECT_LT(get("chop.offset"), -8);
    EXPECT_GE(get("chop.offset"), -38);
}

TEST_F(StrokeRelease, AStageThatIsHeldByInterlockReleasesWhatItApplies) {
    set("z-stage.heartbeat", 1);
    for (int i = 2; i < 5; ++i) {
        bench.run(0.001);
        set("z-stage.heartbeat", i);
    }
    set("chop.run", 1);
    for (int i = 5; i < 1500; ++i) {
        set("z-stage.heartbeat", i);
        bench.run(0.001);
    }
    bench.run(0.35);  // it stands still: the stage holds, and chopping goes on
    const double held = get("z-stage.applied-offset"), stood = get("drive.out");
    ASSERT_GT(std::abs(held - get("chop.offset")), 1);
    set("motion.on", 0);
    bench.run(0.3);
    EXPECT_NEAR(get("drive.out"), stood, 1 * um);
    EXPECT_NEAR(get("motion.command"), get("drive.out") - get("z-stage.applied-offset"), 1 * nm);
    EXPECT_LE(std::abs(get("z-stage.applied-offset")), 0.02 + nm);
    EXPECT_EQ(get("chop.offset"), 0);
    turn_on();
    bench.run(1);
    EXPECT_NEAR(get("drive.out"), stood, 1 * um);
}

TEST_F(StrokeRelease, ASourceThatIgnoresTheReleaseHasNoEffectUntilItIsZero) {
    bench.command("unlinkp chop.stage-released");
    start();
    set("motion.on", 0);
    bench.run(0.3);
    const double stood = get("drive.out");
    EXPECT_LT(get("chop.offset"), -1);
    turn_on();
    bench.run(1);
    EXPECT_NEAR(get("drive.out"), stood, 1 * um);
    EXPECT_EQ(get("z-stage.fault-code"), 10);
    EXPECT_EQ(get("z-stage.limited"), 1);
    set("chop.go-to-end", 1);
    bench.run(2);
    EXPECT_EQ(get("chop.offset"), 0);
    EXPECT_NEAR(get("drive.out"), stood, 1 * um);
    EXPECT_EQ(get("z-stage.fault-code"), 0);
}

// Off and on within few periods, at any phase, with a homed that comes and goes: the command of the drive
// never jumps by more than a lag, and no position is wrong.
TEST_F(StrokeRelease, NoSequenceOfOffAndOnMovesTheAxis) {
    Random random(11);
    for (int i = 0; i < 120; ++i) {
        SCOPED_TRACE(i);
        if (get("chop.active") == 0) {
            set("chop.run", 0);
            bench.run(0.002);
            set("chop.run", 1);
        }
        bench.run(random.uniform(0.002, 0.8));
        const int toggles = 1 + static_cast<int>(random.uniform(0, 4));
        double last = get("z-stage.drive-command");
        const auto watch = [&](double seconds) {
            for (const double each :
                 bench.trace(seconds, {"z-stage.drive-command"}).column("z-stage.drive-command")) {
                ASSERT_LT(std::abs(each - last), 1) << "mm in a period";
                last = each;
            }
        };
        for (int n = 0; n < toggles; ++n) {
            set("motion.on", 0);
            watch(0.001 * (1 + static_cast<int>(random.uniform(0, 4))));
            set("motion.program", get("motion.command"));
            set("motion.on", 1);
            watch(0.001 * (1 + static_cast<int>(random.uniform(0, 3))));
        }
        watch(0.3);
        EXPECT_EQ(get("z-stage.fault-code"), 0);
        EXPECT_NEAR(get("z-stage.applied-offset"), get("chop.offset") + 0.02, 0.01) << "nothing is lost";
        EXPECT_NEAR(get("motion.command") + get("z-stage.applied-offset"), get("drive.out"), 0.5);
        set("motion.on", 0);
        watch(0.1);
        expect_truth();
        set("motion.program", get("motion.command"));
        set("motion.on", 1);
        watch(0.1);
        set("motion.program", 10);
        bench.run(3);
    }
}

}  // namespace
}  // namespace plumb
