// SPDX-License-Identifier: GPL-2.0-or-later
// A column leans, and chopping strokes Z by 400 mm while LinuxCNC has Z at point R. squareness keeps the
// wheel on a straight line if its position of Z has the stroke, and says so if not.
// grinder_seen_linuxcnc_test.py has it in LinuxCNC itself.
#include "tests/support/bench.hpp"
#include "tests/support/error_table_text.hpp"
#include "tests/support/folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace plumb {
namespace {

constexpr double lean = 1e-4;                // rad, of Z towards +X
constexpr double nm = 1e-6;                  // mm
constexpr double at_point_r = 99, own = 40;  // status-code: own, corrects

struct Grinder {
    // `netted`: squareness has the stroke.
    explicit Grinder(bool netted, const std::string& order = "chop.update square.update",
                     const client::Start& host = with_specimens())
        : bench(Bench::Thread::none, host) {
        for (const char* line :
             {"loadrt threads name1=servo-thread period1=1000000",
              "loadrt motion_joint names=joint.0,joint.2",
              "loadrt lowpass names=motion-command-handler,motion-controller,x-drive,z-drive",
              "loadrt squareness names=square",
              "loadrt chopping names=chop",
              "loadrt joint_offset names=x-stage,z-stage",
              "loadrt interlock names=interlock functions=2 stages=2",
              "net square-permit interlock.function-permit-0 => square.permit",
              "net square-state square.state => interlock.function-state-0",
              "net chop-permit interlock.function-permit-1 => chop.permit",
              "net chop-state chop.state => interlock.function-state-1",
              "net x-correction square.x-correction => x-stage.offset-0",
              "net z-chop chop.offset => z-stage.offset-0 chop.applied-offset",
              "net z-correction square.z-correction => z-stage.offset-1",
              "net z-released z-stage.released => chop.stage-released",
              "net z-position => chop.position",
              "net z-homed => chop.homed",
              "net z-on => chop.motion-enabled interlock.motion-enabled square.motion-enabled",
              "net z-homed => interlock.all-homed square.all-homed",
              "net x-position => square.x-position",
              "setp z-stage.release-at-off-0 1",
              "setp interlock.function-services-0 0",
              "setp interlock.function-services-1 0",
              "setp interlock.function-stages-0 3",
              "setp interlock.function-stages-1 2",
              "setp interlock.function-switch-0 1",
              "setp interlock.function-switch-1 1",
              "setp square.max-speed 1000",
              "setp square.eb0z 1e-4",
              "setp square.max-rate 10",
              "setp chop.min-limit -1900",
              "setp chop.max-limit 1900",
              "setp chop.upper 200",
              "setp chop.lower -200",
              "setp chop.feed 200",
              "setp chop.max-feed 400",
              "setp chop.max-acceleration 2000"})
            bench.command(line);
        for (const std::string axis : {"x", "z"}) {
            const std::string joint = axis == "x" ? "joint.0" : "joint.2", row = axis == "x" ? "0" : "1";
            for (const std::string& line :
                 {"net " + axis + "-position " + joint + ".command => " + axis + "-stage.position",
                  "net " + axis + "-homed " + joint + ".homed => " + axis + "-stage.homed",
                  "net " + axis + "-on " + joint + ".enabled => " + axis + "-stage.motion-enabled",
                  "net " + axis + "-cmd " + joint + ".motor-command => " + axis + "-stage.joint-command",
                  "net " + axis + "-fb " + axis + "-stage.joint-feedback => " + joint + ".motor-feedback",
                  "net " + axis + "-motor-cmd " + axis + "-stage.drive-command => " + axis + "-drive.in",
                  "net " + axis + "-motor-fb " + axis + "-drive.out => " + axis + "-stage.drive-feedback",
                  "net " + axis + "-permit interlock.stage-permit-" + row + " => " + axis + "-stage.permit",
                  "net " + axis + "-state " + axis + "-stage.state => interlock.stage-state-" + row,
                  "setp " + axis + "-drive.gain 1", "setp " + axis + "-stage.min-limit -2000",
                  "setp " + axis + "-stage.max-limit 2000", "setp " + axis + "-stage.max-offset 450",
                  "setp " + axis + "-stage.max-rate 1000", "setp " + axis + "-stage.joint-acceleration 2000",
                  "setp " + axis + "-stage.offset-acceleration 20000", "setp " + joint + ".max-error 5",
                  "setp " + joint + ".acceleration 2000"})
                bench.command(line);
        }
        if (netted) {
            bench.command("net z-stroked-position chop.command => square.z-position");
            bench.command("net z-stroked-velocity chop.command-velocity => square.z-velocity");
        } else {
            bench.command("net z-position => square.z-position");
        }
        std::string functions =
            "motion-command-handler x-stage.update-feedback z-stage.update-feedback "
            "joint.0.update joint.2.update motion-controller " +
            order + " x-stage.update z-stage.update interlock.update x-drive z-drive ";
        for (std::size_t end; (end = functions.find(' ')) != std::string::npos; functions.erase(0, end + 1))
            bench.command("addf " + functions.substr(0, end) + " servo-thread");
        bench.command("start");
        for (const char* pin : {"joint.0.on", "joint.2.on", "joint.0.home", "joint.2.home"})
            bench.set(pin, 1);
        bench.run(3);
    }

    void stroke() {
        bench.set("chop.run", 1);
        bench.run(4);
        EXPECT_EQ(bench.get("chop.stroking"), 1);
        EXPECT_EQ(bench.get("chop.fault-code"), 0);
    }

    // How far the path of the wheel is from a straight line along Z, over two cycles: the column leans.
    double crooked() {
        const Table path = bench.trace(8, {"x-drive.out", "z-drive.out"});
        const std::vector<double> x = path.column("x-drive.out"), z = path.column("z-drive.out");
        EXPECT_NEAR(*std::max_element(z.begin(), z.end()) - *std::min_element(z.begin(), z.end()), 400, 0.1);
        double lowest = 1e9, highest = -1e9;
        for (std::size_t i = 0; i < x.size(); ++i) {
            lowest = std::min(lowest, x[i] + lean * z[i]);
            highest = std::max(highest, x[i] + lean * z[i]);
        }
        return highest - lowest;
    }

    double status() { return bench.get("square.status-code"); }

    Bench bench;
};

TEST(StrokeSeen, AFunctionThatHasTheAxisAtPointRLeavesTheLeanOfTheStrokeAndSaysSo) {
    Grinder grinder(false);
    EXPECT_EQ(grinder.status(), own);
    grinder.stroke();
    EXPECT_NEAR(grinder.crooked(), 40 * um, 0.1 * um);
    EXPECT_EQ(grinder.status(), at_point_r);
    EXPECT_EQ(grinder.bench.get("square.attention"), 1);
    EXPECT_EQ(grinder.bench.get("interlock.function-status-1"), 0);  // not the one that strokes
    grinder.bench.set("chop.run", 0);
    grinder.bench.run(5);
    EXPECT_EQ(grinder.status(), own);
}

TEST(StrokeSeen, WithTheStrokeInItsPositionThePathOfTheWheelIsStraight) {
    Grinder grinder(true);
    grinder.stroke();
    EXPECT_LT(grinder.crooked(), 1 * nm);
    EXPECT_EQ(grinder.status(), own);
    EXPECT_EQ(grinder.bench.get("square.limited"), 0);
}

TEST(StrokeSeen, InTheOtherOrderOfFunctionsTheCorrectionIsOnePeriodLate) {
    Grinder grinder(true, "square.update chop.update");
    grinder.stroke();
    const double speed = 400;  // mm/s, the largest of the stroke
    EXPECT_LT(grinder.crooked(), 2 * lean * speed * 0.001);
}

TEST(StrokeSeen, ANetThatIsMendedEndsTheSentence) {
    Grinder grinder(false);
    grinder.stroke();
    grinder.bench.run(2);
    EXPECT_EQ(grinder.status(), at_point_r);
    grinder.bench.command("unlinkp square.z-position");
    grinder.bench.command("net z-stroked-position chop.command => square.z-position");
    grinder.bench.run(2);
    EXPECT_EQ(grinder.status(), own);
}

TEST(StrokeSeen, LinuxCNCsLogNamesThePinAndTheNetOnce) {
    testing::internal::CaptureStderr();
    {
        client::Start host = with_specimens();
        host.show_output = true;
        Grinder grinder(false, "chop.update square.update", host);
        grinder.stroke();
    }
    const std::string output = testing::internal::GetCapturedStderr();
    const std::string sentence =
        "square.z-position has joint.2.command, which lacks the stroke of chop: run plumb wire "
        "again, or net chop.command to a position, ";
    const std::size_t first = output.find(sentence);
    ASSERT_NE(first, std::string::npos) << output;
    EXPECT_EQ(output.find(sentence, first + 1), std::string::npos) << output;
}

TEST(StrokeSeen, AVelocityAloneIsNoticedToo) {
    Grinder grinder(true);
    grinder.bench.command("unlinkp square.z-velocity");
    grinder.bench.command("net z-velocity joint.2.error => z-stage.joint-velocity square.z-velocity");
    grinder.stroke();
    EXPECT_EQ(grinder.status(), at_point_r);
}

TEST(StrokeSeen, TheVelocityIsThatOfJointAndStrokeTogether) {
    Grinder grinder(true);
    grinder.stroke();
    grinder.bench.set("chop.joint-velocity", 5);
    const Table path = grinder.bench.trace(4, {"chop.command", "chop.command-velocity"});
    const std::vector<double> z = path.column("chop.command"), v = path.column("chop.command-velocity");
    for (std::size_t i = 1; i < z.size(); ++i)
        ASSERT_NEAR(v[i], (z[i] - z[i - 1]) / 0.001 + 5, 1.1) << i;  // half a period, at 2000 mm/s2
}

TEST(StrokeSeen, MachineOffAmidAStrokeIsNoJumpAndMovesNothing) {
    Grinder grinder(true);
    grinder.stroke();
    grinder.bench.expect("jump == 0", {{"jump", "square.limited"}});
    for (const char* joint : {"joint.0.on", "joint.2.on"}) grinder.bench.set(joint, 0);
    grinder.bench.run(0.5);
    EXPECT_EQ(grinder.bench.get("chop.offset"), 0);
    EXPECT_NEAR(grinder.bench.get("square.z-position"), grinder.bench.get("z-drive.out"), 10 * nm);
}

// A stroke from 0 to 40 that learns its dead points on a scale at the load, with 20 um of lost motion, and a
// table of this lost motion. Returns how far the load passes the dead points, or, negative, stays inside.
double beyond(bool netted) {
    Folder folder;
    Bench bench(Bench::Thread::none);
    const std::string table = "Z,EZZ+,EZZ-\n-300,-0.01,0.01\n300,-0.01,0.01\n";
    bench.command("loadrt squareness names=square interlock=no table=" +
                  folder.write("z.csv", closed(table)).string());
    for (const char* line : {"loadrt threads name1=servo-thread period1=1000000",
                             "loadrt chopping names=chop interlock=no",
                             "loadrt joint_offset names=z-stage interlock=no",
                             "loadrt sim_grinder names=grinder",
                             "setp grinder.backlash 0.02",
                             "setp chop.upper 40",
                             "setp chop.lower 0",
                             "setp chop.feed 100",
                             "setp chop.max-acceleration 1500",
                             "setp chop.jerk-time 0.01",
                             "setp chop.min-limit -50",
                             "setp chop.max-limit 250",
                             "setp chop.homed 1",
                             "setp chop.motion-enabled 1",
                             "setp chop.learn 1",
                             "setp z-stage.homed 1",
                             "setp z-stage.motion-enabled 1",
                             "setp z-stage.min-limit -2000",
                             "setp z-stage.max-limit 2000",
                             "setp z-stage.max-offset 500",
                             "setp z-stage.max-rate 500",
                             "setp z-stage.joint-acceleration 500",
                             "setp z-stage.offset-acceleration 20000",
                             "setp square.all-homed 1",
                             "setp square.enable 1",
                             "setp square.max-speed 1000",
                             "net z-chop chop.offset => z-stage.offset-0 chop.applied-offset",
                             "net z-correction square.z-correction => z-stage.offset-1",
                             "net z-fb z-stage.joint-feedback => chop.joint-feedback",
                             "net z-stroked-position chop.command => square.z-position",
                             "net z-motor-cmd z-stage.drive-command => grinder.position-cmd",
                             "net z-motor-fb grinder.position => z-stage.drive-feedback",
                             "addf z-stage.update-feedback servo-thread",
                             "addf chop.update servo-thread",
                             "addf square.update servo-thread",
                             "addf z-stage.update servo-thread",
                             "addf grinder.update servo-thread",
                             "start"})
        bench.command(line);
    if (netted) bench.command("net z-stroked-learns chop.learns => square.z-learns");
    bench.run(1);
    bench.set("chop.run", 1);
    bench.run(120);
    EXPECT_EQ(bench.get("chop.learned"), 1);
    EXPECT_EQ(bench.get("square.fault-code"), netted ? 14 : 0);
    const std::vector<double> z = bench.trace(4, {"grinder.position"}).column("grinder.position");
    return std::max(*std::max_element(z.begin(), z.end()) - 40, -*std::min_element(z.begin(), z.end()));
}

TEST(StrokeSeen, ATableByDirectionWouldMoveLearnedDeadPointsAndIsLeftOut) {
    EXPECT_NEAR(beyond(false), -10 * um, 2.5 * um);  // the table turns before the axis, which lags
    EXPECT_NEAR(beyond(true), 0, 2.5 * um);
}

}  // namespace
}  // namespace plumb
