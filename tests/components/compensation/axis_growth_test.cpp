// SPDX-License-Identifier: GPL-2.0-or-later
// axis_growth by its pins: the law of its README, and what it does with bad sensors.
#include "tests/support/bench.hpp"
#include "tests/support/live.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// A warm spindle that is switched on and off, so that the offsets are under way again and again.
void bring_to_life(Bench& bench) {
    const Folder folder;
    bench.source(folder.write("live.hal", R"(
loadrt threads name1=servo-thread period1=1000000
loadrt axis_growth names=axis-growth interlock=no sensors=4
loadrt siggen names=warmth
setp warmth.frequency 0.5
setp warmth.amplitude 5
setp warmth.offset 30
setp axis-growth.x-growth-0 0.001
setp axis-growth.y-growth-0 -0.002
setp axis-growth.z-growth-0 0.004
setp axis-growth.x-slope-1 1e-5
setp axis-growth.z-speed-growth 0.01
setp axis-growth.x-position 100
setp axis-growth.y-position 200
setp axis-growth.z-position -100
setp axis-growth.temperature-1 23
setp axis-growth.spindle-speed 5000
setp axis-growth.smoothing 0.1
setp axis-growth.turning-time 1
setp axis-growth.stopped-time 1
setp axis-growth.hold-time 1
setp axis-growth.max-rate 0.05
setp axis-growth.all-homed 1
setp axis-growth.enable 1
net spindle warmth.square => axis-growth.temperature-0
addf warmth.update servo-thread
addf axis-growth.update servo-thread
start
)"));
    bench.run(8);
}

const Live live{{{"axis_growth", "axis-growth"}},
                bring_to_life,
                4,
                12,
                {{{"warmth.amplitude", {5, 0}}}, {}, [](Bench& bench) {
                     bench.set("warmth.amplitude", 0);
                     bench.run(12);
                     std::vector<std::string> complaints;
                     for (const char* axis : {"x", "y", "z"}) {
                         const double offset = bench.get(std::string("axis-growth.") + axis + "-offset");
                         const double growth = bench.get(std::string("axis-growth.") + axis + "-growth");
                         if (!(std::abs(offset - growth) <= 0.2 * um && growth != 0))
                             complaints.push_back(std::string(axis) + ": " + std::to_string(offset) +
                                                  " for a growth of " + std::to_string(growth));
                     }
                     return complaints;
                 }}};

// Homed, enabled, at once certain, and fast, so that a test need not wait.
struct Machine {
    explicit Machine(const std::string& options = "") {
        bench.command("loadrt axis_growth names=g interlock=no sensors=4 " + options);
        bench.command("addf g.update servo-thread");
        bench.command("start");
        set({{"all-homed", 1},
             {"enable", 1},
             {"smoothing", 0},
             {"max-rate", 10},
             {"x-sigma", 0.0001},
             {"y-sigma", 0.0001},
             {"z-sigma", 0.0001}});
    }
    void set(const std::string& pin, double value) { bench.set("g." + pin, value); }
    void set(const std::map<std::string, double>& values) {
        for (const auto& [pin, value] : values) set(pin, value);
    }
    double get(const std::string& pin) { return bench.get("g." + pin); }
    void run(double seconds) { bench.run(seconds); }

    Bench bench{Bench::Thread::servo};
};

TEST(AxisGrowth, FollowsTheLawOfTemperaturesAndPosition) {
    Machine m;
    m.set({{"x-growth-0", 0.002},
           {"x-growth-1", -0.001},
           {"x-slope-1", 12e-6},
           {"x-pivot", 50},
           {"reference-0", 20},
           {"reference-1", 21},
           {"temperature-0", 30},
           {"temperature-1", 24},
           {"x-position", 250}});
    m.run(0.1);
    EXPECT_NEAR(m.get("x-offset"), 0.002 * 10 - 0.001 * 3 + 12e-6 * 3 * 200, 1e-9);
    EXPECT_EQ(m.get("y-offset"), 0);
    EXPECT_EQ(m.get("authority"), 1);
    EXPECT_FALSE(m.get("doubt"));
    m.set("x-position", 249.9);  // slower than max-speed
    m.run(0.001);
    EXPECT_NEAR(m.get("x-offset"), 0.017 + 12e-6 * 3 * 199.9, 1e-9) << "motion is followed at once";
}

TEST(AxisGrowth, HasTheRowsOfItsSensors) {
    Bench bench{Bench::Thread::servo};
    bench.command("loadrt axis_growth names=one,three sensors=1,3");
    for (const char* stem : {"temperature", "temperature-valid", "temperature-age", "x-growth",
                             "y-growth-sigma", "z-slope", "reference", "rise-low", "rise-high"}) {
        const std::string name = stem;
        bench.get("one." + name + "-0");
        EXPECT_ANY_THROW(bench.get("one." + name + "-1")) << name;
        bench.get("three." + name + "-2");
        EXPECT_ANY_THROW(bench.get("three." + name + "-3")) << name;
    }
}

TEST(AxisGrowth, FollowsTheSpindleWithTheTimeOfTurningAndOfRest) {
    Machine m;
    m.set({{"z-speed-growth", 0.04},
           {"reference-speed", 8000},
           {"speed-exponent", 2},
           {"turning-time", 10},
           {"stopped-time", 40},
           {"spindle-speed", -4000}});
    m.run(10);
    const double grown = 0.04 * 0.25 * (1 - std::exp(-1));
    EXPECT_NEAR(m.get("z-offset"), grown, 1e-6);
    m.set("spindle-speed", 0);
    m.run(40);
    EXPECT_NEAR(m.get("z-offset"), grown * std::exp(-1), 1e-6);
}

TEST(AxisGrowth, NothingButMotionMovesAnAxisFasterThanMaxRate) {
    Machine m;
    m.set({{"x-growth-0", 0.005},
           {"x-slope-0", 1e-5},
           {"z-growth-0", 0.003},
           {"max-rate", 0.01},
           {"temperature-0", 28}});
    m.bench.expect("x_rate * x_rate + z_rate * z_rate <= 1.00001e-4",
                   {{"x", "g.x-offset"}, {"z", "g.z-offset"}});
    m.run(2);
    EXPECT_TRUE(m.get("ramping"));
    const std::vector<std::pair<std::string, double>> changes{
        {"temperature-0", 22}, {"x-growth-0", -0.005}, {"x-position", 300},  // a jump
        {"x-pivot", 100},      {"x-slope-0", -1e-5},   {"reference-0", 15},
        {"max-offset", 0.001}, {"enable", 0}};
    for (const auto& [pin, value] : changes) {
        m.set(pin, value);
        m.run(0.7);
    }
    m.run(5);
    EXPECT_EQ(m.get("x-offset"), 0);
}

TEST(AxisGrowth, ALostTemperatureHoldsAndThenTakesItsOffsetBack) {
    for (const auto& [pin, value] : std::map<std::string, double>{{"temperature-0", nan},
                                                                  {"temperature-valid-0", 0},
                                                                  {"temperature-age-0", 61},
                                                                  {"temperature-0", 600}}) {
        SCOPED_TRACE(pin);
        Machine m;
        m.set({{"z-growth-0", 0.004}, {"temperature-0", 30}, {"hold-time", 10}});
        m.run(0.1);
        ASSERT_NEAR(m.get("z-offset"), 0.04, 1e-9);
        m.set(pin, value);
        m.run(9);
        EXPECT_NEAR(m.get("z-offset"), 0.04, 1e-9);
        EXPECT_EQ(m.get("doubt-code"), 1);
        EXPECT_NEAR(m.get("lost-age"), 9, 0.01);
        m.run(6);
        EXPECT_NEAR(m.get("z-offset"), 0.02, 1e-4);
        EXPECT_EQ(m.get("doubt-code"), 2);
        m.run(6);
        EXPECT_EQ(m.get("z-offset"), 0);
        m.set({{"temperature-0", 32}, {"temperature-valid-0", 1}, {"temperature-age-0", 0}});
        m.run(0.1);
        EXPECT_NEAR(m.get("z-offset"), 0.048, 1e-9);
    }
}

// The spindle, which the law reads, and the bed and the air, which judge it.
struct Judged : Machine {
    Judged() {
        set({{"z-growth-0", 0.004},
             {"hold-time", 10},
             {"expected-fast-0", 8},
             {"expected-fast-1", -4},
             {"expected-fast-2", -4},
             {"turning-time", 1},
             {"stopped-time", 1},
             {"speed-exponent", 1},
             {"reference-speed", 5000}});
        for (const char* sensor : {"0", "1", "2"})
            set({{std::string("expected-limit-") + sensor, 2}, {std::string("temperature-") + sensor, 20}});
        run(0.1);
        set({{"spindle-speed", 5000}, {"temperature-0", 28}});
        // the temperature leads the drive of the spindle by a second
        set("smoothing", 1);
        run(10);
    }
};

TEST(AxisGrowth, ATemperatureThatContradictsTheOthersHoldsAndThenTakesItsOffsetBack) {
    Judged m;
    EXPECT_FALSE(m.get("doubt"));
    EXPECT_NEAR(m.get("z-offset"), 0.032, 1e-5);
    m.set("temperature-0", 48);
    m.run(9);
    EXPECT_EQ(m.get("doubt-code"), 5) << "temperature 0";
    EXPECT_LT(m.get("z-offset"), 0.032 + 0.004 * 2.1) << "2 K are the limit";
    m.run(20);
    EXPECT_EQ(m.get("z-offset"), 0);
    EXPECT_EQ(m.get("doubt-code"), 5) << "it still says which";
    m.set("temperature-0", 28);
    m.run(10);
    EXPECT_FALSE(m.get("doubt"));
    EXPECT_NEAR(m.get("z-offset"), 0.032, 1e-5);
}

TEST(AxisGrowth, InACycleAnOffsetByAWrongTemperatureHolds) {
    Judged m;
    m.set({{"cycle-running", 1}, {"temperature-0", 48}});
    m.run(60);
    EXPECT_EQ(m.get("doubt-code"), 5);
    EXPECT_GT(m.get("z-offset"), 0.031);
    EXPECT_LT(m.get("z-offset"), 0.032 + 0.004 * 2.1);
    m.set("cycle-running", 0);
    m.run(30);
    EXPECT_EQ(m.get("z-offset"), 0);
}

TEST(AxisGrowth, AWrongTemperatureThatTheLawDoesNotReadIsNamedAndMovesNothing) {
    Judged m;
    m.set("temperature-2", 100);
    m.run(30);
    EXPECT_EQ(m.get("doubt-code"), 7) << "temperature 2";
    EXPECT_NEAR(m.get("z-offset"), 0.032, 1e-5);
}

TEST(AxisGrowth, AShopThatWarmsAllSensorsIsNoFault) {
    Judged m;
    m.set({{"temperature-0", 36}, {"temperature-1", 28}, {"temperature-2", 28}});
    m.run(30);
    EXPECT_FALSE(m.get("doubt"));
}

TEST(AxisGrowth, ASensorThatTheLawDoesNotReadMayBeDead) {
    Machine m;
    m.set({{"z-growth-0", 0.004}, {"temperature-0", 30}, {"temperature-valid-1", 0}, {"temperature-3", nan}});
    m.run(0.1);
    EXPECT_NEAR(m.get("z-offset"), 0.04, 1e-9);
    EXPECT_FALSE(m.get("doubt"));
}

TEST(AxisGrowth, WithoutEverAValidTemperatureNothingMoves) {
    Machine m;
    m.set({{"z-growth-0", 0.004}, {"temperature-valid-0", 0}, {"temperature-0", 30}});
    m.run(1);
    EXPECT_EQ(m.get("z-offset"), 0);
    EXPECT_EQ(m.get("z-growth"), 0);
    EXPECT_EQ(m.get("authority"), 0);
}

TEST(AxisGrowth, AnUncertainGrowthIsAppliedAndInDoubt) {
    Machine m;
    m.set({{"z-growth-0", 0.004}, {"temperature-0", 25}, {"z-sigma", 0.0049}});
    m.run(0.1);
    EXPECT_FALSE(m.get("doubt"));
    m.set("z-sigma", 0.0051);
    m.run(0.1);
    EXPECT_EQ(m.get("doubt-code"), 4) << "more than harmless";
    EXPECT_NEAR(m.get("z-offset"), 0.02, 1e-9);
    EXPECT_EQ(m.get("authority"), 1);
}

TEST(AxisGrowth, SigmaIsThatOfTheChangesSinceTheZeroWasSet) {
    Machine m;
    m.set({{"z-growth-0", 0.004},
           {"z-growth-sigma-0", 0.001},
           {"z-growth-sigma-1", 0.002},
           {"z-speed-growth", 0.01},
           {"z-speed-sigma", 0.003},
           {"turning-time", 1},
           {"temperature-0", 28},
           {"temperature-1", 23}});
    m.run(0.1);
    EXPECT_NEAR(m.get("z-growth-sigma"), std::hypot(0.0001, std::hypot(0.008, 0.006)), 1e-9);
    m.set("zero-set", 1);
    m.run(0.1);
    EXPECT_NEAR(m.get("z-growth-sigma"), 0.0001, 1e-9);
    EXPECT_NEAR(m.get("z-offset"), 0.032, 1e-9) << "the zero contains the offset: nothing moves";
    m.set({{"temperature-0", 33}, {"temperature-1", 24}, {"spindle-speed", 5000}});
    m.run(30);
    EXPECT_NEAR(m.get("z-growth-sigma"), std::hypot(std::hypot(0.0001, 0.003), std::hypot(0.005, 0.002)),
                1e-6);
    m.run(1);
    EXPECT_GT(m.get("z-growth-sigma"), 0.004) << "only an edge sets it";
}

TEST(AxisGrowth, BeyondTheRiseOfTheTestTheOffsetIsUncertain) {
    Machine m;
    m.set({{"z-growth-0", 0.004}, {"rise-high-0", 10}, {"temperature-0", 32}});
    m.run(0.1);
    EXPECT_NEAR(m.get("z-growth-sigma"), std::hypot(0.0001, 0.3 * 0.008), 1e-9);
    EXPECT_NEAR(m.get("z-offset"), 0.048, 1e-9);
    EXPECT_FALSE(m.get("doubt")) << "by less than is harmless";
    m.set({{"temperature-0", 22}, {"rise-high-0", 0}, {"rise-low-0", -5}, {"z-sigma", 0.015}});
    m.run(0.1);
    EXPECT_EQ(m.get("doubt-code"), 4) << "the law is uncertain, and its range hardly matters";
    m.set({{"temperature-0", 14}, {"z-sigma", 0.0001}, {"rise-low-0", 60}, {"rise-high-0", 65}});
    m.run(0.1);
    EXPECT_EQ(m.get("doubt-code"), 3);
    EXPECT_NEAR(m.get("z-offset"), -0.024, 1e-9);
}

TEST(AxisGrowth, InACycleItsAuthorityNeverFalls) {
    Machine m;
    m.set({{"z-growth-0", 0.004}, {"temperature-0", 30}, {"hold-time", 10}, {"cycle-running", 1}});
    m.run(0.1);
    m.set("temperature-valid-0", 0);
    m.run(30);
    EXPECT_NEAR(m.get("z-offset"), 0.04, 1e-9);
    EXPECT_EQ(m.get("doubt-code"), 2);
    m.set("cycle-running", 0);
    m.run(0.1);
    EXPECT_EQ(m.get("z-offset"), 0);
}

TEST(AxisGrowth, SettingsThatAreOutOfRangeLeaveTheLastGoodSetInForce) {
    Machine m;
    m.set({{"x-growth-0", 0.001}, {"temperature-0", 30}});
    m.run(0.1);
    for (const auto& [pin, value] : std::map<std::string, double>{{"x-growth-0", 2},
                                                                  {"x-slope-3", nan},
                                                                  {"max-rate", 0},
                                                                  {"rise-low-2", 601},
                                                                  {"turning-time", 0},
                                                                  {"y-sigma", -1}}) {
        const double before = m.get(pin);
        m.set({{pin, value}, {"x-growth-1", 0.5}});
        m.run(0.01);
        EXPECT_EQ(m.get("fault-code"), 3) << pin;
        EXPECT_NEAR(m.get("x-offset"), 0.01, 1e-9) << pin;
        m.set({{pin, before}, {"x-growth-1", 0}});
        m.run(0.01);
        EXPECT_FALSE(m.get("fault")) << pin;
    }
}

TEST(AxisGrowth, MaxOffsetBoundsEachAxis) {
    Machine m;
    m.set({{"x-growth-0", 0.03}, {"y-growth-0", -0.03}, {"temperature-0", 30}});
    m.run(0.2);
    EXPECT_EQ(m.get("x-offset"), 0.15);
    EXPECT_EQ(m.get("y-offset"), -0.15);
    EXPECT_TRUE(m.get("limited"));
}

TEST(AxisGrowth, OnAnInchMachineTheSameLawIsInInches) {
    Machine m("unit=inch");
    EXPECT_NEAR(m.get("max-offset"), 0.15 / 25.4, 1e-12);
    m.set({{"x-growth-0", 0.002 / 25.4}, {"temperature-0", 30}});
    m.run(0.1);
    EXPECT_NEAR(m.get("x-offset"), 0.02 / 25.4, 1e-9);
}

// A law of Z, and a surface that is fixed to the machine: where it is touched, LinuxCNC counts truth -
// offset.
struct Touched : Machine {
    Touched() {
        set({{"z-growth-0", 0.004}, {"temperature-0", 20}, {"harmless", 0.005}});
        run(0.1);
    }
    // A touch while the machine has grown by this.
    double touch(double grown) {
        set({{"touched-position", -200 + grown - get("z-offset")}, {"touched-axis", 3}});
        run(0.01);
        set("touched-axis", 0);
        run(0.01);
        return get("touch-code");
    }
};
enum Status { moved_status = 48, revoked_status };
enum Outcome { reference = 1, no_reference, first, corrected, moved, revoked, not_now };

TEST(AxisGrowth, TwoTouchesOfAReferenceCorrectTheLawBetweenParts) {
    Touched m;
    EXPECT_EQ(m.touch(0), reference);
    EXPECT_TRUE(m.get("touch-news"));
    m.set({{"cycle-running", 1}, {"temperature-0", 30}});
    m.run(2);
    EXPECT_FALSE(m.get("touch-news"));
    EXPECT_EQ(m.touch(0.05), first);
    EXPECT_EQ(m.touch(0.05), corrected);
    const double change = m.get("z-touch-change");
    EXPECT_GT(change, 0.004) << "of 10 um that the law leaves, as they may not last";
    EXPECT_LT(change, 0.009);
    EXPECT_NEAR(m.get("z-offset"), 0.040, 1e-9) << "not in the part";
    m.set("cycle-running", 0);
    m.run(0.1);
    EXPECT_NEAR(m.get("z-offset"), 0.040 + change, 1e-5);
    EXPECT_EQ(m.get("z-touch-change"), change) << "for the message";
    EXPECT_EQ(m.get("x-offset"), 0);
    EXPECT_EQ(m.touch(0.05), first) << "the touch contains the new offset";
    EXPECT_EQ(m.touch(0.05), corrected);
    EXPECT_GT(m.get("z-offset"), 0.0475) << "the error lasts";
    m.set("temperature-0", 35);
    m.run(0.1);
    EXPECT_NEAR(m.get("z-offset"), 0.0745, 0.002) << "the scale goes on";
}

TEST(AxisGrowth, AWorkZeroOfAWarmMachineKeepsTheCorrectionThatItContains) {
    Touched m;
    m.set({{"slow-time", 10}, {"z-growth-sigma-0", 0.002}});
    m.touch(0);
    m.set("temperature-0", 30);
    m.run(0.1);
    const double without = m.get("z-growth-sigma");
    m.touch(0.05);
    EXPECT_EQ(m.touch(0.05), corrected);
    m.run(0.1);
    EXPECT_LT(m.get("z-growth-sigma"), without) << "by the touches";
    const double before = m.get("z-offset");
    EXPECT_GT(before, 0.044);
    m.set("zero-set", 1);
    m.run(20);
    EXPECT_NEAR(m.get("z-offset"), before, 0.0005) << "it does not fade";
    EXPECT_EQ(m.touch(0.05), reference) << "the spindle stands";
    m.run(0.1);
    EXPECT_NEAR(m.get("z-offset"), before, 0.0005) << "the zero contains the error";
    m.set("temperature-0", 31);
    m.run(0.1);
    EXPECT_NEAR(m.get("z-offset"), before + 0.004, 0.0005);
}

TEST(AxisGrowth, ALawThatTwoTouchesFindWorseThanNoneIsRevoked) {
    Touched m;
    m.touch(0);
    m.set("temperature-0", 30);
    m.run(0.1);
    EXPECT_EQ(m.touch(0), first);
    EXPECT_EQ(m.touch(0), revoked);
    m.run(0.1);
    EXPECT_EQ(m.get("z-offset"), 0);
    EXPECT_EQ(m.get("doubt-code"), 10);
    EXPECT_EQ(m.get("status-code"), revoked_status);
    m.set("z-growth-0", 0.002);
    m.run(0.1);
    EXPECT_NEAR(m.get("z-offset"), 0.020, 1e-9) << "another law begins anew";
    EXPECT_FALSE(m.get("doubt"));
    EXPECT_EQ(m.touch(0.02), reference);
}

TEST(AxisGrowth, TouchesThatDisagreeOrCannotCountChangeNothing) {
    Touched m;
    m.touch(0);
    m.set("temperature-0", 30);
    m.run(0.1);
    m.touch(0.04);
    EXPECT_EQ(m.touch(0.06), moved);
    EXPECT_EQ(m.get("doubt-code"), 9);
    EXPECT_EQ(m.get("status-code"), moved_status);
    EXPECT_NEAR(m.get("z-offset"), 0.04, 1e-9);
    for (const double bad : {nan, 1e9}) {
        m.set({{"touched-position", bad}, {"touched-axis", 3}});
        m.run(0.01);
        m.set("touched-axis", 0);
        m.run(0.01);
        EXPECT_EQ(m.get("touch-code"), not_now);
    }
    m.set("temperature-valid-0", 0);
    m.run(0.01);
    EXPECT_EQ(m.touch(0.04), not_now);
    EXPECT_NEAR(m.get("z-offset"), 0.04, 1e-9);
}

}  // namespace
}  // namespace plumb
