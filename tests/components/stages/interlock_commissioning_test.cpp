// SPDX-License-Identifier: GPL-2.0-or-later
// interlock holds functions and stages that were not commissioned, and permits one of them while somebody
// presses.
#include "tests/support/bench.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace plumb {
namespace {

constexpr double held = 12, stage_held = 13, none = 0;  // function-status

// Squareness on X and Y, and an offset of the axis Z; the stand-ins of motion and the drives are stock
// modules.
struct Machine {
    explicit Machine(const char* required = "true") : bench(Bench::Thread::none, with_specimens()) {
        for (const std::string line :
             {"loadrt threads name1=servo-thread period1=1000000",
              "loadrt lowpass names=motion-command-handler,motion-controller,x-drive,y-drive,other-drive",
              "loadrt squareness names=square",
              "loadrt joint_offset names=x-stage,y-stage",
              "loadrt interlock names=interlock stages=2",
              "net square-permit interlock.function-permit-0 square.permit",
              "net square-state square.state interlock.function-state-0",
              "net trial interlock.trial x-stage.trial y-stage.trial",
              "net x-cmd x-stage.drive-command x-drive.in",
              "net y-cmd y-stage.drive-command y-drive.in",
              "net x-correction square.x-correction x-stage.offset-0",
              "net y-correction square.y-correction y-stage.offset-0",
              "setp interlock.function-stages-0 3",
              "setp interlock.function-services-0 0",
              "setp interlock.function-switch-0 true",
              "setp interlock.motion-enabled true",
              "setp interlock.all-homed true",
              "setp square.all-homed true",
              "setp square.max-speed 100",
              "setp square.z-position 100",
              "setp square.eb0z -1e-4",
              "setp x-drive.gain 1",
              "setp y-drive.gain 1",
              "setp interlock.trial-limit 0.05"})
            bench.command(line);
        for (const std::string letter : {"x", "y"}) {
            const std::string number = letter == "x" ? "0" : "1";
            bench.command("net " + letter + "-state " + letter + "-stage.state interlock.stage-state-" +
                          number);
            bench.command("net " + letter + "-permit interlock.stage-permit-" + number + " " + letter +
                          "-stage.permit");
            for (const char* setting : {"min-limit -100", "max-limit 100", "joint-acceleration 2000",
                                        "offset-acceleration 1000", "homed true", "motion-enabled true"})
                bench.command("setp " + letter + "-stage." + setting);
        }
        bench.command(std::string("setp interlock.commissioning ") + required);
        for (const char* function :
             {"motion-command-handler", "x-stage.update-feedback", "y-stage.update-feedback",
              "motion-controller", "square.update", "x-stage.update", "y-stage.update", "interlock.update",
              "x-drive", "y-drive"})
            bench.command(std::string("addf ") + function + " servo-thread");
        bench.command("start");
        bench.run(4);
    }

    double applied(const std::string& letter) { return bench.get(letter + "-stage.applied-offset"); }
    double status() { return bench.get("interlock.function-status-0"); }
    double identity(const std::string& what) { return bench.get("interlock." + what + "-identity-0"); }

    // As plumb commission does.
    void pass(const std::string& what, int number) {
        const std::string n = std::to_string(number);
        bench.set("interlock." + what + "-passed-" + n, bench.get("interlock." + what + "-identity-" + n));
    }
    void pass_all() {
        pass("stage", 0);
        pass("stage", 1);
        pass("function", 0);
        bench.run(4);
    }
    void press(double time) {
        for (double t = 0; t < time; t += 0.1) {
            beat = !beat;
            bench.set("interlock.trial-beat", beat);
            bench.run(0.1);
        }
    }

    Bench bench;
    bool beat = false;
};

TEST(InterlockCommissioning, WithoutItNothingIsHeld) {
    Machine machine("false");
    EXPECT_EQ(machine.status(), none);
    EXPECT_NEAR(machine.applied("x"), 0.01, 1e-6);
    EXPECT_EQ(machine.identity("function"), 0);  // nobody looks
}

TEST(InterlockCommissioning, HoldsAFunctionAndItsStagesUntilAllHavePassed) {
    Machine machine;
    EXPECT_EQ(machine.status(), stage_held);
    EXPECT_EQ(machine.applied("x"), 0);
    machine.pass("stage", 0);
    machine.pass("function", 0);
    machine.bench.run(1);
    EXPECT_EQ(machine.status(), stage_held);
    EXPECT_EQ(machine.applied("x"), 0);
    machine.pass_all();
    EXPECT_EQ(machine.status(), none);
    EXPECT_NEAR(machine.applied("x"), 0.01, 1e-6);
}

TEST(InterlockCommissioning, APressThatFollowsSoonActs) {
    Machine machine;
    machine.pass("stage", 0);
    machine.pass("stage", 1);
    for (const double pause : {0.01, 0.3, 0.35, 0.39, 0.5}) {
        machine.bench.set("interlock.trial-function", 0);
        machine.bench.run(0.1);  // before its first beat, the one of the press before goes silent
        machine.press(0.2);
        EXPECT_EQ(machine.status(), none) << pause;
        machine.bench.set("interlock.trial-function", -1);
        machine.bench.run(pause);
    }
}

TEST(InterlockCommissioning, AFunctionAloneWaitsToo) {
    Machine machine;
    machine.pass("stage", 0);
    machine.pass("stage", 1);
    machine.bench.run(1);
    EXPECT_EQ(machine.status(), held);
    EXPECT_EQ(machine.applied("x"), 0);
}

TEST(InterlockCommissioning, AnotherSignTakesItBackAndAnotherAngleDoesNot) {
    Machine machine;
    machine.pass_all();
    const double before = machine.identity("function");
    machine.bench.set("square.eb0z", -2e-4);
    machine.bench.set("square.max-angle", 0.001);
    machine.bench.set("x-stage.max-rate", 0.5);
    machine.bench.set("x-stage.max-limit", 90);
    machine.bench.run(4);
    EXPECT_EQ(machine.identity("function"), before);
    EXPECT_NEAR(machine.applied("x"), 0.02, 1e-6);
    machine.bench.set("square.eb0z", 2e-4);
    machine.bench.run(4);
    EXPECT_NE(machine.identity("function"), before);
    EXPECT_EQ(machine.status(), held);
    EXPECT_EQ(machine.applied("x"), 0);
}

TEST(InterlockCommissioning, AnotherDriveTakesItsStageBack) {
    Machine machine;
    machine.pass_all();
    const double stage = machine.identity("stage"), function = machine.identity("function");
    machine.bench.command("unlinkp x-drive.in");
    machine.bench.command("net x-cmd other-drive.in");
    machine.bench.run(4);
    EXPECT_NE(machine.identity("stage"), stage);
    EXPECT_NE(machine.identity("function"), function);
    EXPECT_EQ(machine.status(), stage_held);
    EXPECT_EQ(machine.applied("x"), 0);
    machine.bench.command("unlinkp other-drive.in");
    machine.bench.command("net x-cmd x-drive.in");
    machine.bench.run(4);
    EXPECT_EQ(machine.identity("stage"), stage);
    EXPECT_EQ(machine.status(), none);
}

TEST(InterlockCommissioning, WhileWorkGoesOnNothingIsTakenBack) {
    Machine machine;
    machine.pass_all();
    machine.bench.set("interlock.program-running", 1);
    machine.bench.set("square.eb0z", 1e-4);
    machine.bench.run(4);
    EXPECT_EQ(machine.status(), none);
    EXPECT_NEAR(machine.applied("x"), -0.01, 1e-6);
    machine.bench.set("interlock.program-running", 0);
    machine.bench.run(4);
    EXPECT_EQ(machine.status(), held);
    EXPECT_EQ(machine.applied("x"), 0);
}

TEST(InterlockCommissioning, AStageMovesWhileSomebodyPresses) {
    Machine machine;
    machine.bench.set("interlock.trial-stage", 1);
    machine.bench.set("interlock.trial-offset", 0.01);
    machine.bench.run(1);
    EXPECT_EQ(machine.applied("y"), 0);
    machine.press(1);
    EXPECT_NEAR(machine.applied("y"), 0.01, 1e-6);
    EXPECT_EQ(machine.applied("x"), 0);
    machine.bench.run(1);  // nobody presses any more
    EXPECT_EQ(machine.applied("y"), 0);
}

TEST(InterlockCommissioning, ATrialOfAKilledProgramEndsAndAnotherBeatDoesNotReviveIt) {
    for (const int beats : {1, 2, 7}) {  // before the kill
        Machine machine;
        machine.bench.set("interlock.trial-offset", 0.01);
        machine.bench.set("interlock.trial-stage", 1);
        machine.press(0.1 * beats);
        machine.bench.run(0.7);
        EXPECT_EQ(machine.applied("y"), 0) << beats;
        machine.press(1);  // the next program, which has set no number yet
        EXPECT_EQ(machine.applied("y"), 0) << beats;
        machine.bench.set("interlock.trial-stage", -1);
        machine.bench.run(0.05);
        machine.bench.set("interlock.trial-stage", 1);
        machine.press(1);
        EXPECT_NEAR(machine.applied("y"), 0.01, 1e-6) << beats;
    }
}

TEST(InterlockCommissioning, TheEmergencyStopEndsATrialForGood) {
    Machine machine;
    machine.pass("stage", 0);
    machine.pass("stage", 1);
    machine.bench.set("interlock.trial-offset", 0.01);
    const auto power = [&](bool on) {
        for (const char* pin :
             {"interlock.motion-enabled", "x-stage.motion-enabled", "y-stage.motion-enabled"})
            machine.bench.set(pin, on);
    };
    for (const char* trial : {"stage", "function"}) {
        machine.bench.set(std::string("interlock.trial-") + trial, 0);
        machine.press(1);
        EXPECT_NEAR(machine.applied("x"), 0.01, 1e-6) << trial;
        power(false);
        machine.press(1);
        EXPECT_NEAR(machine.applied("x"), 0.01, 1e-6) << trial;  // nothing moves
        power(true);
        machine.press(1);  // still pressed
        EXPECT_EQ(machine.applied("x"), 0) << trial;
        machine.bench.set(std::string("interlock.trial-") + trial, -1);
        machine.bench.run(0.1);
    }
}

TEST(InterlockCommissioning, APressAppliesItsOwnSourceAlone) {
    Machine machine;
    machine.bench.set("y-stage.offset-1", 0.9);
    machine.bench.set("interlock.trial-stage", 1);
    machine.bench.set("interlock.trial-offset", 0.01);
    machine.press(1);
    EXPECT_NEAR(machine.applied("y"), 0.01, 1e-6);
    machine.bench.set("y-stage.offset-1", -0.9);
    machine.press(1);
    EXPECT_NEAR(machine.applied("y"), 0.01, 1e-6);
    machine.bench.run(1);
    EXPECT_EQ(machine.applied("y"), 0);
}

TEST(InterlockCommissioning, APressMovesNothingElse) {
    Machine machine;
    machine.pass_all();
    EXPECT_NEAR(machine.applied("x"), 0.01, 1e-6);
    machine.bench.set("interlock.trial-stage", 1);
    machine.bench.set("interlock.trial-offset", 0.01);
    machine.press(0.5);
    machine.bench.set("square.eb0z", -2e-4);
    machine.press(2);
    EXPECT_NEAR(machine.applied("x"), 0.01, 1e-6) << "it holds";
    EXPECT_NEAR(machine.applied("y"), 0.01, 1e-6) << "its own source, beside the offset that was in force";
    machine.bench.run(2);
    EXPECT_NEAR(machine.applied("x"), 0.02, 1e-6) << "and goes on afterwards";
}

TEST(InterlockCommissioning, AFunctionOnTrialMovesItsOwnSourceAlone) {
    Machine machine;
    machine.pass("stage", 0);
    machine.pass("stage", 1);
    machine.bench.set("x-stage.offset-1", 0.3);
    machine.bench.run(4);
    EXPECT_NEAR(machine.applied("x"), 0.3, 1e-6);
    machine.bench.set("interlock.trial-function", 0);
    machine.press(0.2);
    machine.bench.set("x-stage.offset-1", 0.4);
    machine.press(2);
    EXPECT_NEAR(machine.applied("x"), 0.31, 1e-6);
    machine.bench.run(3);
    EXPECT_NEAR(machine.applied("x"), 0.4, 1e-6);
}

TEST(InterlockCommissioning, ATurningSpindleEndsAPress) {
    for (const double speed : {1000., -1000., std::nan("")}) {
        Machine machine;
        machine.bench.set("interlock.trial-stage", 1);
        machine.bench.set("interlock.trial-offset", 0.01);
        machine.press(1);
        EXPECT_NEAR(machine.applied("y"), 0.01, 1e-6);
        machine.bench.set("interlock.spindle-speed", speed);
        machine.press(0.5);
        EXPECT_EQ(machine.applied("y"), 0) << speed;
        machine.bench.set("interlock.spindle-speed", 0);
        machine.press(0.5);
        EXPECT_EQ(machine.applied("y"), 0) << "until the next press";
    }
}

TEST(InterlockCommissioning, AFunctionThatOnlyMeasuresMovesNoStage) {
    Machine machine;
    machine.pass("stage", 0);
    machine.pass("stage", 1);
    machine.bench.run(1);
    machine.bench.set("interlock.spindle-speed", 1000);
    machine.bench.set("interlock.trial-measures", true);
    machine.bench.set("interlock.trial-function", 0);
    machine.press(2);
    EXPECT_EQ(machine.bench.get("interlock.function-enable-0"), 1);
    EXPECT_EQ(machine.applied("x"), 0);
}

TEST(InterlockCommissioning, NoTrialBeyondTheLimitNorWhileAProgramRunsNorOff) {
    Machine machine;
    machine.bench.set("interlock.trial-stage", 0);
    machine.bench.set("interlock.trial-offset", 0.051);
    machine.press(1);
    EXPECT_EQ(machine.applied("x"), 0);
    machine.bench.set("interlock.trial-offset", 0.01);
    for (const char* pin : {"program-running", "cycle-running"}) {
        machine.bench.set(std::string("interlock.") + pin, 1);
        machine.press(1);
        EXPECT_EQ(machine.applied("x"), 0) << pin;
        machine.bench.set(std::string("interlock.") + pin, 0);
    }
    machine.bench.set("interlock.motion-enabled", 0);
    machine.press(1);
    EXPECT_EQ(machine.applied("x"), 0);
    machine.bench.set("interlock.motion-enabled", 1);
    machine.bench.set("interlock.trial-stage", 17);
    machine.press(1);
    EXPECT_EQ(machine.applied("x"), 0);
    machine.bench.set("interlock.trial-stage", -1);
    machine.press(0.1);
    machine.bench.set("interlock.trial-stage", 0);
    machine.press(1);
    EXPECT_NEAR(machine.applied("x"), 0.01, 1e-6);
}

TEST(InterlockCommissioning, AFunctionActsOnTrialAndStopsAtOnceThereafter) {
    Machine machine;
    machine.bench.set("interlock.program-running", 1);
    machine.pass("stage", 0);
    machine.bench.set("interlock.trial-function", 0);
    machine.press(1);
    EXPECT_EQ(machine.applied("x"), 0);  // the stage of Y is held
    machine.pass("stage", 1);
    machine.press(1);
    EXPECT_EQ(machine.status(), none);
    EXPECT_NEAR(machine.applied("x"), 0.01, 1e-6);
    machine.bench.run(1.5);
    EXPECT_EQ(machine.status(), held);
    EXPECT_EQ(machine.applied("x"), 0);
}

}  // namespace
}  // namespace plumb
