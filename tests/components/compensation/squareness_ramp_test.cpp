// SPDX-License-Identifier: GPL-2.0-or-later
// Changes that motion does not cause: of settings, tools and bad values while squareness works.
#include "tests/support/square.hpp"

#include <limits>

namespace plumb {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// A portal with all that can be set, in the middle of its work.
struct Working : Square {
    explicit Working(bool stands = true) : Square(portal_chain) {
        set({{"ea0w", 400 * urad}, {"eb0w", -300 * urad}, {"ea0z", -200 * urad}, {"eb0z", 150 * urad}});
        set({{"z-tool-offset", 250}, {"radial-offset", 100}, {"max-rate", 0.5}});
        go({200, 300, -100, 400});
        if (stands) never_faster_than(0.5);
    }
};

TEST(SquarenessRamp, EachChangeComesAtMaxRateAndGoesAtIt) {
    Working square;
    const Vec before = square.get_xyz("correction");
    for (const auto& [pin, value] :
         std::vector<std::pair<std::string, double>>{{"enable", 0},
                                                     {"all-homed", 0},
                                                     {"ea0w", -100 * urad},
                                                     {"ec0x", 100 * urad},
                                                     {"z-tool-offset", 50},
                                                     {"y-tool-offset", 50},
                                                     {"radial-offset", 0},
                                                     {"radial-direction", 120},
                                                     {"radial-is-diameter", 1},
                                                     {"w-pivot", 300},
                                                     {"w-tool-follows", 0},
                                                     {"z-reference-tool-offset", 150},
                                                     {"axis-direction", 1},
                                                     {"to-bed", 1},
                                                     {"max-angle", 100 * urad},
                                                     {"max-correction", .05},
                                                     {"w-position", 390}}) {
        SCOPED_TRACE(pin);
        const double own = square.get(pin);
        for (const bool there : {true, false}) {
            square.set(pin, there ? value : own);
            square.run(0.003);
            EXPECT_TRUE(square.get("ramping"));
            square.run(1);
            EXPECT_FALSE(square.get("ramping"));
            const double away = (square.get_xyz("correction") - before).length();
            if (there)
                EXPECT_GT(away, 3 * um);
            else
                EXPECT_LT(away, 1e-9);
        }
    }
}

TEST(SquarenessRamp, DisabledAndUnhomedIsZero) {
    for (const char* pin : {"enable", "all-homed"}) {
        Working square;
        square.set(pin, 0);
        square.run(4);
        EXPECT_EQ(square.get_xyz("correction").length(), 0);
        EXPECT_EQ(square.get("z-corrected-position"), -100);
        EXPECT_EQ(square.get_xyz("error").length() > 0, pin == std::string("enable"));
    }
}

// A second one beside it knows the tool from the start: the difference is the ramp alone.
TEST(SquarenessRamp, MotionIsFollowedWithoutLagMeanwhile) {
    Bench bench;
    bench.command("loadrt squareness names=square,other interlock=no chain=w-X.b-W-Y-Z-C-t,w-X.b-W-Y-Z-C-t");
    bench.command("loadrt siggen names=wave");
    bench.command("addf wave.update servo-thread");
    bench.command("setp wave.frequency 0.2");
    bench.command("setp wave.amplitude 400");  // 500 mm/s
    bench.command(
        "net place wave.sine square.w-position other.w-position square.y-position other.y-position");
    for (const std::string it : {"square", "other"}) {
        bench.command("addf " + it + ".update servo-thread");
        for (const auto& [pin, value] : Square::Values{{"all-homed", 1},
                                                       {"ea0w", 400 * urad},
                                                       {"eb0w", -300 * urad},
                                                       {"max-rate", 0.1},
                                                       {"max-speed", 600}})
            bench.set(it + "." + pin, value);
        bench.set(it + ".enable", 1);
    }
    bench.set("other.z-tool-offset", 300);
    bench.run(5);
    bench.expect(
        "(x_rate - u_rate) * (x_rate - u_rate) + (y_rate - v_rate) * (y_rate - v_rate) <= 0.1 * 0.1 * "
        "1.00001",
        {{"x", "square.x-correction"},
         {"y", "square.y-correction"},
         {"u", "other.x-correction"},
         {"v", "other.y-correction"}});
    const auto apart = [&] {
        return std::hypot(bench.get("square.x-correction") - bench.get("other.x-correction"),
                          bench.get("square.y-correction") - bench.get("other.y-correction"));
    };
    EXPECT_NEAR(apart(), 150 * um, 0.01 * um);
    bench.set("square.z-tool-offset", 300);
    bench.run(1);
    EXPECT_NEAR(apart(), 50 * um, 0.2 * um);
    bench.run(0.6);
    EXPECT_LT(apart(), 1e-12);
}

TEST(SquarenessRamp, AngleThatDriftsIsFollowed) {
    Working square;
    square.bench.command("loadrt siggen names=drift");
    square.bench.command("addf drift.update servo-thread");
    square.bench.command("setp drift.frequency 0.1");
    square.bench.command("setp drift.amplitude 0.0001");
    square.bench.command("net angle drift.sine square.ea0w");
    square.run(4);
    EXPECT_FALSE(square.get("ramping"));
    square.run(3);
    EXPECT_FALSE(square.get("ramping"));
    const LeaningPortal machine{square.get("ea0w-in-use"), -300 * urad, -200 * urad, 150 * urad};
    const Position q{200, 300, -100, 400};
    const Vec tool{100, 0, -250};
    EXPECT_LT((machine.tip(square.corrected(q), tool) - ideal_tip(q, tool)).length(), 1e-9);
}

struct Contradiction {
    Square::Values settings;
    int code;
};

TEST(SquarenessRamp, SetThatContradictsItselfLeavesTheLastGoodOne) {
    Square square("chain=w-W-X.b-Y-Z-C-t");  // no axis is on W, which carries the work
    square.set({{"ea0y", 100 * urad}, {"ec0y", 50 * urad}, {"z-tool-offset", 200}});
    square.go({100, 400, -50, 0});
    square.never_faster_than(10);
    const Vec before = square.get_xyz("correction");
    for (const auto& [settings, code] :
         {Contradiction{{{"max-angle", 0}}, 4}, Contradiction{{{"max-angle", 0.2}}, 4},
          Contradiction{{{"max-correction", -1}}, 4}, Contradiction{{{"max-rate", not_a_number}}, 4},
          Contradiction{{{"max-speed", -1}}, 4}, Contradiction{{{"max-speed", 2e5}}, 4},
          Contradiction{{{"max-speed", 0}}, 10}, Contradiction{{{"to-bed", 1}}, 6},
          Contradiction{{{"radial-offset", 30}, {"radial-direction", not_a_number}}, 7}}) {
        SCOPED_TRACE(settings.begin()->first);
        Square::Values own;
        for (const auto& [pin, value] : settings) own[pin] = square.get(pin);
        square.set(settings);
        square.run(0.003);
        square.set("ea0y", 300 * urad);  // waits until the set makes sense
        square.run(0.5);
        EXPECT_EQ((square.get_xyz("correction") - before).length(), 0);
        EXPECT_EQ(square.get("ea0y-in-use"), 100 * urad);
        EXPECT_EQ(square.get("fault-code"), code);
        EXPECT_TRUE(square.get("fault"));
        square.set(own);
        square.run(0.5);
        EXPECT_EQ(square.get("ea0y-in-use"), 300 * urad);
        EXPECT_EQ(square.get("fault-code"), 0);
        square.set("ea0y", 100 * urad);
        square.run(0.5);
        EXPECT_LT((square.get_xyz("correction") - before).length(), 1e-12);
    }
}

// A refused set leaves nothing behind, even if a later one falls back on the last good values.
TEST(SquarenessRamp, SetThatIsRefusedLeavesNoRadiusBehind) {
    Square square("chain=w-W-X.b-Y-Z-C-t");
    square.set({{"ec0y", 100 * urad}, {"radial-offset", 20}});
    square.go({0, 100, 0, 0});
    const Vec before = square.get_xyz("correction");
    square.set({{"to-bed", 1}, {"radial-offset", 100}});
    square.run(0.1);
    EXPECT_EQ(square.get("fault-code"), 6);
    square.set("radial-offset", not_a_number);
    square.set("to-bed", 0);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 3);
    EXPECT_EQ((square.get_xyz("correction") - before).length(), 0);
}

TEST(SquarenessRamp, HomingThatSetsAPositionLimitsNothing) {
    for (const char* pin : {"all-homed", "enable"}) {
        Square square(column_chain);
        square.set("ec0y", 100 * urad);
        square.set(pin, 0);
        square.run(0.1);
        square.bench.expect("code == 0", {{"code", "square.limited-code"}});
        square.set("y-position", 100);
        square.run(0.1);
        square.set("y-position", -300);
        square.set(pin, 1);
        square.run(1);
        EXPECT_NEAR(square.get("x-correction"), -30 * um, 0.01 * um);
    }
}

// An axis of unknown motion counts as standing: it does not change the correction, nor feed a drive
// forward.
TEST(SquarenessRamp, PositionThatIsNotKnownHasNoVelocity) {
    for (const char* bad : {"y-position", "y-velocity"}) {
        Square square(column_chain);
        square.set("ec0y", 1000 * urad);
        square.set("y-velocity", 200);
        square.go({0, 100, 0, 0});
        EXPECT_NEAR(square.get("x-corrected-velocity"), 0.2, 1e-5);
        square.set(bad, not_a_number);
        square.run(0.001);
        EXPECT_EQ(square.get("x-corrected-velocity"), 0) << bad;
        EXPECT_EQ(square.get("y-corrected-velocity"), 0) << bad;
        EXPECT_EQ(square.get("fault-code"), 1);
    }
}

TEST(SquarenessRamp, ValueOutOfRangeIsBoundedAndReported) {
    Square square(column_chain);
    square.set({{"max-angle", 200 * urad}, {"max-correction", 0.05}});
    square.set("ec0y", 300 * urad);
    square.go({0, 200, 0, 0});
    EXPECT_NEAR(square.get("x-correction"), 40 * um, 0.01 * um);
    EXPECT_EQ(square.get("ec0y-in-use"), 200 * urad);
    EXPECT_EQ(square.get("limited-code"), 1);
    square.set("ec0y", -200 * urad);
    square.go({0, 300, 0, 0});
    EXPECT_EQ(square.get("x-correction"), -50 * um);
    EXPECT_EQ(square.get("limited-code"), 2);
    EXPECT_TRUE(square.get("limited"));
    EXPECT_EQ(square.get("fault-code"), 0);
    square.go({0, 100, 0, 0});
    EXPECT_NEAR(square.get("x-correction"), -20 * um, 0.01 * um);
    EXPECT_FALSE(square.get("limited"));
}

TEST(SquarenessRamp, PositionThatJumpsIsRamped) {
    Working square;
    square.set("w-position", -400);
    square.run(0.001);
    EXPECT_EQ(square.get("limited-code"), 3);
    square.run(0.5);
    EXPECT_TRUE(square.get("ramping"));
    EXPECT_EQ(square.get("limited-code"), 0);
    square.run(4);
    EXPECT_FALSE(square.get("ramping"));
}

// Without the speed of the axes, a rapid looks the same as a position that jumps.
TEST(SquarenessRamp, MaxSpeedThatIsNotSetIsAFaultAndNothingIsCorrected) {
    Bench bench;
    bench.command(std::string("loadrt squareness names=square interlock=no ") + column_chain);
    bench.command("addf square.update servo-thread");
    for (const auto& [pin, value] : Square::Values{
             {"all-homed", 1}, {"enable", 1}, {"ec0y", 100 * urad}, {"y-position", 300}, {"max-rate", 10}})
        bench.set("square." + pin, value);
    bench.expect("x == 0 && limited == 0", {{"x", "square.x-correction"}, {"limited", "square.limited"}});
    bench.run(0.1);
    EXPECT_EQ(bench.get("square.fault-code"), 10);
    EXPECT_TRUE(bench.get("square.fault"));
    EXPECT_EQ(bench.get("square.ec0y-in-use"), 0);
}

TEST(SquarenessRamp, MaxSpeedThatComesLaterBringsTheCorrectionByTheRamp) {
    Square square(column_chain);
    square.set({{"max-speed", 0}, {"ec0y", 100 * urad}, {"max-rate", 0.1}});
    square.set("y-position", 300);
    square.run(0.1);
    square.never_faster_than(0.1);
    square.set("max-speed", 1200);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 0);
    EXPECT_NEAR(square.get("x-correction"), 30 * um, 0.01 * um);
}

// A rapid of LinuxCNC is exactly as fast as in its INI file, but for rounded numbers and blended paths.
TEST(SquarenessRamp, RapidAtMaxSpeedIsFollowedWithoutLag) {
    Square square(column_chain);
    square.set({{"ec0y", 100 * urad}, {"max-speed", 1200}, {"max-rate", 0.1}});
    square.go({0, -600, 0, 0});
    square.bench.expect("abs(x - y * 0.0001) < 1e-5 && limited == 0 && ramping == 0",
                        {{"x", "square.x-correction"},
                         {"y", "square.y-position"},
                         {"limited", "square.limited"},
                         {"ramping", "square.ramping"}});
    square.follow([](double t) { return Square::Moving{{0, 1212 * t - 600, 0, 0}, {0, 1212, 0, 0}}; }, 1);
    square.run(1);
    EXPECT_GT(square.get("y-position"), 590);
}

// In motion, too, no bad value makes a step that motion would not make.
TEST(SquarenessRamp, BadValueLeavesTheLastGoodOneAlsoInMotion) {
    const std::vector<std::pair<std::string, int>> inputs{
        {"w-position", 1}, {"y-velocity", 1},    {"z-tool-offset", 2},    {"ea0w", 3},
        {"w-pivot", 3},    {"radial-offset", 3}, {"radial-direction", 7}, {"x-reference-tool-offset", 3},
        {"max-rate", 4}};
    for (const double bad : {not_a_number, -std::numeric_limits<double>::infinity(), 1e308}) {
        Working square(false);
        square.bench.command("loadrt siggen names=wave");
        square.bench.command("addf wave.update servo-thread");
        square.bench.command("setp wave.frequency 0.2");
        square.bench.command("setp wave.amplitude 300");
        square.bench.command("setp wave.offset 300");
        square.bench.command("net place wave.sine square.y-position");
        square.run(2);
        // Motion: 380 mm/s by 0.4 mrad; ramps: 0.5 mm/s.
        square.bench.expect("abs(z_rate) <= 0.7", {{"z", "square.z-correction"}});
        for (const auto& [pin, code] : inputs) {
            const double own = square.get(pin);
            square.set(pin, bad);
            square.run(0.05);
            EXPECT_EQ(square.get("fault-code"), code) << pin << " = " << bad;
            square.set(pin, own);
            square.run(0.05);
            EXPECT_EQ(square.get("fault-code"), 0) << pin;
        }
    }
}

}  // namespace
}  // namespace plumb
