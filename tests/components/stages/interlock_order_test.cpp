// SPDX-License-Identifier: GPL-2.0-or-later
// interlock, where a user has added functions in a wrong order: a fault, and offsets hold until it is mended.
#include "tests/support/bench.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

namespace plumb {
namespace {

using testing::HasSubstr;

constexpr double order = 4;     // fault-code
constexpr double found = 2;     // s: once a second, and twice
constexpr double max_rate = 1;  // mm/s, the default of joint_offset

using Names = std::vector<std::string>;

// Two joints with stages, corrected by square; z-stage brings its offset in through LinuxCNC. The stand-ins
// of motion are stock modules.
struct Machine {
    static Names right() {
        return {"motion-command-handler",
                "x-stage.update-feedback",
                "y-stage.update-feedback",
                "motion-controller",
                "square.update",
                "z-axis.update",
                "spare",
                "x-stage.update",
                "y-stage.update",
                "z-stage.update",
                "interlock.update"};
    }

    explicit Machine(const Names& functions = right(), const client::Start& its_host = with_specimens())
        : bench(Bench::Thread::none, its_host) {
        bench.command("loadrt threads name1=servo-thread period1=1000000 name2=slow-thread period2=10000000");
        bench.command("loadrt lowpass names=motion-command-handler,motion-controller,spare");
        bench.command("loadrt or2 names=program");
        bench.command("loadrt squareness names=square");
        bench.command("loadrt joint_offset names=x-stage,y-stage");
        bench.command("loadrt axis_offset names=z-stage");
        bench.command("loadrt external_offset names=z-axis");
        bench.command("loadrt interlock names=interlock stages=3");
        bench.command("net square-permit interlock.function-permit-0 square.permit");
        bench.command("net square-state square.state interlock.function-state-0");
        for (const std::string stage : {"x-stage", "y-stage", "z-stage"}) {
            const std::string number = std::to_string(stage[0] - 'x');
            bench.command("net " + stage + "-permit interlock.stage-permit-" + number + " " + stage + ".permit");
            bench.command("net " + stage + "-state " + stage + ".state interlock.stage-state-" + number);
        }
        for (const std::string letter : {"x", "y"}) {
            for (const char* setting : {"min-limit -100", "max-limit 100", "joint-acceleration 2000",
                                        "offset-acceleration 1000", "homed true", "motion-enabled true"})
                bench.command("setp " + letter + "-stage." + setting);
            bench.expect("abs(x_rate) <= " + std::to_string(max_rate + 1e-6),
                         {{"x", letter + "-stage.applied-offset"}});
        }
        for (const char* net :
             {"request z-axis.request z-stage.offset-request", "force z-axis.offset z-stage.offset-in-force",
              "on z-axis.enabled z-stage.motion-enabled", "counts z-stage.counts z-axis.counts",
              "scale z-stage.counts-scale z-axis.scale", "enable z-stage.offset-enable z-axis.enable"})
            bench.command(std::string("net z-") + net);
        for (const char* pin : {"z-axis.on", "z-axis.homed", "z-stage.all-homed", "interlock.motion-enabled",
                                "interlock.all-homed", "interlock.function-switch-0"})
            bench.set(pin, 1);
        for (const std::string& function : functions) call(function);
        call("program", "slow-thread");
        bench.command("start");
    }

    void call(const std::string& function, const std::string& thread_and_place = "servo-thread") {
        bench.command("addf " + function + " " + thread_and_place);
    }
    void take_away(const std::string& function) { bench.command("delf " + function + " servo-thread"); }

    void start_cycle() {
        for (const double running : {0, 1}) {
            bench.set("interlock.cycle-running", running);
            bench.run(0.05);
        }
    }

    // X has 30 um, and Z 50 um.
    void apply_offsets() {
        bench.run(0.1);
        bench.set("x-stage.offset-0", 30 * um);
        bench.set("z-stage.offset-0", 50 * um);
        start_cycle();
        bench.run(2);
        EXPECT_NEAR(bench.get("x-stage.applied-offset"), 30 * um, 1e-9);
        EXPECT_NEAR(bench.get("z-axis.offset"), 50 * um, um);
        EXPECT_TRUE(bench.get("z-stage.armed"));
        expect_no_fault();
    }

    // The sources go on, and nothing moves.
    void expect_held(bool z_stage_is_called = true) {
        EXPECT_EQ(bench.get("interlock.fault-code"), order);
        const double x = bench.get("x-stage.applied-offset"), y = bench.get("y-stage.applied-offset"),
                     z = bench.get("z-axis.offset");
        bench.set("x-stage.offset-0", -60 * um);
        bench.set("y-stage.offset-0", 40 * um);
        bench.set("z-stage.offset-0", -20 * um);
        for (int n = 0; n < 2; ++n) {
            start_cycle();
            bench.run(1);
            EXPECT_FALSE(bench.get("interlock.arm"));
            EXPECT_FALSE(bench.get("interlock.compensated"));
            EXPECT_FALSE(z_stage_is_called && bench.get("z-stage.armed"));
            EXPECT_EQ(bench.get("x-stage.applied-offset"), x);
            EXPECT_EQ(bench.get("y-stage.applied-offset"), y);
            EXPECT_EQ(bench.get("z-axis.offset"), z);
        }
        EXPECT_EQ(bench.get("interlock.fault-code"), order);
    }

    void expect_no_fault() {
        for (const char* component : {"interlock", "x-stage", "y-stage", "z-stage"})
            EXPECT_EQ(bench.get(std::string(component) + ".fault-code"), 0) << component;
    }

    // After all is mended.
    void expect_applied() {
        bench.run(1.1);
        EXPECT_EQ(bench.get("interlock.fault-code"), 0);
        bench.set("x-stage.offset-0", 20 * um);
        bench.set("y-stage.offset-0", 40 * um);
        bench.set("z-stage.offset-0", -20 * um);
        start_cycle();
        bench.run(3);
        expect_no_fault();
        EXPECT_NEAR(bench.get("x-stage.applied-offset"), 20 * um, 1e-9);
        EXPECT_NEAR(bench.get("y-stage.applied-offset"), 40 * um, 1e-9);
        EXPECT_NEAR(bench.get("z-axis.offset"), -20 * um, um);
        EXPECT_TRUE(bench.get("interlock.compensated"));
    }

    Bench bench;
};

TEST(InterlockOrder, RightOrderIsNoFaultInAnyPeriod) {
    Machine machine;
    machine.bench.expect("fault == 0", {{"fault", "interlock.fault-code"}});
    machine.apply_offsets();
    machine.bench.run(20);
}

// A function that stands before another one that it belongs behind.
struct Wrong {
    std::string name, function, before;
};
void PrintTo(const Wrong& wrong, std::ostream* out) {
    *out << wrong.name;
}

Names with(const std::string& function, const std::string& before) {
    Names result = Machine::right();
    result.erase(std::find(result.begin(), result.end(), function));
    result.insert(std::find(result.begin(), result.end(), before), function);
    return result;
}

class InterlockOrder : public testing::TestWithParam<Wrong> {
protected:
    const Names functions = with(GetParam().function, GetParam().before);
};

TEST_P(InterlockOrder, FromTheStartNothingIsAppliedAndNoCycleIsArmed) {
    Machine machine(functions);
    machine.bench.run(found);
    machine.expect_held();
    machine.bench.run(10);
    EXPECT_EQ(machine.bench.get("x-stage.applied-offset"), 0);
}

TEST_P(InterlockOrder, WhileItRunsOffsetsHoldUntilItIsMended) {
    Machine machine;
    machine.apply_offsets();
    for (const std::string& function : functions) machine.take_away(function);
    for (const std::string& function : functions) machine.call(function);
    machine.bench.run(found);
    machine.expect_held();
    EXPECT_TRUE(machine.bench.get("square.enabled")) << "a function waits with its offset behind the stages";
    for (const std::string& function : functions) machine.take_away(function);
    for (const std::string& function : Machine::right()) machine.call(function);
    machine.expect_applied();
}

INSTANTIATE_TEST_SUITE_P(
    Each, InterlockOrder,
    testing::Values(Wrong{"StageBeforeMotion", "x-stage.update", "motion-controller"},
                    Wrong{"StageInFrontOfAll", "y-stage.update", "motion-command-handler"},
                    Wrong{"StageBeforeItsSource", "z-stage.update", "square.update"},
                    Wrong{"SourceBeforeMotion", "square.update", "motion-controller"},
                    Wrong{"MotionBeforeFeedback", "motion-controller", "x-stage.update-feedback"},
                    Wrong{"InterlockBeforeAStage", "interlock.update", "z-stage.update"},
                    Wrong{"InterlockBeforeTheSource", "interlock.update", "square.update"}),
    [](const auto& wrong) { return wrong.param.name; });

TEST(InterlockOrderMessage, NamesBothFunctionsAndTheThreadOnce) {
    testing::internal::CaptureStderr();
    {
        client::Start start = with_specimens();
        start.show_output = true;
        Machine machine(with("x-stage.update", "motion-controller"), start);
        machine.bench.run(10);
    }
    const std::string output = testing::internal::GetCapturedStderr();
    const std::string sentence =
        "interlock: x-stage.update runs before motion-controller and square.update in servo-thread; it "
        "belongs after them.\n";
    const std::size_t at = output.find(sentence);
    ASSERT_NE(at, std::string::npos) << output;
    EXPECT_EQ(output.find("interlock:", at + 1), std::string::npos) << output;
}

TEST(InterlockOrderMessage, OfManyIsShort) {
    testing::internal::CaptureStderr();
    {
        client::Start start = with_specimens();
        start.show_output = true;
        Names functions = Machine::right();
        std::reverse(functions.begin(), functions.end());
        Machine machine(functions, start);
        machine.bench.run(10);
    }
    const std::string output = testing::internal::GetCapturedStderr();
    EXPECT_THAT(output,
                HasSubstr(" more functions are not where they belong; run plumb doctor --running.\n"));
    EXPECT_EQ(std::count(output.begin(), output.end(), ';'), 4) << output;
}

TEST(InterlockOrderOfThreads, AStageInAnotherThreadIsAFaultUntilItIsMended) {
    Machine machine;
    machine.apply_offsets();
    machine.take_away("y-stage.update");
    machine.call("y-stage.update", "slow-thread");
    machine.bench.run(found);
    machine.expect_held();
    machine.bench.command("delf y-stage.update slow-thread");
    machine.call("y-stage.update", "servo-thread 9");
    machine.expect_applied();
}

TEST(InterlockOrderOfThreads, ASourceInAnotherThreadIsNone) {
    Machine machine;
    machine.take_away("square.update");
    machine.call("square.update", "slow-thread");
    machine.bench.expect("fault == 0", {{"fault", "interlock.fault-code"}});
    machine.apply_offsets();
}

class InterlockNoThread : public testing::TestWithParam<std::string> {};

TEST_P(InterlockNoThread, IsAFaultUntilTheFunctionIsAdded) {
    Machine machine;
    machine.apply_offsets();
    const Names right = Machine::right();
    const auto place = std::find(right.begin(), right.end(), GetParam()) - right.begin() + 1;
    machine.take_away(GetParam());
    machine.bench.run(found);
    machine.expect_held(GetParam() != "z-stage.update");
    machine.call(GetParam(), "servo-thread " + std::to_string(place));
    machine.expect_applied();
}

INSTANTIATE_TEST_SUITE_P(Each, InterlockNoThread,
                         testing::Values("x-stage.update", "z-stage.update", "square.update"),
                         [](const auto& name) { return name.param.substr(0, 1); });

// From loadrt on.
TEST(InterlockOrderOfThreads, AComponentThatWasNeverAddedIsAFault) {
    Machine machine;
    machine.bench.command("loadrt chopping names=chop interlock=no");
    machine.bench.run(found);
    machine.expect_held();
    machine.call("chop.update", "servo-thread 5");
    machine.expect_applied();
}

TEST(InterlockOrderOfThreads, UnloadedItIsForgotten) {
    Machine machine;
    machine.bench.command("loadrt chopping names=chop interlock=no");
    machine.bench.run(found);
    machine.bench.command("unloadrt chopping");
    machine.expect_applied();
}

TEST(InterlockOrderOfThreads, FunctionsThatAreOnTheirWayAreNoFault) {
    Machine machine;
    machine.bench.expect("fault == 0", {{"fault", "interlock.fault-code"}});
    machine.apply_offsets();
    for (int n = 0; n < 20; ++n) {
        machine.take_away("square.update");
        machine.bench.run(0.35);
        machine.call("square.update", "servo-thread 5");
        machine.bench.run(1.7);
    }
}

TEST(InterlockOrderOfThreads, OfStandingThreadsIsNotJudged) {
    Machine machine(with("x-stage.update", "motion-controller"));
    machine.bench.command("stop");
    machine.bench.run(5);
    EXPECT_EQ(machine.bench.get("interlock.fault-code"), 0);
    machine.bench.command("start");
    machine.bench.run(found);
    EXPECT_EQ(machine.bench.get("interlock.fault-code"), order);
}

TEST(InterlockOrderOfThreads, TwoInterlocksBothHaveTheFault) {
    Machine machine;
    machine.bench.command("unloadrt interlock");
    machine.bench.command("loadrt interlock names=interlock,second");
    machine.call("interlock.update");
    machine.call("second.update");
    machine.bench.run(3);
    EXPECT_NE(machine.bench.get("interlock.fault-code"), order);  // none is netted
    EXPECT_NE(machine.bench.get("second.fault-code"), order);
    machine.take_away("y-stage.update");
    machine.call("y-stage.update", "servo-thread 1");
    machine.bench.run(found);
    EXPECT_EQ(machine.bench.get("interlock.fault-code"), order);
    EXPECT_EQ(machine.bench.get("second.fault-code"), order);
}

// A stroke does not end in the work because of a fault that costs it a period.
TEST(InterlockOrderOfThreads, ABusyFunctionFinishesFirstAndDoesNotBeginAgain) {
    Machine machine;
    Bench& bench = machine.bench;
    machine.apply_offsets();
    bench.set("interlock.program-running", 1);
    machine.take_away("square.update");
    machine.call("square.update");
    bench.run(found);
    EXPECT_EQ(bench.get("interlock.fault-code"), order);
    bench.set("x-stage.offset-0", 10 * um);
    bench.run(1);
    EXPECT_NEAR(bench.get("x-stage.applied-offset"), 10 * um, 1e-9);
    EXPECT_EQ(bench.get("x-stage.fault-code"), 0);
    bench.set("interlock.cycle-running", 0);
    bench.run(0.1);
    bench.set("interlock.cycle-running", 1);
    bench.run(0.1);
    EXPECT_FALSE(bench.get("interlock.arm"));
    bench.set("interlock.program-running", 0);
    bench.run(0.1);
    bench.set("interlock.program-running", 1);
    machine.expect_held();
}

}  // namespace
}  // namespace plumb
