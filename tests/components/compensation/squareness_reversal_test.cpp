// SPDX-License-Identifier: GPL-2.0-or-later
// squareness with tables whose errors differ by the direction of motion.
#include "tests/support/error_table_text.hpp"
#include "tests/support/module.hpp"
#include "tests/support/square.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <random>
#include <string>

namespace plumb {
namespace {

constexpr double nm = 1e-6;

std::string precise(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

// X loses 10 um, everywhere.
const char* const lost_motion = "X,EXX+,EXX-\n-600,-0.005,0.005\n600,-0.005,0.005\n";

// squareness with one file of tables.
struct WithTable {
    explicit WithTable(const std::string& table, const std::string& options = column_chain)
        : square(options + " table=" + folder.write("errors.csv", closed(table)).string()) {
        square.set("reversal-acceleration", 500);
    }
    // X goes from 0 to 1, and its turn has ended.
    void go_up() {
        square.go({0, 0, 0, 0});
        square.go({1, 0, 0, 0});
        square.run(0.05);
    }

    const Folder folder;
    Square square;
};

TEST(SquarenessReversal, LostMotionIsCorrectedInTheDirectionOfTheLastMove) {
    WithTable machine(lost_motion);
    Square& square = machine.square;
    square.go({0, 0, 0, 0});
    EXPECT_EQ(square.get("x-direction"), 0);
    EXPECT_EQ(square.get("x-correction"), 0);
    EXPECT_TRUE(square.get("direction-doubtful"));
    square.go({0.4, 0, 0, 0});
    square.go({0.5, 0, 0, 0});
    square.run(0.05);
    EXPECT_EQ(square.get("x-direction"), 1);
    EXPECT_NEAR(square.get("x-correction"), 5 * um, nm);
    EXPECT_FALSE(square.get("direction-doubtful"));
    square.go({0.4997, 0, 0, 0});
    square.run(0.05);
    EXPECT_NEAR(square.get("x-correction"), 5 * um, nm);
    square.go({0.4994, 0, 0, 0});  // small steps add up
    square.run(0.05);
    EXPECT_EQ(square.get("x-direction"), -1);
    EXPECT_NEAR(square.get("x-correction"), -5 * um, nm);
    EXPECT_EQ(square.get("y-correction"), 0);
}

TEST(SquarenessReversal, TheTurnTakesTheShortestTimeOfItsAccelerationAndIsInTheVelocity) {
    WithTable machine(lost_motion);
    Square& square = machine.square;
    square.set("reversal-rate", 5);
    machine.go_up();
    square.set("x-position", 0.9);
    const Table table = square.bench.trace(0.03, {"square.x-correction", "square.x-corrected-velocity"});
    const auto c = table.column("square.x-correction"), v = table.column("square.x-corrected-velocity");
    double fastest = 0, hardest = 0;
    std::size_t begin = 0, end = 0;
    for (std::size_t i = 2; i < c.size(); ++i) {
        const double rate = (c[i] - c[i - 1]) / 0.001, before = (c[i - 1] - c[i - 2]) / 0.001;
        fastest = std::max(fastest, std::abs(rate));
        hardest = std::max(hardest, std::abs(rate - before) / 0.001);
        EXPECT_NEAR(v[i], rate, 1e-6);
        if (begin == 0 && rate != 0) begin = i;
        if (rate != 0) end = i;
    }
    EXPECT_NEAR(c.back(), -5 * um, nm);
    EXPECT_LE(hardest, 500 * 1.0001);
    const double best = 2 * std::sqrt(0.01 / 500);  // s, to half way and back to rest
    EXPECT_NEAR(static_cast<double>(end - begin) * 0.001, best, 0.003);
    EXPECT_GT(fastest, 0.8 * std::sqrt(0.01 * 500));
    EXPECT_FALSE(square.get("ramping"));
}

TEST(SquarenessReversal, ATurnThatIsTurnedBackGoesOnFromItsValueAndSpeed) {
    WithTable machine(lost_motion);
    Square& square = machine.square;
    square.set({{"reversal-rate", 5}, {"reversal-acceleration", 100}});
    machine.go_up();
    square.bench.expect("abs(v_rate) <= 100.001", {{"v", "square.x-corrected-velocity"}});
    square.set("x-position", 0.9);
    square.run(0.008);  // of 20 ms: at its highest speed, almost
    EXPECT_NEAR(square.get("x-corrected-velocity"), -0.8, 0.11);
    square.set("x-position", 1);
    square.run(0.001);
    EXPECT_LT(square.get("x-corrected-velocity"), -0.5) << "it brakes first";
    square.run(0.05);
    EXPECT_NEAR(square.get("x-correction"), 5 * um, nm);
    EXPECT_EQ(square.get("x-corrected-velocity"), 0);
}

// Where nothing differs by direction it turns within a period; that speed must not stay.
TEST(SquarenessReversal, ATurnWhereNothingIsLostLeavesNoSpeed) {
    WithTable machine(
        "X,EXX+,EXX-\n-600,0,0\n-100,0,0\n0,0,0\n50,-0.005,0.005\n150,-0.005,0.005\n600,-0.005,0.005\n");
    Square& square = machine.square;
    square.set("max-speed", 1e5);
    square.bench.expect("abs(x) <= 0.0055", {{"x", "square.x-correction"}});
    square.bench.expect("abs(d) <= 1", {{"d", "square.x-direction"}});
    square.go({-400, 0, 0, 0});
    for (const double x : {-399.0, -400.0, -399.0, 300.0, 299.0, 300.0, 299.0, -400.0, -399.0}) {
        square.go({x, 0, 0, 0});
        square.run(0.05);
    }
    square.go({299, 0, 0, 0});
    square.go({298, 0, 0, 0});
    square.run(0.05);
    EXPECT_NEAR(square.get("x-correction"), -5 * um, nm);
}

// As a signal of the temperature drives it.
TEST(SquarenessReversal, AnAngleThatChangesInEachPeriodDelaysNoTurn) {
    WithTable machine(lost_motion);
    Square& square = machine.square;
    machine.go_up();
    square.set("x-position", 0.9);
    for (int i = 0; i < 16; ++i) {
        square.set("ea0y", 1e-9 * i);
        square.run(0.001);
    }
    EXPECT_EQ(square.get("x-direction"), -1);
    EXPECT_NEAR(square.get("x-correction"), -5 * um, nm);
}

TEST(SquarenessReversal, TheRateIsNotExceededAndAxesThatMoveOneJointShareIt) {
    WithTable machine(std::string(lost_motion) + "Y,EXY+,EXY-\n-600,-0.005,0.005\n600,-0.005,0.005\n");
    Square& square = machine.square;
    square.set({{"reversal-rate", 0.3}});
    square.go({0, 0, 0, 0});
    square.go({1, 1, 0, 0});
    square.run(0.1);
    square.set("x-position", 0.9);
    square.set("y-position", 0.9);
    const Table table = square.bench.trace(0.2, {"square.x-correction"});
    const auto c = table.column("square.x-correction");
    double fastest = 0, hardest = 0;
    for (std::size_t i = 2; i < c.size(); ++i) {
        fastest = std::max(fastest, std::abs(c[i] - c[i - 1]) / 0.001);
        hardest = std::max(hardest, std::abs(c[i] - 2 * c[i - 1] + c[i - 2]) / 1e-6);
    }
    EXPECT_LE(fastest, 0.3 * 1.001);
    EXPECT_LE(hardest, 500 * 1.001);
    EXPECT_EQ(square.get("x-direction"), -1);
    EXPECT_EQ(square.get("y-direction"), -1);
}

TEST(SquarenessReversal, StandstillEnableAndJumpsTurnNothing) {
    WithTable machine(lost_motion);
    Square& square = machine.square;
    machine.go_up();
    square.set("enable", 0);
    square.run(1);
    EXPECT_EQ(square.get("x-correction"), 0);
    EXPECT_EQ(square.get("x-direction"), 1);
    square.set("enable", 1);
    square.run(1);
    EXPECT_NEAR(square.get("x-correction"), 5 * um, nm);
    square.set("x-position", -300);  // within a period: as homing sets a joint anew
    square.run(0.5);
    EXPECT_EQ(square.get("x-direction"), 1);
    square.set("all-homed", 0);
    square.run(0.5);
    square.set("all-homed", 1);
    square.run(0.5);
    EXPECT_EQ(square.get("x-direction"), 1);
    square.set("motion-enabled", 0);
    square.run(0.01);
    EXPECT_FALSE(square.get("direction-doubtful"));
    square.set("motion-enabled", 1);
    square.run(0.01);
    EXPECT_TRUE(square.get("direction-doubtful"));
    EXPECT_EQ(square.get("x-direction"), 1);
    square.go({-299.98, 0, 0, 0});
    EXPECT_FALSE(square.get("direction-doubtful"));
}

// A screen shows the doubt; a cut in doubt is a message.
TEST(SquarenessReversal, ADoubtfulDirectionIsToldAndACutInItIsAMessage) {
    constexpr int corrects = 40, doubtful = 45, cut_in_doubt = 46, feed = 2;
    WithTable machine(lost_motion);
    Square& square = machine.square;
    square.go({0, 0, 0, 0});
    EXPECT_EQ(square.get("status-code"), doubtful);
    EXPECT_FALSE(square.get("attention"));
    square.set({{"motion-type", feed}, {"path-velocity", 10}, {"y-position", 1}});  // X stands
    square.run(0.15);
    EXPECT_EQ(square.get("status-code"), doubtful);
    square.run(0.1);
    EXPECT_EQ(square.get("status-code"), cut_in_doubt);
    EXPECT_TRUE(square.get("attention"));
    square.set({{"motion-type", 1}});  // a rapid; X still stands
    square.run(0.1);
    EXPECT_EQ(square.get("status-code"), cut_in_doubt);
    square.set("x-position", 0.0004);  // less than reversal-distance
    square.run(0.1);
    EXPECT_EQ(square.get("status-code"), cut_in_doubt);
    square.set("x-position", 0.02);
    square.run(0.1);
    EXPECT_EQ(square.get("status-code"), corrects);
    EXPECT_FALSE(square.get("attention"));
    square.set("motion-enabled", 0);
    square.run(0.01);
    square.set("motion-enabled", 1);
    square.run(0.01);
    EXPECT_EQ(square.get("status-code"), doubtful);            // it may have been pushed
    square.set({{"motion-type", feed}, {"x-position", 0.2}});  // a cut that moves X
    square.run(0.5);
    EXPECT_EQ(square.get("status-code"), corrects);
}

// A position that dithers by less than half of reversal-distance, as a following axis at rest: nothing
// creeps, turns or flips. PLUMB_REST_HOURS is the time, 24 for the whole day.
TEST(SquarenessReversal, AtRestNothingCreepsOrFlips) {
    const char* const hours = std::getenv("PLUMB_REST_HOURS");
    const double seconds = hours ? 3600 * std::atof(hours) : 60;
    for (const double amplitude : {0.0, 0.00024}) {
        WithTable machine(
            std::string(lost_motion) +
            "Y,EYY+,EYY-,EXY+,EXY-\n-600,-0.02,0.02,0.004,-0.004\n600,0.01,-0.01,-0.004,0.004\n");
        Square& square = machine.square;
        square.bench.command("loadrt siggen names=dither,other");
        square.go({100, 200, 0, 0});
        square.go({101, 199, 0, 0});
        const std::map<std::string, double> settings = {
            {"dither.offset", 101},   {"other.offset", 199},           {"dither.frequency", 7.3},
            {"other.frequency", 1.1}, {"dither.amplitude", amplitude}, {"other.amplitude", amplitude}};
        for (const auto& [pin, value] : settings) square.bench.set(pin, value);
        for (const char* line :
             {"net x dither.sine => square.x-position", "net y other.square => square.y-position",
              "addf dither.update servo-thread", "addf other.update servo-thread"})
            square.bench.command(line);
        square.run(0.5);
        const double most = amplitude == 0 ? 0 : 2e-8;  // mm, by the slope of the tables
        for (const char* axis : {"x", "y"}) {
            const std::string pin = std::string("square.") + axis + "-correction";
            square.bench.expect("abs(c - " + precise(square.bench.get(pin)) + ") <= " + precise(most),
                                {{"c", pin}});
        }
        square.bench.expect("d == 1 && e == -1", {{"d", "square.x-direction"}, {"e", "square.y-direction"}});
        square.run(seconds / 2);
    }
}

// A correction at its bound does not move with the turn, so the turn must not count as motion.
TEST(SquarenessReversal, ABoundTurnsNoAxis) {
    WithTable machine(lost_motion);
    Square& square = machine.square;
    square.set("max-correction", 0.002);
    square.go({0, 0, 0, 0});
    square.go({1, 0, 0, 0});
    square.run(0.1);
    square.bench.expect("d == 1", {{"d", "square.x-direction"}});
    square.run(0.5);
    EXPECT_NEAR(square.get("x-correction"), 2 * um, nm);
    EXPECT_TRUE(square.get("limited"));
}

TEST(SquarenessReversal, AStandingAxisIsTurnedByItsCorrectionOfStraightness) {
    WithTable machine("X,EYX\n-600,-0.06\n600,0.06\nY,EYY+,EYY-\n-600,-0.002,0.002\n600,-0.002,0.002\n");
    Square& square = machine.square;
    square.set("max-speed", 1e5);
    square.go({0, 0, 0, 0});
    square.go({100, 0, 0, 0});
    square.run(0.05);
    EXPECT_EQ(square.get("y-direction"), -1);  // corrected by -10 um
    EXPECT_NEAR(square.get("y-correction"), -12 * um, nm);
    square.go({50, 0, 0, 0});
    square.run(0.05);
    EXPECT_EQ(square.get("y-direction"), 1);
}

TEST(SquarenessReversal, StraightnessAndYawThatReverseAreCorrectedAtTheTip) {
    WithTable machine("X,EYX+,EYX-,ECX+,ECX-\n-600,2e-3,-2e-3,1e-5,-1e-5\n600,2e-3,-2e-3,1e-5,-1e-5\n");
    Square& square = machine.square;
    square.set_tool({100, 0, 0});
    machine.go_up();
    EXPECT_NEAR(square.get("y-correction"), -3 * um, nm);
    square.go({0, 0, 0, 0});
    square.run(0.05);
    EXPECT_NEAR(square.get("y-correction"), 3 * um, nm);
}

TEST(SquarenessReversal, WhatLinuxCNCCompensatesIsNotCorrectedTwice) {
    WithTable machine(std::string(lost_motion) + "Y,EXY\n-600,0.01\n600,0.01\n");
    Square& square = machine.square;
    square.set("max-rate", 0.1);
    square.go({0, 0, 0, 0});
    square.go({1, 0, 0, 0});
    square.run(1);
    square.set("y-backlash-corr", 0.003);  // no column of EYY
    square.run(0.1);
    EXPECT_EQ(square.get("fault-code"), 0);
    square.never_faster_than(0.1);
    square.set("x-backlash-corr", 0.003);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 13);
    EXPECT_NEAR(square.get("x-correction"), -10 * um, nm);
    square.set("x-backlash-corr", 0);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 13);
    EXPECT_NEAR(square.get("x-correction"), -10 * um, nm);
}

TEST(SquarenessReversal, DeadPointsThatChoppingLearnsAreNotCorrectedTwice) {
    WithTable machine(
        "X,EXX+,EXX-\n-600,0.015,0.025\n600,0.015,0.025\n"
        "Y,EYY\n-600,0.001\n600,0.001\n");
    Square& square = machine.square;
    square.set("max-rate", 0.1);
    square.go({0, 0, 0, 0});
    square.go({1, 0, 0, 0});
    square.run(1);
    EXPECT_NEAR(square.get("x-correction"), -15 * um, nm);
    square.set("y-learns", 1);  // EYY is the same in both directions
    square.run(0.1);
    EXPECT_EQ(square.get("fault-code"), 0);
    square.never_faster_than(0.1);
    square.set("x-learns", 1);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 14);
    EXPECT_NEAR(square.get("x-correction"), -20 * um, nm);  // the mean
    square.set("x-position", 0.9);
    square.run(0.5);
    EXPECT_NEAR(square.get("x-correction"), -20 * um, nm);
    square.set("x-learns", 0);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 0);
    EXPECT_NEAR(square.get("x-correction"), -25 * um, nm);
}

TEST(SquarenessReversal, InvalidSettingsLeaveTheLastGoodOnes) {
    WithTable machine(lost_motion);
    Square& square = machine.square;
    machine.go_up();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const char* pin : {"reversal-distance", "reversal-rate", "reversal-acceleration"}) {
        for (const double bad : {nan, 0.0, -1.0, 1e308}) {
            const double before = square.get(pin);
            square.set(pin, bad);
            square.run(0.002);
            EXPECT_EQ(square.get("fault-code"), 4) << pin << bad;
            EXPECT_NEAR(square.get("x-correction"), 5 * um, nm);
            square.set(pin, before);
        }
    }
    square.set("x-position", nan);
    square.set("x-backlash-corr", nan);
    square.run(0.5);
    EXPECT_TRUE(std::isfinite(square.get("x-correction")));
    EXPECT_NEAR(square.get("x-direction"), 1, 1e-12);
}

TEST(SquarenessReversal, AnInchMachineReadsTheSameTable) {
    WithTable machine(lost_motion, std::string(column_chain) + " unit=inch");
    Square& square = machine.square;
    EXPECT_NEAR(square.get("reversal-rate") * 25.4, 0.9, 1e-9);
    EXPECT_NEAR(square.get("reversal-distance") * 25.4, 0.0005, 1e-9);
    machine.go_up();
    EXPECT_NEAR(square.get("x-correction") * 25.4, 5 * um, nm);
}

TEST(SquarenessReversal, ACrossRailThatCorrectsItselfTurnsItsOwnShare) {
    WithTable machine("W,EZW+,EZW-\n-500,-0.005,0.005\n500,-0.005,0.005\n", portal_chain);
    Square& square = machine.square;
    square.set("parallel-axis-corrects", 1);
    square.go({0, 0, 0, 0});
    square.go({0, 0, 0, 1});
    square.run(0.1);
    EXPECT_NEAR(square.get("w-correction"), 5 * um, nm);
    EXPECT_NEAR(square.get("z-correction"), 0, nm);
    square.go({0, 0, 0, 0});
    square.run(0.1);
    EXPECT_NEAR(square.get("w-correction"), -5 * um, nm);
}

TEST(SquarenessReversal, AClampedCrossRailKeepsTheDirectionOfItsLastMove) {
    WithTable machine("W,EZW+,EZW-\n-500,-0.005,0.005\n500,-0.005,0.005\n", portal_chain);
    Square& square = machine.square;
    square.go({0, 0, 0, 0});
    square.go({0, 0, 0, 1});
    for (const double z : {-10.0, 5.0}) {
        square.go({0, 3, z, 1});
        square.run(0.1);
        EXPECT_EQ(square.get("w-direction"), 1);
        EXPECT_NEAR(square.get("z-correction"), 5 * um, nm);
        EXPECT_EQ(square.get("w-correction"), 0);
    }
}

// Moves, jogs, dwells and dither below half of the distance, at random: the tip is where both directions
// want it, and no step of the speed is above what the settings allow. PLUMB_RANDOM_MOVES is their number.
TEST(SquarenessReversal, RandomMovesTurnAsASledIsPushed) {
    WithTable machine(lost_motion);
    Square& square = machine.square;
    square.go({0, 0, 0, 0});
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    double position = 0, sled = 0;  // the sled reaches from it to it + distance
    square.go({1, 0, 0, 0});
    position = 1, sled = 1 - 0.0005;
    int pushed = 1, turns = 0;
    const char* const given = std::getenv("PLUMB_RANDOM_MOVES");
    const int moves = given ? std::atoi(given) : 300;
    square.run(0.1);
    square.bench.expect("abs(v_rate) <= 500.001", {{"v", "square.x-corrected-velocity"}});
    for (int i = 0; i < moves; ++i) {
        const double kind = uniform(random);
        const double way = kind < -0.4  ? 0.00024 * uniform(random)
                           : kind < 0.2 ? 0.001 * uniform(random)
                                        : uniform(random);
        position += way;
        if (position > sled + 0.0005) sled = position - 0.0005, turns += pushed < 0, pushed = 1;
        if (position < sled) sled = position, turns += pushed > 0, pushed = -1;
        square.set("x-position", position);
        square.run(0.03);
        ASSERT_EQ(square.get("x-direction"), pushed) << i;
        ASSERT_NEAR(square.get("x-correction"), pushed * 5 * um, nm);
    }
    EXPECT_GT(turns, moves / 6);
}

}  // namespace
}  // namespace plumb
