// SPDX-License-Identifier: GPL-2.0-or-later
// interlock with the stages that it arms, and what they do when it has gone: unloaded, or not called any
// more.
#include "tests/support/bench.hpp"

#include <cmath>
#include <string>

namespace plumb {
namespace {

constexpr double count = 0.1 * um;
constexpr double ramp_rate = 0.1;  // mm/s, the default of both stages

enum class Gone { unloaded, not_called };

// Function 0 has Z and Y by external offsets, function 1 has X and U between motion and drive.
struct Machine {
    Machine() {
        bench.command("loadrt threads name1=servo-thread period1=1000000");
        bench.command("loadrt axis_offset names=z-stage,y-stage");
        bench.command("loadrt external_offset names=z-axis,y-axis");
        bench.command("loadrt joint_offset names=x-stage,u-stage");
        bench.command("loadrt motion_joint names=x-joint,u-joint");
        bench.command("loadrt or2 names=program,power,homing");
        bench.command("loadrt peers names=peers");
        for (const std::string word : {"function-state-0", "function-state-1"}) net(word, "peers." + word);
        net("cycle", "program.out");
        net("on", "power.out");
        net("homed", "homing.out");
        for (const char* function : {"program", "power", "homing"}) call(function);
        for (const std::string letter : {"z", "y"}) {
            const std::string stage = letter + "-stage.", axis = letter + "-axis.";
            net(letter + "-request", axis + "request " + stage + "offset-request");
            net(letter + "-offset", axis + "offset " + stage + "offset-in-force");
            net(letter + "-enabled", axis + "enabled " + stage + "motion-enabled");
            net(letter + "-counts", stage + "counts " + axis + "counts");
            net(letter + "-scale", stage + "counts-scale " + axis + "scale");
            net(letter + "-enable", stage + "offset-enable " + axis + "enable");
            net("homed", axis + "homed " + stage + "all-homed");
            net("on", axis + "on");
            net(letter + "-state", stage + "state");
            net(letter + "-permit", stage + "permit");
        }
        for (const std::string letter : {"x", "u"}) {
            const std::string stage = letter + "-stage.", joint = letter + "-joint.";
            for (const char* setting :
                 {"min-limit -100", "max-limit 100", "joint-acceleration 2000", "offset-acceleration 1000"})
                bench.command("setp " + stage + setting);
            net(letter + "-homed", joint + "homed " + stage + "homed");
            net(letter + "-enabled", joint + "enabled " + stage + "motion-enabled");
            net(letter + "-position", joint + "command " + stage + "position");
            net(letter + "-command", joint + "motor-command " + stage + "joint-command");
            net(letter + "-drive", stage + "drive-command " + stage + "drive-feedback");
            net(letter + "-feedback", stage + "joint-feedback " + joint + "motor-feedback");
            net("on", joint + "on");
            net(letter + "-state", stage + "state");
            net(letter + "-permit", stage + "permit");
        }
        load_interlock();
        for (const char* function :
             {"z-axis.update", "y-axis.update", "x-stage.update-feedback", "u-stage.update-feedback",
              "x-joint.update", "u-joint.update", "peers.update", "z-stage.update", "y-stage.update",
              "x-stage.update", "u-stage.update", "interlock.update"})
            call(function);
        bench.command("start");
        for (const char* letter : {"z", "y"})
            bench.expect("abs(x_rate) <= " + std::to_string(1001), {{"x", std::string(letter) + "-counts"}});
    }

    void net(const std::string& signal, const std::string& pins) {
        bench.command("net " + signal + " " + pins);
    }
    void call(const std::string& function) { bench.command("addf " + function + " servo-thread"); }

    void load_interlock() {
        bench.command("loadrt interlock names=interlock functions=2 stages=4");
        for (const auto& [signal, pin] :
             std::vector<std::pair<std::string, std::string>>{{"on", "motion-enabled"},
                                                              {"homed", "all-homed"},
                                                              {"cycle", "cycle-running"},
                                                              {"function-state-0", "function-state-0"},
                                                              {"function-state-1", "function-state-1"},
                                                              {"z-state", "stage-state-0"},
                                                              {"y-state", "stage-state-1"},
                                                              {"x-state", "stage-state-2"},
                                                              {"u-state", "stage-state-3"},
                                                              {"z-permit", "stage-permit-0"},
                                                              {"y-permit", "stage-permit-1"},
                                                              {"x-permit", "stage-permit-2"},
                                                              {"u-permit", "stage-permit-3"},
                                                              {"no-homing", "homing-inhibit"}})
            net(signal, "interlock." + pin);
        bench.set("interlock.function-switch-0", 1);
        bench.set("interlock.function-switch-1", 1);
    }

    // On and homed, Z armed with 50 um, and X with 30 um in force. Y was cleared, and waits for the next
    // cycle.
    void hold_offsets() {
        bench.set("power.in0", 1);
        bench.set("x-joint.home", 1);
        bench.set("u-joint.home", 1);
        bench.run(0.1);
        bench.set("homing.in0", 1);
        bench.run(0.1);
        bench.set("z-stage.offset-0", 50 * um);
        bench.set("x-stage.offset-0", 30 * um);
        start_cycle();
        bench.set("y-stage.clear", 1);
        bench.run(0.1);
        bench.set("y-stage.clear", 0);
        bench.run(1);
        expect_held();
        EXPECT_TRUE(bench.get("no-homing"));
        bench.set("y-stage.offset-0", 40 * um);  // from now on wanted, and not permitted
        for (const char* letter : {"x", "u"})
            bench.expect("abs(x_rate) <= " + std::to_string(ramp_rate + 1e-6),
                         {{"x", std::string(letter) + "-stage.applied-offset"}});
        bench.run(0.1);
    }

    void expect_held() {
        EXPECT_NEAR(bench.get("z-offset"), 50 * um, count);
        EXPECT_EQ(bench.get("y-offset"), 0);
        EXPECT_NEAR(bench.get("x-stage.applied-offset"), 30 * um, 1e-12);
        EXPECT_EQ(bench.get("u-stage.applied-offset"), 0);
        EXPECT_FALSE(bench.get("y-stage.armed"));
    }

    void start_cycle() {
        for (const double running : {0, 1}) {
            bench.set("program.in0", running);
            bench.run(0.05);
        }
    }

    void lose(Gone how) {
        bench.command(how == Gone::unloaded ? "unloadrt interlock" : "delf interlock.update servo-thread");
        bench.run(0.02);
    }

    void return_from(Gone how) {
        if (how == Gone::unloaded) load_interlock();
        call("interlock.update");
    }

    Bench bench{Bench::Thread::none, with_specimens()};
};

class InterlockGone : public testing::TestWithParam<Gone> {
protected:
    Machine machine;
    Bench& bench = machine.bench;
};

TEST_P(InterlockGone, NothingIsArmedAndOffsetsHold) {
    machine.hold_offsets();
    machine.lose(GetParam());
    bench.set("x-stage.offset-0", -80 * um);  // the function behind X goes on
    bench.set("u-stage.offset-0", 60 * um);   // and that of U begins
    bench.set("z-stage.offset-0", -20 * um);
    bench.run(2);
    machine.expect_held();
    for (int n = 0; n < 3; ++n) {
        machine.start_cycle();
        bench.run(1);
        machine.expect_held();
    }
    EXPECT_EQ(bench.get("x-stage.fault-code"), 7);
    EXPECT_EQ(bench.get("u-stage.fault-code"), 7);
    EXPECT_EQ(bench.get("z-stage.fault-code"), 8);
    EXPECT_FALSE(bench.get("z-stage.armed"));
    EXPECT_TRUE(bench.get("no-homing"));  // which is right: X still has its offset
}

TEST_P(InterlockGone, OffAndOnMovesNothingAndArmsNothing) {
    machine.hold_offsets();
    machine.lose(GetParam());
    bench.set("x-stage.offset-0", -80 * um);
    bench.set("power.in0", 0);
    bench.run(0.1);
    const double z = bench.get("z-axis.position");
    bench.set("power.in0", 1);
    for (int n = 0; n < 3; ++n) {
        machine.start_cycle();
        bench.run(1);
        EXPECT_FALSE(bench.get("z-stage.armed"));
        EXPECT_FALSE(bench.get("y-stage.armed"));
        EXPECT_EQ(bench.get("z-axis.position"), z);
        EXPECT_NEAR(bench.get("x-stage.applied-offset"), 30 * um, 1e-12);
    }
}

TEST_P(InterlockGone, HomedAnewTheOffsetsHold) {
    machine.hold_offsets();
    machine.lose(GetParam());
    for (const double homed : {0, 1}) {
        bench.set("homing.in0", homed);
        bench.set("x-joint.home", homed);
        bench.run(1);
        EXPECT_NEAR(bench.get("x-stage.applied-offset"), 30 * um, 1e-12);
        EXPECT_FALSE(bench.get("z-stage.armed"));
        EXPECT_NEAR(bench.get("z-offset"), 50 * um, count);
        EXPECT_TRUE(bench.get("no-homing"));
    }
}

TEST_P(InterlockGone, WhenItReturnsXGoesOnByItsRampAndYAndZWithTheNextCycle) {
    machine.hold_offsets();
    machine.lose(GetParam());
    bench.set("x-stage.offset-0", -80 * um);
    bench.set("z-stage.offset-0", -20 * um);
    bench.run(1);
    machine.return_from(GetParam());
    bench.run(0.5);
    EXPECT_LT(bench.get("x-stage.applied-offset"), -10 * um);
    EXPECT_TRUE(bench.get("interlock.ramping"));
    bench.run(1.5);
    EXPECT_NEAR(bench.get("x-stage.applied-offset"), -80 * um, 1e-12);
    EXPECT_EQ(bench.get("x-stage.fault-code"), 0);
    EXPECT_FALSE(bench.get("y-stage.armed"));  // the cycle that runs is not a start
    EXPECT_EQ(bench.get("y-offset"), 0);
    EXPECT_NEAR(bench.get("z-offset"), 50 * um, count);
    machine.start_cycle();
    bench.run(1);
    EXPECT_NEAR(bench.get("y-offset"), 40 * um, count);
    EXPECT_NEAR(bench.get("z-offset"), -20 * um, count);
}

// Its function was never added to the thread.
TEST(InterlockNeverCalled, NothingIsApplied) {
    Machine machine;
    Bench& bench = machine.bench;
    bench.command("delf interlock.update servo-thread");
    bench.set("power.in0", 1);
    bench.set("x-joint.home", 1);
    bench.set("homing.in0", 1);
    bench.set("z-stage.offset-0", 50 * um);
    bench.set("x-stage.offset-0", 30 * um);
    for (int n = 0; n < 3; ++n) {
        machine.start_cycle();
        bench.run(1);
        EXPECT_EQ(bench.get("z-offset"), 0);
        EXPECT_EQ(bench.get("x-stage.applied-offset"), 0);
    }
}

TEST(InterlockWithStages, StartIsNoFault) {
    Machine machine;
    for (const char* stage : {"x", "u", "z", "y"})
        machine.bench.expect("fault == 0", {{"fault", std::string(stage) + "-stage.fault-code"}});
    machine.bench.run(1);
}

INSTANTIATE_TEST_SUITE_P(How, InterlockGone, testing::Values(Gone::unloaded, Gone::not_called),
                         [](const auto& how) {
                             return how.param == Gone::unloaded ? "Unloaded" : "NotCalled";
                         });

}  // namespace
}  // namespace plumb
