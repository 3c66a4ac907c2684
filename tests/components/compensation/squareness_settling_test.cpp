// SPDX-License-Identifier: GPL-2.0-or-later
// How squareness has the next cut wait for the correction of its tool; portal_settling_test.py has LinuxCNC
// wait.
#include "tests/support/square.hpp"

#include <limits>

namespace plumb {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

enum MotionType { none = 0, rapid = 1, feed = 2, arc = 3, tool_change = 4, probing = 5, index_rotary = 6 };

// A column that another tool length moves by 0.1 um per mm, at 0.1 mm/s: 30 um take 0.3 s.
struct Milling : Square {
    Milling() : Square(column_chain) {
        set({{"ea0y", 100 * urad}, {"max-rate", 0.1}, {"z-tool-offset", 100}});
        go({0, 0, 0, 0});
        EXPECT_FALSE(get("settling"));
    }

    // Another tool, 300 mm longer or as long as before.
    void change_tool() {
        length = 500 - length;
        set("z-tool-offset", length);
        run(0.001);
    }
    void move(MotionType type, double velocity) {
        set({{"motion-type", type}, {"path-velocity", velocity}});
        run(0.001);
    }
    double held() {
        double seconds = 0;
        for (; get("settling") && seconds < 100; seconds += 0.001) run(0.001);
        return seconds;
    }
    void expect_unsettled(int code) {
        EXPECT_FALSE(get("settling"));
        EXPECT_EQ(get("unsettled-code"), code);
        EXPECT_EQ(get("unsettled"), code != 0);
    }

    double length = 100;
};

TEST(SquarenessSettling, LastsFromAChangeOfTheToolUntilTheCorrectionIsInForce) {
    Milling square;
    for (int n = 0; n < 2; ++n) {
        square.change_tool();
        EXPECT_TRUE(square.get("settling"));
        EXPECT_NEAR(square.held(), 0.299, 0.002);
        EXPECT_FALSE(square.get("ramping"));
        square.expect_unsettled(0);
    }
    square.set("radial-direction", 90);
    square.set("radial-offset", 50);
    square.run(0.001);
    EXPECT_TRUE(square.get("settling"));
}

TEST(SquarenessSettling, LastsUntilTheStagesHaveEndedTheirRamps) {
    Milling square;
    square.change_tool();
    square.set("stages-ramping", 1);
    square.run(2);
    EXPECT_FALSE(square.get("ramping"));
    EXPECT_TRUE(square.get("settling"));
    square.set("stages-ramping", 0);
    square.run(0.001);
    square.expect_unsettled(0);
    square.set("stages-ramping", 1);
    square.run(0.1);
    square.expect_unsettled(0);
}

TEST(SquarenessSettling, NothingButAToolChangeBeginsIt) {
    Milling square;
    square.bench.expect("settling == 0", {{"settling", "square.settling"}});
    for (const auto& [pin, value] : Square::Values{{"enable", 0},
                                                   {"ec0y", 50 * urad},
                                                   {"y-pivot", 100},
                                                   {"all-homed", 0},
                                                   {"y-position", 200},
                                                   {"reload", 1}}) {
        square.set(pin, value);
        square.run(0.5);
        square.set("enable", 1);
        square.set("all-homed", 1);
        square.run(0.5);
    }
    square.set("enable", 0);
    square.run(0.5);
    square.change_tool();
    square.run(0.5);
    square.expect_unsettled(0);
}

TEST(SquarenessSettling, EndsWhereTheCorrectionDoesNotComeAndGivesTheReason) {
    struct Case {
        std::string pin;
        double value;
        int code;
    };
    for (const auto& [pin, value, code] :
         {Case{"enable", 0, 1}, Case{"all-homed", 0, 1}, Case{"max-angle", -1, 2},
          Case{"y-position", not_a_number, 2}, Case{"max-correction", 0.02, 3},
          Case{"max-angle", 50 * urad, 3}}) {
        SCOPED_TRACE(pin);
        Milling square;
        const double own = square.get(pin);
        square.change_tool();
        square.run(0.1);
        EXPECT_TRUE(square.get("settling"));
        square.set(pin, value);
        square.run(0.001);
        square.expect_unsettled(code);
        square.set(pin, own);
        square.run(1);
        square.expect_unsettled(code);  // long enough for a message
        square.change_tool();
        EXPECT_TRUE(square.get("settling"));
        EXPECT_EQ(square.get("unsettled"), 0);
        square.held();
        if (code == 1) continue;
        square.set(pin, value);
        square.run(1);
        square.change_tool();
        square.expect_unsettled(code);
    }
}

TEST(SquarenessSettling, EndsAfterTheSetTime) {
    Milling square;
    square.set({{"stages-ramping", 1}, {"settling-time", 0.5}});
    square.change_tool();
    EXPECT_NEAR(square.held(), 0.5, 0.002);
    square.expect_unsettled(4);
    for (const double bad : {0.0, 4000.0, not_a_number}) {
        square.set("settling-time", bad);
        square.run(0.001);
        EXPECT_EQ(square.get("fault-code"), 4);
    }
}

TEST(SquarenessSettling, NeverComesInACut) {
    for (const MotionType type : {none, feed, arc, probing}) {  // a rigid tap has no type
        SCOPED_TRACE(type);
        Milling square;
        square.move(type, 30);
        square.run(0.001);
        square.change_tool();
        square.expect_unsettled(6);
        if (type != none) {
            square.move(type, 0);  // held by the operator
            square.change_tool();
            square.expect_unsettled(6);
        }
        square.move(none, 0);
        square.change_tool();
        EXPECT_TRUE(square.get("settling"));
    }
    for (const MotionType type : {rapid, tool_change, index_rotary}) {
        SCOPED_TRACE(type);
        Milling square;
        square.move(type, 30);
        square.change_tool();
        EXPECT_TRUE(square.get("settling"));
        square.move(type, 0);
        EXPECT_NEAR(square.held(), 0.298, 0.002);
    }
}

TEST(SquarenessSettling, EndsWhereACutBeginsAllTheSame) {
    Milling square;
    square.change_tool();
    square.move(feed, 0);  // held at its start
    EXPECT_TRUE(square.get("settling"));
    square.move(rapid, 50);
    EXPECT_TRUE(square.get("settling"));
    square.move(feed, 1e-3);
    square.expect_unsettled(5);
    square.move(feed, 0);
    square.expect_unsettled(5);
    square.move(feed, not_a_number);
    square.change_tool();
    square.expect_unsettled(6);
}

// motion.motion-type is a period behind where a move begins, and none for a rigid tap.
TEST(SquarenessSettling, RapidIsNoCutInItsFirstPeriodAndARigidTapIsOneFromItsSecond) {
    Milling square;
    square.change_tool();
    square.move(none, 2);
    EXPECT_TRUE(square.get("settling"));
    square.move(rapid, 4);
    square.move(rapid, 0);
    square.move(none, 0);
    EXPECT_TRUE(square.get("settling"));
    square.move(none, 1);
    EXPECT_TRUE(square.get("settling"));
    square.move(none, 2);
    square.expect_unsettled(5);
}

TEST(SquarenessSettling, HoldsNoJog) {
    Milling square;
    square.change_tool();
    square.set("coordinated", 0);
    square.move(none, 30);
    square.expect_unsettled(0);
    square.set("coordinated", 1);
    square.move(none, 0);
    EXPECT_TRUE(square.get("settling"));
    EXPECT_NEAR(square.held(), 0.297, 0.002);
}

}  // namespace
}  // namespace plumb
