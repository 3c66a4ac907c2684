// SPDX-License-Identifier: GPL-2.0-or-later
// squareness with tables of errors, which parabolas meet exactly.
#include "tests/support/error_table_text.hpp"
#include "tests/support/module.hpp"
#include "tests/support/place.hpp"
#include "tests/support/square.hpp"

#include <gmock/gmock.h>

#include <cstdio>
#include <random>

namespace plumb {
namespace {

using testing::HasSubstr;

// Error motions of an axis, in mm and rad: 20 um and 60 urad over a metre.
struct Parabolas {
    double seed;

    Vec translation(double s) const {
        const double t = s / 500 - 0.1 * seed;
        return Vec{t * t - 0.3, 0.5 - t * t * seed, t * (1 - seed * t)} * (10 * um);
    }
    Vec angles(double s) const {
        const double t = s / 500 + 0.2 * seed;
        return Vec{t * t * seed, 0.3 - t * t, t * (seed - t)} * (30 * urad);
    }
};

std::string table_of(char axis, const Parabolas& errors) {
    std::string text(1, axis);
    for (const char* name : {"EX", "EY", "EZ", "EA", "EB", "EC"}) text += std::string(",") + name + axis;
    for (double s = -700; s <= 700; s += s < 0 ? 35 : 70) {
        const Vec t = errors.translation(s), a = errors.angles(s);
        char row[200];
        std::snprintf(row, sizeof row, "\n%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", s, t.x, t.y, t.z, a.x,
                      a.y, a.z);
        text += row;
    }
    return text + '\n';
}

// w-Z.b-X-Y-C-t with errors of all axes, and a column that leans.
struct WornColumn {
    Parabolas x{1.1}, y{-0.7}, z{0.4};
    Vec tilt{80 * arcsec, 0, -60 * arcsec};
    double y_pivot = 150;  // of the tilt; the tables know nothing of it

    Vec tip(const Position& q, const Vec& tool) const {
        Vec v = turned(y.angles(q[1]), tool) + Vec{0, q[1] - y_pivot, 0} + y.translation(q[1]);
        v = turned(x.angles(q[0]), turned(tilt, v)) + Vec{q[0], 0, 0} + x.translation(q[0]);
        return turned_back(z.angles(q[2]), v + Vec{0, 0, q[2]} + z.translation(q[2]));
    }
    std::string tables() const { return closed(table_of('X', x) + table_of('Y', y) + table_of('Z', z)); }
    void set_up(Square& square, double unit = 1) const {
        square.set({{"ea0y", tilt.x}, {"ec0y", tilt.z}, {"y-pivot", y_pivot / unit}});
    }
    Vec ideal(const Position& q, const Vec& tool) const { return ideal_tip(q, tool) - Vec{0, y_pivot, 0}; }
    double rest(Square& square, const Position& q, const Vec& tool) const {
        return (tip(square.corrected(q), tool) - ideal(q, tool)).length();
    }
};

const Vec long_tool{40, 30, -400};

// An INI file has no empty values.
TEST(SquarenessTables, NoneIsNoTable) {
    Square square(std::string(column_chain) + " table=none");
    EXPECT_EQ(square.get("tables"), 0);
    EXPECT_EQ(square.get("fault-code"), 0);
}

TEST(SquarenessTables, ErrorsOfAllAxesAreCorrectedExactly) {
    const Folder folder;
    const WornColumn machine;
    const auto first = folder.write("xy.csv", closed(table_of('X', machine.x) + table_of('Y', machine.y)));
    const auto second = folder.write("z.csv", closed(table_of('Z', machine.z)));
    Square square(std::string(column_chain) + " table=" + first.string() + ":" + second.string());
    EXPECT_EQ(square.get("tables"), 0);
    machine.set_up(square);
    square.set_tool(long_tool);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-500, 500);
    double error = 0, rest = 0;
    for (int n = 0; n < 50; ++n) {
        const Position q{place(random), place(random), place(random), 0};
        square.go(q);
        error = std::max(error, (machine.tip(q, long_tool) - machine.ideal(q, long_tool)).length());
        rest = std::max(rest, machine.rest(square, q, long_tool));
    }
    std::printf("worn column: error up to %.0f um, corrected to %.2g um\n", error * 1000, rest * 1000);
    EXPECT_GT(error, 300 * um);
    EXPECT_LT(rest, 1e-9);
    EXPECT_EQ(square.get("tables"), 3);
    EXPECT_EQ(square.get("limited-code"), 0);
}

TEST(SquarenessTables, InchMachineReadsTheSameTables) {
    const Folder folder;
    const WornColumn machine;
    Square square(std::string(column_chain) +
                  " unit=inch table=" + folder.write("all.csv", machine.tables()).string());
    machine.set_up(square, 25.4);
    square.set_tool(long_tool * (1 / 25.4));
    const Position q{300, -400, 250, 0};
    square.go({q[0] / 25.4, q[1] / 25.4, q[2] / 25.4, 0});
    const Vec c = square.get_xyz("correction") * 25.4;
    EXPECT_LT((machine.tip({q[0] + c.x, q[1] + c.y, q[2] + c.z, 0}, long_tool) - machine.ideal(q, long_tool))
                  .length(),
              1e-9);
}

// At 100 mm/s, on a machine whose unit has so many millimetres.
void velocity_is_the_derivative_of_position(double unit) {
    const Folder folder;
    const std::string tables =
        closed(table_of('X', {1}) + table_of('Y', {-1.2}) + table_of('Z', {0.7}) + table_of('W', {1.5}));
    Square square(std::string(portal_chain) + " table=" + folder.write("all.csv", tables).string() +
                  (unit > 1 ? " unit=inch" : ""));
    square.set({{"ea0w", 100 * arcsec}, {"eb0z", 70 * arcsec}});
    square.set_tool(long_tool * (1 / unit));
    const auto path = [unit](double t) {
        const double w = 0.5, s = std::sin(w * t) / unit, c = std::cos(w * t) / unit;
        return Square::Moving{{200 * c, 200 * s, 60 * s - 100 / unit, 50 * c},
                              {-200 * w * s, 200 * w * c, 60 * w * c, -50 * w * s}};
    };
    square.go(path(0).position);
    square.follow(path, 4);
    double worst = 0;
    std::vector<std::string> names;
    for (const char* axis : {"x", "y", "z"})
        for (const char* what : {"-corrected-position", "-corrected-velocity"})
            names.push_back(std::string("square.") + axis + what);
    const Table table = square.bench.trace(3.9, names);
    for (std::size_t i = 0; i < names.size(); i += 2)
        worst = std::max(worst, worst_velocity(table, names[i], names[i + 1]));
    std::printf("with tables velocities err by %.2g mm/s at 100 mm/s\n", worst * unit);
    EXPECT_LT(worst * unit, 1e-8 * 100);
}

TEST(SquarenessTables, VelocityIsTheDerivativeOfPositionInMillimetresAndInInches) {
    velocity_is_the_derivative_of_position(1);
    velocity_is_the_derivative_of_position(25.4);
}

// A rail whose scale is wrong by 100 um/m: the rail corrects it, and no longer Z.
TEST(SquarenessTables, CrossRailCorrectsItsScaleWithoutAStep) {
    const Folder folder;
    const std::string table = closed("W,EZW\n-500,-0.05\n500,0.05\n");
    Square square(std::string(portal_chain) + " table=" + folder.write("w.csv", table).string());
    square.set("max-rate", 0.1);
    square.go({0, 0, 0, 300});
    const double own = 300 / 1.0001 - 300;  // -30 um
    EXPECT_NEAR(square.get("z-correction"), -30 * um, 1e-9);
    EXPECT_EQ(square.get("w-correction"), 0);

    square.never_faster_than(0.1);
    square.bench.expect("abs(w_rate) <= 0.100001", {{"w", "square.w-correction"}});
    square.bench.expect("abs(z + w + 0.029997) <= 0.00001",
                        {{"w", "square.w-correction"}, {"z", "square.z-correction"}});
    square.set("parallel-axis-corrects", 1);
    square.run(0.1);
    EXPECT_TRUE(square.get("ramping"));
    EXPECT_NEAR(square.get("w-correction"), -10 * um, 0.2 * um);
    square.run(0.3);
    EXPECT_FALSE(square.get("ramping"));
    EXPECT_NEAR(square.get("w-correction"), own, 1e-9);
    EXPECT_NEAR(square.get("z-correction"), 0, 1e-9);
}

TEST(SquarenessTables, VelocityOfTheCrossRailIsTheDerivativeOfItsPosition) {
    const Folder folder;
    Square square(std::string(portal_chain) +
                  " table=" + folder.write("w.csv", closed(table_of('W', {1.5}))).string());
    square.set({{"ea0w", 100 * arcsec}, {"parallel-axis-corrects", 1}});
    const auto path = [](double t) {
        return Square::Moving{{0, 0, 0, 200 * std::sin(0.5 * t)}, {0, 0, 0, 100 * std::cos(0.5 * t)}};
    };
    square.go(path(0).position);
    square.follow(path, 4);
    const Table table = square.bench.trace(
        3.9, {"square.w-corrected-position", "square.w-corrected-velocity", "square.w-correction"});
    const auto own = table.column("square.w-correction");
    EXPECT_GT(*std::max_element(own.begin(), own.end()) - *std::min_element(own.begin(), own.end()), 2 * um);
    EXPECT_LT(worst_velocity(table, "square.w-corrected-position", "square.w-corrected-velocity"),
              1e-8 * 100);
}

TEST(SquarenessTables, AreReadAgainWithoutAStep) {
    const Folder folder;
    WornColumn machine;
    const auto file = folder.write("all.csv", machine.tables());
    Square square(std::string(column_chain) + " table=" + file.string());
    machine.set_up(square);
    square.set_tool(long_tool);
    square.set("max-rate", 0.1);
    const Position q{300, -400, 250, 0};
    square.go(q);
    EXPECT_LT(machine.rest(square, q, long_tool), 1e-9);
    square.never_faster_than(0.1);

    machine.x.seed = -0.5;
    folder.write("all.csv", machine.tables());
    square.run(0.1);
    EXPECT_GT(machine.rest(square, q, long_tool), 10 * um);
    square.set("reload", 1);
    square.run(0.01);
    EXPECT_EQ(square.get("serial"), 1);
    EXPECT_TRUE(square.get("ramping"));
    square.run(3);
    EXPECT_LT(machine.rest(square, q, long_tool), 1e-9);
    EXPECT_EQ(square.get("serial"), 1);

    // Once more while the first is on its way, and tables that are there no more.
    square.set("reload", 0);
    square.run(0.001);
    folder.write("all.csv", closed(table_of('X', machine.x)));
    square.set("reload", 1);
    square.run(0.001);
    square.set("reload", 0);
    square.run(0.001);
    square.set("reload", 1);
    square.run(3);
    EXPECT_EQ(square.get("serial"), 3);
    EXPECT_EQ(square.get("tables"), 1);
    EXPECT_FALSE(square.get("ramping"));
}

// The wanted correction changes with the place that it leads to: no period after the first may show it.
TEST(SquarenessTables, OnesThatAreFarFromThoseBeforeComeWithoutAStepToo) {
    const Folder folder;
    std::string bent = "X,EXX";
    for (int x = -100; x <= 100; x += 5)
        bent += "\n" + std::to_string(x) + "," + std::to_string(5e-6 * x * x);
    const std::string straight = "\nY,EXY\n-100,0\n100,0\n", off = "\nY,EXY\n-100,1\n100,1\n";
    Square square(std::string(column_chain) +
                  " table=" + folder.write("all.csv", closed(bent + straight)).string());
    square.set("max-rate", 0.1);
    square.go({40, 0, 0, 0});
    square.never_faster_than(0.1);
    folder.write("all.csv", closed(bent + off));
    square.set("reload", 1);
    square.run(0.5);
    EXPECT_EQ(square.get("serial"), 1);
    EXPECT_TRUE(square.get("ramping"));
    square.run(15);
    EXPECT_FALSE(square.get("ramping"));
    const double x = 40 + square.get("x-correction");
    EXPECT_NEAR(x + 5e-6 * x * x + 1, 40, 1e-9);
}

// On a long tool a turn of 0.09 mrad per mm of travel moves the tip by 0.72 mm per mm.
TEST(SquarenessTables, ErrorsThatChangeTooFastAreNotFollowedAndRampBothWays) {
    const Folder folder;
    std::string steep = "X,EBX";
    for (int x = -200; x <= 200; x += 10)
        steep += "\n" + std::to_string(x) + "," + std::to_string(x < 0 ? 0 : 9e-5 * x);
    Square square(std::string(column_chain) +
                  " table=" + folder.write("x.csv", closed(steep + "\n")).string());
    square.set({{"max-correction", 100}, {"max-rate", 0.5}, {"max-speed", 1e5}, {"ea0y", 100 * urad}});
    square.set_tool({0, 0, -8000});
    square.go({-30, 0, 0, 0});
    const double wanted = square.get("y-correction");
    EXPECT_GT(std::abs(wanted), 0.5);
    square.never_faster_than(0.5);
    square.set("x-position", 60);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 9);
    EXPECT_TRUE(square.get("fault"));
    EXPECT_TRUE(square.get("ramping"));
    square.run(4);
    EXPECT_EQ(square.get_xyz("correction").length(), 0);
    EXPECT_EQ(square.get("fault-code"), 9);
    square.set("x-position", -30);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 0);
    EXPECT_TRUE(square.get("ramping"));
    square.run(4);
    EXPECT_NEAR(square.get("y-correction"), wanted, 1e-9);
}

TEST(SquarenessTables, BadOnesLeaveThoseBeforeAndGiveTheReason) {
    const Folder folder;
    const WornColumn machine;
    const auto file = folder.write("all.csv", machine.tables());
    client::Start shown;
    shown.show_output = true;
    Square square(std::string(column_chain) + " table=" + file.string(), shown);
    machine.set_up(square);
    square.go({300, -400, 250, 0});
    const Vec before = square.get_xyz("correction");
    const auto reload = [&] {
        testing::internal::CaptureStderr();
        square.set("reload", 1);
        square.run(0.1);
        square.set("reload", 0);
        square.run(0.1);
        return testing::internal::GetCapturedStderr();
    };
    const std::string stay = "; the tables before stay in force";
    for (const auto& [text, reason] : std::vector<std::pair<std::string, std::string>>{
             {"X,EXX\n0,0\n100,nan\n", "line 3: column EXX: 'nan' is no number"},
             {"X,EXX\n0,0\n100,25\n", "line 3: column EXX: '25' is beyond 10 mm"},
             {"X,EXX\n0,0\n0,0\n", "line 3: column X: 0 is not beyond 0"},
             {"W,EXW\n0,0\n100,0\n# end, 2 rows\n",
              "there is one of W, an axis that the chain does not have"},
             {closed("X,EXX\n0,0\n50,0\n100,0\n").substr(0, 15),
              "if the 2 rows are all, add as the last line: # end, 2 rows"},
             {"", "there is no table in it"}}) {
        folder.write("all.csv", text);
        EXPECT_THAT(reload(), testing::AllOf(HasSubstr("squareness: "), HasSubstr(reason), HasSubstr(stay)));
        EXPECT_EQ((square.get_xyz("correction") - before).length(), 0);
        EXPECT_TRUE(square.get("table-fault"));
        EXPECT_EQ(square.get("fault-code"), 8);
    }
    std::filesystem::remove(file);
    EXPECT_THAT(reload(), HasSubstr(file.string() + ": No such file or directory" + stay));
    EXPECT_EQ(square.get("serial"), 0);

    folder.write("all.csv", machine.tables());
    EXPECT_THAT(reload(),
                testing::StartsWith("squareness: " + file.string() + ": error tables of X, Y, Z, 93 rows, "));
    EXPECT_EQ(square.get("serial"), 1);
    EXPECT_EQ(square.get("fault-code"), 0);
    EXPECT_EQ((square.get_xyz("correction") - before).length(), 0);
}

TEST(SquarenessTables, AreRefusedAtLoadWithFileLineAndReason) {
    const Folder folder;
    Bench bench(Bench::Thread::none);
    const auto refusal = [&](const std::string& text) {
        const auto file = folder.write("bad.csv", text).string();
        const client::Halcmd answer =
            bench.client().halcmd({"loadrt", "squareness", "names=square", column_chain, "table=" + file});
        EXPECT_NE(answer.status, 0) << text;
        EXPECT_THAT(answer.output, HasSubstr(file + ": "));
        return answer.output;
    };
    EXPECT_THAT(refusal("X,EXX\n0,0\n100,\n"), HasSubstr("line 3: column EXX: there is no value"));
    EXPECT_THAT(refusal("W,EXW\n0,0\n100,0\n# end, 2 rows\n"),
                HasSubstr("there is one of W, an axis that the chain does not have"));
}

TEST(SquarenessTables, ExampleOfTheManualPageIsTaken) {
    const Module module(build_folder() + "/modules/squareness.so");
    const std::string margin = "\n    ", end = "# end, seal 3fd7b136, 2 rows\n";
    std::string page = module.model().about.page;
    for (std::size_t at = 0; (at = page.find(margin, at)) != std::string::npos;)
        page.erase(at + 1, margin.size() - 1);
    const std::size_t from = page.find("# machine: "), to = page.find(end, from) + end.size();
    const Folder folder;
    Square square("chain=b-Y-t table=" + folder.write("y.csv", page.substr(from, to - from)).string());
    square.go({0, 50, 0, 0});
    EXPECT_NEAR(square.get("x-correction"), -1.2 * um, 0.01 * um);
}

TEST(SquarenessTables, BeyondItsEndsTheLastValueHoldsAndIsReported) {
    const Folder folder;
    const auto file = folder.write("x.csv", closed("X,EXX\n-100,-0.01\n100,0.01\n"));
    Square square(std::string(column_chain) + " table=" + file.string());
    square.go({50, 0, 0, 0});
    EXPECT_NEAR(square.get("x-correction"), -5 * um, 0.01 * um);
    EXPECT_EQ(square.get("limited-code"), 0);
    square.go({200, 0, 0, 0});
    EXPECT_NEAR(square.get("x-correction"), -10 * um, 0.01 * um);
    EXPECT_EQ(square.get("limited-code"), 4);
}

}  // namespace
}  // namespace plumb
