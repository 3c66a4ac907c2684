// SPDX-License-Identifier: GPL-2.0-or-later
// axis_offset before a model of LinuxCNC's external offsets; axis_offset_linuxcnc_test.py has it before
// LinuxCNC itself.
#include "tests/support/bench.hpp"
#include "tests/support/live.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double count = 0.1 * um;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// A stage and its axis, e.g. z-stage and z-axis, on the servo thread.
void wire(Bench& bench, const std::string& letter) {
    const std::string stage = letter + "-stage", axis = letter + "-axis";
    const auto net = [&](const std::string& from, const std::string& to) {
        bench.command("net " + letter + from.substr(from.find('.') + 1) + " " + from + " " + to);
    };
    net(axis + ".request", stage + ".offset-request");
    net(axis + ".offset", stage + ".offset-in-force");
    net(axis + ".limited", stage + ".offset-limited");
    net(axis + ".enabled", stage + ".motion-enabled");
    net(stage + ".counts", axis + ".counts");
    net(stage + ".counts-scale", axis + ".scale");
    net(stage + ".offset-enable", axis + ".enable");
    net(stage + ".offset-clear", axis + ".clear");
    bench.command("newsig " + letter + "homed bit");
    bench.command("net " + letter + "homed " + axis + ".homed " + stage + ".all-homed");
    bench.command("addf " + axis + ".update servo-thread");
    bench.command("addf " + stage + ".update servo-thread");
}

// Cycles start twice a second, and the offset is on its way.
void bring_to_life(Bench& bench) {
    bench.command("loadrt threads name1=servo-thread period1=1000000");
    bench.command("loadrt axis_offset names=z-stage interlock=no");
    bench.command("loadrt external_offset names=z-axis");
    bench.command("loadrt siggen names=cycles");
    bench.command("loadrt comp names=starts");
    bench.command("addf cycles.update servo-thread");
    bench.command("addf starts servo-thread");
    wire(bench, "z");
    bench.command("setp cycles.frequency 2");
    bench.command("net cycles cycles.square starts.in1");
    bench.command("net starts starts.out z-stage.arm");
    bench.set("z-axis.on", 1);
    bench.set("zhomed", 1);
    bench.set("z-stage.offset-0", 0.05);
    bench.set("z-stage.guest-scale", 0.001);
    bench.command("start");
    bench.run(0.1);
    bench.set("z-stage.guest-counts", 20);
    bench.run(1.1);
}

// One count a millisecond is max-rate: the steps of the counts are no faster.
const Live live{
    {{"axis_offset", "z-stage"}},
    bring_to_life,
    3.5,
    3,
    {{{"z-axis.on", {1, 0}},
      {"zhomed", {1, 0}},
      {"z-axis.joint-mode", {0, 1}},
      {"z-axis.program", {0, 5, -5}}},
     {},
     // A cycle starts in the meantime, and arms it: unless the machine was homed with an offset in force.
     [](Bench& bench) {
         bench.run(2);
         std::vector<std::string> complaints;
         const double own = bench.get("z-axis.offset") - bench.get("z-stage.guest-request");
         if (bench.get("z-stage.fault") == 0 && !(std::abs(own - 0.05) <= 1.1 * count))
             complaints.push_back("the own offset is " + std::to_string(own));
         return complaints;
     }}};

struct Machine {
    explicit Machine(double unit = 1, long nanoseconds = 1000000) : period(static_cast<double>(nanoseconds)) {
        bench.command("loadrt threads name1=servo-thread period1=" + std::to_string(nanoseconds));
        bench.command(std::string("loadrt axis_offset names=z-stage,y-stage interlock=no") +
                      (unit != 1 ? " unit=inch" : ""));
        bench.command("loadrt external_offset names=z-axis,y-axis");
        wire(bench, "z");
        wire(bench, "y");
        for (const char* pin : {"z-axis.max-velocity", "z-axis.max-acceleration"})
            bench.set(pin, unit * bench.get(pin));
        bench.command("start");
    }

    void set(const std::string& pin, double value) { bench.set("z-stage." + pin, value); }
    double get(const std::string& pin) { return bench.get("z-stage." + pin); }
    double in_force() { return bench.get("z-axis.offset"); }
    double position() { return bench.get("z-axis.position"); }

    // Lets time pass, and returns how far the axis has moved meanwhile, there and back.
    double run(double seconds) {
        const std::vector<double> z = bench.trace(seconds, {"z-axis.position"}).column("z-axis.position");
        double travel = 0;
        for (std::size_t i = 1; i < z.size(); ++i) travel += std::abs(z[i] - z[i - 1]);
        return travel;
    }
    double turn(bool on) {
        bench.set("z-axis.on", on);
        return run(0.05);
    }
    double home(bool homed = true) {
        bench.set("zhomed", homed);
        return run(0.05);
    }
    double pulse(const std::string& pin) {
        set(pin, 1);
        const double travel = run(0.01);
        set(pin, 0);
        return travel + run(0.01);
    }
    // On, homed, and with this offset in force.
    void apply(double offset) {
        const double most = std::max(1000.0, 1e9 / period) * 1.001;  // max-rate, in counts
        bench.expect("abs(counts_rate) <= " + std::to_string(most), {{"counts", "z-stage.counts"}});
        turn(true);
        home();
        set("offset-0", offset);
        pulse("arm");
        run(1);
        EXPECT_NEAR(in_force(), offset, count);
    }

    Bench bench{Bench::Thread::none, with_specimens()};
    double period;  // ns
};

TEST(AxisOffset, OffsetFollowsItsSourceByMaxRateAndToACount) {
    Machine machine;
    machine.apply(50 * um);
    machine.set("offset-0", -20.03 * um);
    machine.run(0.5);
    EXPECT_NEAR(machine.in_force(), 0, 1 * um);
    machine.run(0.5);
    EXPECT_NEAR(machine.in_force(), -20.03 * um, count);
    EXPECT_NEAR(machine.get("applied-offset"), machine.in_force(), 1e-12);
    EXPECT_LT(machine.run(10), 1e-12);
    EXPECT_FALSE(machine.get("fault"));
    EXPECT_EQ(machine.bench.get("y-axis.offset"), 0);
    EXPECT_EQ(machine.bench.get("y-stage.counts"), 0);
}

// The later ones remain, where they can.
TEST(AxisOffset, StatusNamesTheFirstThatKeepsTheAxisFromItsOffset) {
    enum { fault = 1, off, probing = 4, machine_off, not_homed };
    enum { applies = 40, refused, takes_back, waits, limited, ramping, nothing };
    Machine machine;
    const auto expect = [&](const char* when, int status) {
        machine.run(0.003);
        EXPECT_EQ(machine.get("status-code"), status) << when;
        const bool somebody = status == fault || status == refused || status == limited;
        EXPECT_EQ(machine.get("attention"), somebody) << when;
    };
    machine.turn(true);
    machine.home();
    expect("no source", nothing);
    machine.set("offset-0", 50 * um);
    expect("no cycle yet", waits);
    machine.pulse("arm");
    expect("the way", ramping);
    machine.run(1);
    expect("all of it", applies);
    machine.set("offset-0", 300 * um);
    machine.run(3);
    expect("max-offset", limited);
    machine.set("allow-probing", 1);
    machine.set("motion-type", 5);
    machine.set("offset-0", 20 * um);
    expect("a probing move that may contain the offset", probing);
    machine.set("motion-type", 0);
    machine.set("allow-probing", 0);
    machine.run(3);
    machine.set("enable", 0);
    expect("the way to off", ramping);
    machine.run(3);
    expect("switched off", off);
    machine.set("enable", 1);
    machine.run(3);
    machine.set("clear", 1);
    expect("the way back", takes_back);
    machine.set("clear", 0);
    machine.pulse("arm");
    machine.run(3);
    machine.home(false);
    expect("not homed", not_homed);
    machine.turn(false);
    expect("the machine is off", machine_off);
    machine.turn(true);
    machine.home();
    machine.pulse("arm");
    machine.run(3);
    machine.set("motion-type", 5);
    expect("a probing move with the offset in force", refused);
    machine.set("max-offset", -1);
    expect("a fault", fault);
}

// The heartbeat of an interlock that is called, or, if `still`, is not any more.
void beat(Machine& machine, double seconds, bool still = false) {
    const int periods = static_cast<int>(std::lround(seconds / 0.001));
    double beats = machine.get("heartbeat");
    for (int i = 0; i < periods; ++i) {
        if (!still) machine.set("heartbeat", ++beats);
        machine.run(0.001);
    }
}

TEST(AxisOffset, HeartbeatThatStandsStillHoldsTheOffsetAndArmsNothing) {
    Machine machine;
    machine.apply(0);
    machine.set("heartbeat", 7);
    beat(machine, 0.05);
    EXPECT_FALSE(machine.get("armed"));  // by a heartbeat that stood still at first
    machine.pulse("arm");
    EXPECT_FALSE(machine.get("armed"));  // it stood still during the pulse
    machine.set("arm", 0);
    beat(machine, 0.05);
    machine.set("arm", 1);
    machine.set("offset-0", 50 * um);
    beat(machine, 0.2);
    EXPECT_TRUE(machine.get("armed"));
    EXPECT_TRUE(machine.get("ramping"));
    EXPECT_TRUE(machine.get("in-force"));
    const double before = machine.in_force();
    beat(machine, 1, true);
    EXPECT_EQ(machine.get("fault-code"), 8);
    EXPECT_FALSE(machine.get("armed"));
    EXPECT_FALSE(machine.get("ramping"));
    EXPECT_NEAR(machine.in_force(), before, 2 * um);  // ten periods, and LinuxCNC's lag
    const double held = machine.in_force();
    machine.set("arm", 0);
    beat(machine, 0.1, true);
    machine.set("arm", 1);
    beat(machine, 1, true);
    EXPECT_EQ(machine.in_force(), held);
    machine.set("arm", 0);
    beat(machine, 0.5);
    EXPECT_EQ(machine.in_force(), held);
    EXPECT_EQ(machine.get("fault-code"), 0);
    machine.set("arm", 1);
    beat(machine, 1);
    EXPECT_NEAR(machine.in_force(), 50 * um, count);
    EXPECT_FALSE(machine.get("ramping"));
}

TEST(AxisOffset, ClearTakesTheOffsetBackWithoutAnInterlock) {
    Machine machine;
    machine.apply(30 * um);
    machine.set("heartbeat", 7);
    machine.run(0.1);
    machine.set("clear", 1);
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 0, count);
    EXPECT_FALSE(machine.get("in-force"));
}

TEST(AxisOffset, SumsItsSourcesEachWithItsLastGoodValue) {
    Machine machine;
    machine.apply(0);
    for (const auto& [source, value] : {std::pair("offset-0", 50), {"offset-1", -20}, {"offset-2", 7}})
        machine.set(source, value * um);
    machine.set("offset-3", -12 * um);
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 25 * um, count);
    machine.set("offset-1", not_a_number);
    EXPECT_EQ(machine.run(0.5), 0);
    EXPECT_EQ(machine.get("fault-code"), 1);
    machine.set("offset-3", 1000.1);
    EXPECT_EQ(machine.run(0.5), 0);
    machine.set("offset-0", 60 * um);
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 35 * um, count);
    machine.set("offset-1", 0);
    machine.set("offset-3", 0);
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 67 * um, count);
    EXPECT_FALSE(machine.get("fault"));
}

TEST(AxisOffset, NothingMovesBeforeACycleStarts) {
    Machine machine;
    machine.set("offset-0", 50 * um);
    double travel = machine.run(0.1) + machine.pulse("arm");  // which is no start while the machine is off
    travel += machine.turn(true) + machine.pulse("arm");      // nor before it is homed
    travel += machine.home() + machine.run(1);
    EXPECT_EQ(travel, 0);
    EXPECT_FALSE(machine.get("armed"));
    EXPECT_TRUE(machine.get("uncompensated"));
    machine.pulse("arm");
    EXPECT_TRUE(machine.get("armed"));
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 50 * um, count);
    EXPECT_FALSE(machine.get("uncompensated"));
}

TEST(AxisOffset, ArmThatIsTrueAlreadyIsNoStart) {
    Machine machine;
    machine.set("offset-0", 50 * um);
    machine.set("arm", 1);
    EXPECT_EQ(machine.run(0.1) + machine.turn(true) + machine.home() + machine.run(1), 0);
    EXPECT_EQ(machine.turn(false) + machine.turn(true) + machine.run(1), 0);
    EXPECT_FALSE(machine.get("armed"));
}

TEST(AxisOffset, LoadedWhileACycleRunsItWaitsForTheNext) {
    Bench bench(Bench::Thread::servo, with_specimens());
    bench.command("loadrt axis_offset names=z-stage interlock=no");
    bench.command("loadrt external_offset names=z-axis");
    bench.set("z-axis.on", 1);
    bench.set("z-stage.arm", 1);
    wire(bench, "z");
    bench.set("zhomed", 1);
    bench.set("z-stage.offset-0", 0.05);
    bench.run(1);
    EXPECT_FALSE(bench.get("z-stage.armed"));
    EXPECT_EQ(bench.get("z-axis.offset"), 0);
}

TEST(AxisOffset, MachineOffDisarmsAndTurningOnMovesNothing) {
    Machine machine;
    machine.apply(50 * um);
    for (int n = 0; n < 20; ++n) {
        EXPECT_EQ(machine.turn(false) + machine.turn(true) + machine.run(0.2), 0);
        EXPECT_EQ(machine.get("applied-offset"), 0);
        EXPECT_FALSE(machine.get("armed"));
        EXPECT_TRUE(machine.get("uncompensated"));
        const double before = machine.position();
        machine.pulse("arm");
        machine.run(1);
        EXPECT_NEAR(machine.position(), before + 50 * um, 1.1 * count) << n;
        EXPECT_FALSE(machine.get("uncompensated"));
    }
}

TEST(AxisOffset, TurningOffWhileTheOffsetMovesLosesNothing) {
    Machine machine;
    machine.apply(0);
    for (int n = 0; n < 10; ++n) {
        machine.set("offset-0", (n % 2 ? 50 : -50) * um);
        machine.pulse("arm");
        machine.run(0.2003 + n * 0.001);
        machine.turn(false);
        EXPECT_EQ(machine.turn(true), 0);
        machine.pulse("arm");
        machine.run(1);
        EXPECT_NEAR(machine.in_force(), (n % 2 ? 50 : -50) * um, count);
    }
}

TEST(AxisOffset, UnhomingDisarmsAndHomedWithAnOffsetInForceIsAFault) {
    Machine machine;
    machine.apply(50 * um);
    EXPECT_EQ(machine.home(false), 0);
    EXPECT_FALSE(machine.get("armed"));
    EXPECT_EQ(machine.get("fault-code"), 0);
    EXPECT_EQ(machine.home() + machine.pulse("arm") + machine.run(1), 0);
    EXPECT_FALSE(machine.get("armed"));
    EXPECT_EQ(machine.get("fault-code"), 6);

    machine.turn(false);
    machine.turn(true);
    EXPECT_EQ(machine.pulse("arm") + machine.run(1), 0);  // the home is not the right one yet
    EXPECT_EQ(machine.get("fault-code"), 6);
    machine.home(false);
    machine.home();
    EXPECT_EQ(machine.get("fault-code"), 0);
    machine.pulse("arm");
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 50 * um, count);
}

TEST(AxisOffset, UnhomedAndHomedWithoutOffsetWaitsForACycleStart) {
    Machine machine;
    machine.apply(0);
    machine.home(false);
    machine.set("offset-0", 50 * um);
    EXPECT_EQ(machine.home() + machine.run(1), 0);
    EXPECT_EQ(machine.get("fault-code"), 0);
    machine.pulse("arm");
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 50 * um, count);
}

TEST(AxisOffset, ClearTakesTheOffsetBackByMaxRateAndDisarms) {
    Machine machine;
    machine.apply(50 * um);
    machine.set("clear", 1);
    machine.run(0.25);
    EXPECT_NEAR(machine.in_force(), 25 * um, 1 * um);
    EXPECT_FALSE(machine.get("armed"));
    machine.run(0.5);
    EXPECT_EQ(machine.bench.get("z-axis.request"), 0);
    EXPECT_NEAR(machine.in_force(), 0, 0.01 * count);
    EXPECT_TRUE(machine.get("uncompensated"));
    const double counts = machine.get("counts");
    EXPECT_EQ(machine.pulse("arm") + machine.run(10), 0);
    EXPECT_EQ(machine.get("counts"), counts);  // nothing winds up meanwhile
    machine.set("clear", 0);
    EXPECT_EQ(machine.run(1), 0);
    EXPECT_FALSE(machine.get("fault"));
    machine.pulse("arm");
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 50 * um, count);
}

TEST(AxisOffset, DisabledTakesTheOffsetBackByMaxRate) {
    Machine machine;
    machine.apply(50 * um);
    machine.set("enable", 0);
    machine.run(0.25);
    EXPECT_NEAR(machine.in_force(), 25 * um, 1 * um);
    machine.run(0.5);
    EXPECT_NEAR(machine.in_force(), 0, 0.01 * count);
    EXPECT_FALSE(machine.get("uncompensated"));
    machine.set("enable", 1);
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 50 * um, count);
}

// Trap: another program clears or disables the external offset, and the counts run away for ever.
TEST(AxisOffset, CountsThatAreNotTakenAreAFaultAndDoNotWindUp) {
    for (const char* pin : {"clear", "enable", "counts", "scale"}) {
        SCOPED_TRACE(pin);
        Machine machine;
        machine.apply(50 * um);
        machine.bench.command(std::string("unlinkp z-axis.") + pin);
        if (std::string(pin) == "clear") machine.bench.set("z-axis.clear", 1);
        if (std::string(pin) == "enable") machine.bench.set("z-axis.enable", 0);
        if (std::string(pin) == "scale") machine.bench.set("z-axis.scale", 0);
        const double counts = machine.get("counts");
        machine.set("offset-0", 80 * um);
        machine.run(1);
        EXPECT_EQ(machine.get("fault-code"), 4);
        EXPECT_FALSE(machine.get("armed"));
        EXPECT_TRUE(machine.get("uncompensated"));
        EXPECT_NEAR(machine.get("counts"), counts, 1);
    }
}

TEST(AxisOffset, RequestThatIsNotWiredMovesTheAxisByACountAtMost) {
    Machine machine;
    machine.bench.command("unlinkp z-stage.offset-request");
    machine.turn(true);
    machine.home();
    machine.set("offset-0", 50 * um);
    machine.pulse("arm");
    EXPECT_LT(machine.run(1), 1.01 * count);
    EXPECT_EQ(machine.get("fault-code"), 4);
}

TEST(AxisOffset, AfterAFaultTheNextCycleStartGoesOn) {
    Machine machine;
    machine.apply(50 * um);
    machine.bench.command("unlinkp z-axis.enable");
    machine.bench.set("z-axis.enable", 0);
    machine.set("offset-0", 80 * um);
    machine.run(0.1);
    EXPECT_EQ(machine.get("fault-code"), 4);
    machine.bench.command("net zoffset-enable z-axis.enable");
    EXPECT_EQ(machine.run(1), 0);
    machine.pulse("arm");
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 80 * um, count);
    EXPECT_FALSE(machine.get("fault"));
}

TEST(AxisOffset, SoftLimitHoldsTheAxisAndTheOffsetComesBackBehindIt) {
    Machine machine;
    machine.bench.set("z-axis.limit", 200);
    machine.apply(50 * um);
    machine.bench.set("z-axis.program", 200);
    machine.run(0.1);
    EXPECT_EQ(machine.position(), 200);
    EXPECT_TRUE(machine.get("limited"));
    EXPECT_TRUE(machine.get("uncompensated"));
    const double counts = machine.get("counts");
    machine.set("offset-0", 100 * um);
    EXPECT_EQ(machine.run(10), 0);
    EXPECT_EQ(machine.get("counts"), counts);
    EXPECT_TRUE(machine.get("armed"));
    machine.bench.set("z-axis.program", 199);
    machine.run(0.05);
    EXPECT_NEAR(machine.position(), 199 + 50 * um, 6 * um);  // the offset of before, at once
    machine.run(1);
    EXPECT_NEAR(machine.position(), 199 + 100 * um, count);
    EXPECT_FALSE(machine.get("limited"));
    EXPECT_FALSE(machine.get("uncompensated"));
}

TEST(AxisOffset, WhatIsTakenBackAtASoftLimitDoesNotComeBack) {
    Machine machine;
    machine.bench.set("z-axis.limit", 200);
    machine.apply(50 * um);
    machine.bench.set("z-axis.program", 200);
    machine.run(0.1);
    machine.set("offset-0", 0);
    EXPECT_EQ(machine.run(1), 0);
    machine.bench.set("z-axis.program", 199);
    machine.run(1);
    EXPECT_NEAR(machine.position(), 199, 0.01 * count);
}

TEST(AxisOffset, InJointModeItWaits) {
    Machine machine;
    machine.apply(50 * um);
    machine.bench.set("z-axis.joint-mode", 1);
    machine.set("offset-0", 100 * um);
    EXPECT_EQ(machine.run(10), 0);
    EXPECT_TRUE(machine.get("uncompensated"));
    machine.bench.set("z-axis.joint-mode", 0);
    machine.run(0.03);
    EXPECT_NEAR(machine.in_force(), 50 * um, 6 * um);  // no jump by all that has gathered
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 100 * um, count);
}

TEST(AxisOffset, ProbingHoldsTheOffset) {
    Machine machine;
    machine.set("allow-probing", 1);
    machine.apply(50 * um);
    machine.set("motion-type", 5);
    machine.run(0.01);
    machine.set("offset-0", 80 * um);
    EXPECT_EQ(machine.run(1), 0);
    machine.set("clear", 1);
    EXPECT_EQ(machine.run(1), 0);
    EXPECT_FALSE(machine.get("probing-refused"));
    machine.set("clear", 0);
    machine.pulse("arm");
    machine.set("motion-type", 2);
    machine.run(1);
    EXPECT_NEAR(machine.in_force(), 80 * um, count);
}

TEST(AxisOffset, ProbingIsRefusedWhileAnOffsetIsInForce) {
    Machine machine;
    machine.apply(0);
    machine.set("motion-type", 5);
    machine.set("offset-0", 50 * um);
    machine.run(1);
    EXPECT_FALSE(machine.get("probing-refused"));
    EXPECT_EQ(machine.in_force(), 0);
    machine.set("motion-type", 1);
    machine.run(1);
    EXPECT_FALSE(machine.get("probing-refused"));
    machine.set("motion-type", 5);
    machine.run(0.001);
    EXPECT_TRUE(machine.get("probing-refused"));
    machine.run(1);
    EXPECT_TRUE(machine.get("probing-refused"));
    machine.set("motion-type", 0);
    machine.run(0.002);
    EXPECT_FALSE(machine.get("probing-refused"));
}

TEST(AxisOffset, BadInputsAreNamedAndMoveNothing) {
    const double huge = 1e308, infinite = std::numeric_limits<double>::infinity();
    const std::vector<std::pair<std::string, int>> inputs{{"offset-0", 1},        {"offset-request", 2},
                                                          {"offset-in-force", 2}, {"scale", 3},
                                                          {"max-offset", 3},      {"max-rate", 3}};
    Machine machine;
    machine.apply(50 * um);
    for (const auto& [input, code] : inputs)
        for (const double bad : {not_a_number, huge, -huge, infinite}) {
            SCOPED_TRACE(input + " " + std::to_string(bad));
            const double own = machine.get(input);
            const bool wired = code == 2;
            const std::string signal = input == "offset-request" ? "zrequest" : "zoffset";
            if (wired) machine.bench.command("unlinkp z-stage." + input);
            machine.set(input, bad);
            EXPECT_EQ(machine.run(0.2), 0);
            EXPECT_EQ(machine.get("fault-code"), code);
            EXPECT_TRUE(machine.get("armed"));
            machine.set(input, own);
            if (wired) machine.bench.command("net " + signal + " z-stage." + input);
            EXPECT_EQ(machine.run(0.2), 0);
            EXPECT_FALSE(machine.get("fault"));
        }
}

TEST(AxisOffset, OffsetStaysWithinMaxOffsetAndReportsIt) {
    Machine machine;
    machine.apply(0);
    machine.set("offset-0", -5);
    machine.run(2);
    EXPECT_NEAR(machine.in_force(), -150 * um, count);
    EXPECT_TRUE(machine.get("limited"));
    EXPECT_TRUE(machine.get("uncompensated"));
    EXPECT_TRUE(machine.get("armed"));
}

TEST(AxisOffset, CountsThatDoNotFitInto32BitsAreAFault) {
    Machine machine;
    machine.set("scale", 1e-7);
    machine.set("max-offset", 200);
    machine.set("max-rate", 10);
    machine.bench.set("z-axis.max-acceleration", 20000);
    machine.turn(true);
    machine.home();
    machine.set("offset-0", 180);
    machine.pulse("arm");
    machine.bench.run(20);
    EXPECT_NEAR(machine.in_force(), 180, 1e-6);
    machine.set("offset-0", 0);
    machine.turn(false);  // the next 180 mm begin where these ended
    machine.turn(true);
    machine.set("offset-0", 180);
    machine.pulse("arm");
    machine.bench.run(20);
    EXPECT_EQ(machine.get("fault-code"), 5);
    EXPECT_FALSE(machine.get("armed"));
    EXPECT_NEAR(machine.get("counts"), std::pow(2, 31), 1.1e5);
    EXPECT_EQ(machine.run(1), 0);
}

TEST(AxisOffset, WorksInInchesAndAtOtherPeriods) {
    for (const long period : {500000, 2000000})
        for (const double unit : {1.0, 1 / 25.4}) {
            SCOPED_TRACE(std::to_string(period) + " " + std::to_string(unit));
            Machine machine(unit, period);
            machine.apply(unit * 50 * um);
            machine.set("offset-0", 0);
            machine.run(0.25);
            EXPECT_NEAR(machine.in_force() / unit, 25 * um, 1 * um);
            machine.run(0.5);
            EXPECT_NEAR(machine.in_force() / unit, 0, count);
        }
}

}  // namespace
}  // namespace plumb
