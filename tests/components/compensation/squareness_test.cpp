// SPDX-License-Identifier: GPL-2.0-or-later
// squareness against the textbook's machines; squareness_ramp_test.cpp changes its settings, and
// squareness_table_test.cpp gives it tables.
#include "tests/support/hal_pins.hpp"
#include "tests/support/live.hpp"
#include "tests/support/square.hpp"

#include <gmock/gmock.h>

#include <cctype>
#include <cstdio>
#include <limits>
#include <random>
#include <regex>
#include <set>
#include <string>

namespace plumb {
namespace {

using testing::HasSubstr;

// A portal at rest whose tool is changed each second: the correction is under way again and again.
void bring_to_life(Bench& bench) {
    const Folder folder;
    bench.source(folder.write("live.hal", R"(
loadrt threads name1=servo-thread period1=1000000
loadrt squareness names=square interlock=no chain=w-X.b-W-Y-Z-C-t
loadrt siggen names=tools
setp tools.frequency 0.5
setp tools.amplitude 50
setp tools.offset 250
setp square.x-position 200
setp square.y-position 300
setp square.z-position -100
setp square.w-position 400
setp square.ea0w 0.0004
setp square.eb0w -0.0003
setp square.ea0z -0.0002
setp square.eb0z 0.0001
setp square.radial-offset 30
setp square.max-rate 0.5
setp square.max-speed 250
setp square.all-homed 1
setp square.enable 1
net tool-length tools.square => square.z-tool-offset
addf tools.update servo-thread
addf square.update servo-thread
start
)"));
    bench.run(2);
}

const Live live{{{"squareness", "square"}},
                bring_to_life,
                3.6,
                3.3,
                {{{"tools.amplitude", {50, 0}}}, {}, [](Bench& bench) {
                     bench.set("tools.amplitude", 0);
                     bench.run(3);
                     std::vector<std::string> complaints;
                     for (const char* axis : {"x", "y", "z"}) {
                         const double error = bench.get(std::string("square.") + axis + "-error");
                         const double correction = bench.get(std::string("square.") + axis + "-correction");
                         if (!(std::abs(error + correction) <= 1 * um && error != 0))
                             complaints.push_back(std::string(axis) + ": " + std::to_string(correction) +
                                                  " for an error of " + std::to_string(error));
                     }
                     return complaints;
                 }}};

TEST(Squareness, WorkedExampleHasItsError) {
    Square square(column_chain);
    square.set({{"ea0y", 60 * urad}, {"ec0y", -80 * urad}});
    square.set_tool({0, 25, 250});
    square.go({0, 800, 0, 0});
    const Vec first_order{66, -15, 49.5};  // um
    EXPECT_LT((square.get_xyz("error") * 1000 - first_order).length(), 0.01);
    EXPECT_LT((square.get_xyz("correction") * 1000 + first_order).length(), 0.02);
    EXPECT_EQ(square.get("ea0y-in-use"), 60 * urad);
    EXPECT_EQ(square.get("fault-code"), 0);
    EXPECT_EQ(square.get("limited-code"), 0);
}

// Y leans by 20 um in 300 mm to +X, as a square on the table shows; Y carries X in the second chain.
TEST(Squareness, SquareOnTheTableIsFollowedOnEitherChain) {
    for (const char* chain : {column_chain, "chain=w-X-Y.b-Z-C-t"}) {
        Square square(chain);
        square.set("ec0y", -66.7 * urad);
        if (chain != column_chain) square.set("ec0x", 66.7 * urad);
        for (const double x : {0.0, 200.0}) {
            square.go({x, 300, 0, 0});
            EXPECT_NEAR(square.get("x-correction"), -20 * um, 0.02 * um) << chain;
            EXPECT_NEAR(square.get("y-correction"), 0, 0.02 * um) << chain;
        }
    }
}

// In the second chain Y carries X and the work: they turn alike.
TEST(Squareness, SaysThatAnAngleOfTheAxisOnTheBedCorrectsNothing) {
    for (const char* chain : {column_chain, "chain=w-X-Y.b-Z-C-t"}) {
        Square square(chain);
        square.set("ec0y", -66.7 * urad);
        square.go({200, 300, -50, 0});
        const bool acts = chain == column_chain;
        EXPECT_EQ(square.get("x-correction") != 0, acts) << chain;
        EXPECT_EQ(square.get("status-code"), acts ? 40 : 47) << chain;
        if (acts) continue;
        square.set("ec0x", 66.7 * urad);
        square.go({200, 400, -50, 0});
        EXPECT_EQ(square.get("status-code"), 40);
        square.set({{"ec0x", 0}, {"ea0y", 20 * urad}});
        square.go({200, 300, -50, 0});
        EXPECT_EQ(square.get("status-code"), 40) << "Z is not carried";
    }
}

// The place to which the machine brings the tip, against that of an ideal one: over a cube of 1 m, with a
// tool of 400 mm that is 50 mm out of centre. On an exact machine the way back is exact, too: q = tip -
// tool.
struct Scored {
    double uncorrected = 0, corrected = 0, error_shown = 0;

    template <typename Machine>
    void judge(Square& square, const Machine& machine, double w, std::mt19937& random) {
        const auto side = [&] { return std::uniform_int_distribution<int>(-1, 1)(random) * 500.0; };
        const Position q{side(), side(), side(), w};
        const double direction = std::uniform_real_distribution<double>(-180, 180)(random);
        square.set("radial-direction", direction);
        const double angle = direction * pi / 180;
        const Vec tool{50 * std::cos(angle), 50 * std::sin(angle), -400};
        square.go(q);
        const Vec error = machine.tip(q, tool) - ideal_tip(q, tool);
        const Vec rest = machine.tip(square.corrected(q), tool) - ideal_tip(q, tool);
        uncorrected = std::max(uncorrected, error.length());
        corrected = std::max(corrected, rest.length());
        error_shown = std::max(error_shown, (square.get_xyz("error") - error).length());
    }

    void hold(const char* name) const {
        std::printf("%s: error up to %.0f um, corrected to %.2g um\n", name, uncorrected * 1000,
                    corrected * 1000);
        EXPECT_GT(uncorrected, 400 * um);
        EXPECT_LT(corrected, 1e-9);
        EXPECT_LT(error_shown, 1e-9);
    }
};

TEST(Squareness, EveryTiltOfAColumnIsCorrectedExactly) {
    Square square(column_chain);
    std::mt19937 random(1);
    Scored scored;
    square.set({{"z-tool-offset", 400}, {"radial-offset", 100}, {"radial-is-diameter", 1}});
    for (const int ea : {-1, 0, 1})
        for (const int ec : {-1, 0, 1}) {
            const LeaningColumn machine{ea * 100 * arcsec, ec * 100 * arcsec};
            square.set({{"ea0y", machine.ea0y}, {"ec0y", machine.ec0y}});
            for (int n = 0; n < 3; ++n) scored.judge(square, machine, 0, random);
        }
    scored.hold("column");
}

TEST(Squareness, EveryTiltOfAPortalIsCorrectedExactlyInAllReadings) {
    Square square(portal_chain);
    std::mt19937 random(2);
    Scored scored;
    square.set({{"z-tool-offset", 400}, {"radial-offset", 50}});
    for (int n = 0; n < 81 * 4; ++n) {
        const auto angle = [n](int divisor) { return (n / divisor % 3 - 1) * 100 * arcsec; };
        const LeaningPortal machine{angle(27), angle(9), angle(3), angle(1), n / 81 % 2 == 1, n / 162 == 1};
        square.set({{"ea0w", machine.ea0w},
                    {"eb0w", machine.eb0w},
                    {"ea0z", machine.ea0z},
                    {"eb0z", machine.eb0z},
                    {"axis-direction", machine.axis_direction},
                    {"to-bed", machine.to_bed}});
        scored.judge(square, machine, n % 2 ? 300 : -200, random);
    }
    scored.hold("portal");
}

TEST(Squareness, PivotShimAndReferenceToolTakeAwayWhatTheyShould) {
    Square square(column_chain);
    const LeaningColumn machine{90 * arcsec, -70 * arcsec};
    const Position q{100, 600, -200, 0};
    const Vec tool{0, 0, -300};
    square.set({{"ea0y", machine.ea0y}, {"ec0y", machine.ec0y}});
    square.set_tool(tool);

    square.set("y-pivot", 250);
    square.go(q);
    const Position from_pivot{100, 350, -200, 0};
    EXPECT_LT(
        (square.get_xyz("error") - (machine.tip(from_pivot, tool) - ideal_tip(from_pivot, tool))).length(),
        1e-9);
    square.set("z-reference-tool-offset", 300);
    square.go(q);
    EXPECT_LT((square.get_xyz("error") - (machine.tip(from_pivot, {}) - ideal_tip(from_pivot, {}))).length(),
              1e-3 * um);
    square.set({{"z-reference-tool-offset", 0}, {"y-tool-follows", 0}});
    square.go(q);
    EXPECT_LT((square.get_xyz("error") - (machine.tip(from_pivot, {}) - ideal_tip(from_pivot, {}))).length(),
              1e-9);
}

TEST(Squareness, CrossRailStaysUnlessItIsToCorrectItsOwnTravel) {
    Square square(portal_chain);
    const LeaningPortal machine{100 * arcsec, -90 * arcsec, 80 * arcsec, 70 * arcsec};
    const Vec tool{0, 0, -300};
    const Position q{100, 600, -200, 400};
    square.set(
        {{"ea0w", machine.ea0w}, {"eb0w", machine.eb0w}, {"ea0z", machine.ea0z}, {"eb0z", machine.eb0z}});
    square.set_tool(tool);
    square.go(q);
    EXPECT_EQ(square.get("w-correction"), 0);
    EXPECT_EQ(square.get("w-corrected-position"), 400);
    const double z = square.get("z-correction");

    square.set("parallel-axis-corrects", 1);
    square.go(q);
    const double own = 400 / (std::cos(machine.ea0w) * std::cos(machine.eb0w)) - 400;
    EXPECT_GT(own, 0.05 * um);
    EXPECT_NEAR(square.get("w-correction"), own, 1e-12);
    EXPECT_EQ(square.get("w-corrected-position"), 400 + square.get("w-correction"));
    EXPECT_NEAR(square.get("z-correction"), z - own, 1e-3 * own);
    Position there = square.corrected(q);
    there[3] = square.get("w-corrected-position");
    EXPECT_LT((machine.tip(there, tool) - ideal_tip(q, tool)).length(), 1e-9);

    for (const Position& elsewhere : {Position{-200, -300, 50, 400}, Position{0, 100, -400, 400}}) {
        square.go(elsewhere);
        EXPECT_NEAR(square.get("w-correction"), own, 1e-12) << "a rail that is clamped stands";
    }
    square.set("enable", 0);
    square.go(q);
    EXPECT_EQ(square.get("w-correction"), 0);
}

TEST(Squareness, EachParallelAxisHasItsCorrection) {
    for (const char* letter : {"u", "v", "w"}) {
        const std::string big(1, static_cast<char>(std::toupper(letter[0])));
        Square square("chain=w-X.b-" + big + "-Y-Z-C-t");
        square.set("parallel-axis-corrects", 1);
        square.set(*letter == 'w' ? "ea0w" : "ec0" + std::string(letter), 1e-3);
        square.go({0, 0, 0, 1000});
        EXPECT_NEAR(square.get(letter + std::string("-correction")), 1000 / std::cos(1e-3) - 1000, 1e-12);
    }
}

// The pins of an axis, by its letter: those whose names have it before a hyphen, or end with it.
std::set<std::string> axes_of_pins(Square& square) {
    std::set<std::string> found;
    for (const auto& [name, pin] : wiring(square.bench)) {
        const std::string own = name.substr(name.find('.') + 1);
        std::smatch match;
        if (std::regex_match(own, match, std::regex("(?:([a-cu-z])-.*|e[a-cxyz]0([a-cu-z])(?:-in-use)?)")))
            found.insert(match[1].str() + match[2].str());
    }
    return found;
}

TEST(Squareness, AnAxisHasPinsIfTheChainNamesIt) {
    using Axes = std::set<std::string>;
    const auto has = [](Square& square, const std::string& pin) {
        return wiring(square.bench).count("square." + pin) == 1;
    };
    {
        Square square(column_chain);
        EXPECT_EQ(axes_of_pins(square), (Axes{"x", "y", "z"})) << "C is a spindle";
        for (const char* pin : {"to-bed", "parallel-axis-corrects", "max-rotary-speed"})
            EXPECT_FALSE(has(square, pin)) << pin;
    }
    {
        Square square(portal_chain);
        EXPECT_EQ(axes_of_pins(square), (Axes{"w", "x", "y", "z"}));
        EXPECT_TRUE(has(square, "to-bed"));
        EXPECT_TRUE(has(square, "parallel-axis-corrects"));
    }
    Square square("chain=w-C-A-V-Y.b-X-Z-t rotary=AC");
    EXPECT_EQ(axes_of_pins(square), (Axes{"a", "c", "v", "x", "y", "z"}));
    EXPECT_TRUE(has(square, "max-rotary-speed"));
}

// A circle that is tilted, with all four axes in motion: 100 mm/s and more.
Square::Moving on_a_curve(double t) {
    const double w = 0.5, s = std::sin(w * t), c = std::cos(w * t);
    return {{200 * c, 200 * s, 60 * s - 100, 50 * c}, {-200 * w * s, 200 * w * c, 60 * w * c, -50 * w * s}};
}

TEST(Squareness, VelocityIsTheDerivativeOfPosition) {
    Square square(portal_chain);
    square.set({{"ea0w", 100 * arcsec},
                {"eb0w", -90 * arcsec},
                {"ea0z", 80 * arcsec},
                {"eb0z", 70 * arcsec},
                {"ec0x", 60 * arcsec},
                {"radial-offset", 50},
                {"z-tool-offset", 400}});
    const auto start = on_a_curve(0).position;
    square.go(start);
    square.follow(on_a_curve, 3);
    std::vector<std::string> names;
    for (const char* axis : {"x", "y", "z"})
        for (const char* what : {"-corrected-position", "-corrected-velocity", "-velocity"})
            names.push_back(std::string("square.") + axis + what);
    const Table table = square.bench.trace(2.9, names);
    double worst = 0, most = 0;
    for (std::size_t i = 0; i < 9; i += 3) {
        worst = std::max(worst, worst_velocity(table, names[i], names[i + 1]));
        const auto corrected = table.column(names[i + 1]), own = table.column(names[i + 2]);
        for (std::size_t k = 4; k < own.size(); ++k) most = std::max(most, std::abs(corrected[k] - own[k]));
    }
    std::printf("at 100 mm/s the correction moves at up to %.1f um/s; velocities err by %.2g mm/s\n",
                most * 1000, worst);
    EXPECT_GT(most, 10 * um);
    EXPECT_LT(worst, 1e-6 * 100);
}

TEST(Squareness, InchMachineIsTheSameMachine) {
    Square square(std::string(portal_chain) + " unit=inch");
    const LeaningPortal machine{100 * arcsec, -90 * arcsec, 80 * arcsec, 70 * arcsec};
    square.set(
        {{"ea0w", machine.ea0w}, {"eb0w", machine.eb0w}, {"ea0z", machine.ea0z}, {"eb0z", machine.eb0z}});
    const Vec tool{0, 0, -10};
    square.set_tool(tool);
    const Position q{10, 20, -5, 12};
    square.go(q);
    EXPECT_LT((machine.tip(square.corrected(q), tool) - ideal_tip(q, tool)).length(), 1e-10);
}

TEST(Squareness, InstancesHaveTheirOwnChains) {
    Bench bench;
    bench.command("loadrt squareness names=a,b interlock=no chain=w-Z.b-X-Y-C-t,b-W-Y-Z-C-t");
    for (const std::string it : {"a", "b"}) {
        bench.command("addf " + it + ".update servo-thread");
        for (const char* pin : {".enable", ".all-homed"}) bench.set(it + pin, 1);
        bench.set(it + ".max-rate", 10);
        bench.set(it + ".max-speed", 1000);
        bench.set(it + ".y-position", 500);
        bench.set(it + ".z-position", 200);
        bench.set(it + ".ea0y", 50 * urad);
    }
    bench.set("b.ea0w", 20 * urad);
    bench.run(0.5);
    EXPECT_NEAR(bench.get("a.z-correction"), -25 * um, 0.01 * um);
    EXPECT_NEAR(bench.get("a.y-correction"), 0, 0.01 * um);
    EXPECT_NEAR(bench.get("b.z-correction"), -35 * um, 0.02 * um);
    EXPECT_NEAR(bench.get("b.y-correction"), 14 * um, 0.02 * um);
}

TEST(Squareness, RefusesToLoadWithoutSense) {
    Bench bench(Bench::Thread::none);
    const auto refusal = [&](const std::string& options) {
        const client::Halcmd answer =
            bench.client().halcmd({"loadrt", "squareness", "names=square", options});
        EXPECT_NE(answer.status, 0) << options;
        return answer.output;
    };
    EXPECT_THAT(
        refusal("chain=w-X-Y.b-Q-t"),
        HasSubstr("squareness: chain \"w-X-Y.b-Q-t\", character 9: expected one of X Y Z U V W C, not"));
    EXPECT_THAT(refusal("chain=w-X.b-W-Y-Z-V-t"), HasSubstr("only one of U, V and W is possible"));
    EXPECT_THAT(refusal("unit=cm"),
                HasSubstr("squareness: unit=cm: give mm, metric, in, inch, imperial, or the number"));
    EXPECT_THAT(refusal("table=errors.csv"), HasSubstr("table=errors.csv: give an absolute path"));
    EXPECT_THAT(refusal("table=/nowhere/errors.csv"), HasSubstr("/nowhere/errors.csv: No such file"));
}

}  // namespace
}  // namespace plumb
