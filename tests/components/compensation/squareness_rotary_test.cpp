// SPDX-License-Identifier: GPL-2.0-or-later
// squareness on a trunnion: a table C on a cradle A on Y, against a product of poses.
#include "tests/support/error_table_text.hpp"
#include "tests/support/module.hpp"
#include "tests/support/square.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

namespace plumb {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::HasSubstr;

const std::string trunnion = "chain=w-C-A-Y.b-X-Z-t rotary=AC";
const Vector3d tool(0, 0, -150);
const Vector3d point(200, 150, -400);  // where A and C meet

Isometry3d about(const Vector3d& axis, double angle) {
    return Isometry3d(Eigen::AngleAxisd(angle, axis));
}
Isometry3d move(const Vector3d& by) {
    return Isometry3d(Eigen::Translation3d(by));
}

// Radial motion and wobble of C, once and twice a turn.
double exc(double c) {
    return 0.008 * std::sin(c * pi / 180) + 0.003 * std::cos(2 * c * pi / 180);
}
double eac(double c) {
    return 20e-6 * std::cos(c * pi / 180);
}

struct Trunnion {
    Vector3d place_a{0, 0.021, -0.013}, place_c{0.017, -0.009, 0};
    double eb0a = 60e-6, ec0a = -45e-6, ea0c = 35e-6, eb0c = -70e-6;
    bool with_table = false;

    // The tip in the work; 0: of an ideal machine.
    Vector3d tip(const Vector3d& q, double a, double c, double errors) const {
        const Isometry3d saddle = move({0, -q.y(), 0});
        const Isometry3d cradle = move(point + errors * place_a) * about(Vector3d::UnitZ(), errors * ec0a) *
                                  about(Vector3d::UnitY(), errors * eb0a) *
                                  about(Vector3d::UnitX(), -a * pi / 180) * move(-point);
        const double its = with_table ? errors : 0;
        const Isometry3d table = move(point + errors * place_c) * about(Vector3d::UnitY(), errors * eb0c) *
                                 about(Vector3d::UnitX(), errors * ea0c) * move({-its * exc(c), 0, 0}) *
                                 about(Vector3d::UnitX(), its * eac(c)) *
                                 about(Vector3d::UnitZ(), -c * pi / 180) * move(-point);
        return (saddle * cradle * table).inverse() * (Vector3d(q.x(), 0, q.z()) + tool);
    }
    void set_up(Square& square) const {
        for (const std::string axis : {"a", "c"})
            for (int i = 0; i < 3; ++i) square.set(axis + "-" + "xyz"[i] + "-pivot", point[i]);
        square.set({{"ey0a", place_a.y()}, {"ez0a", place_a.z()}, {"eb0a", eb0a}, {"ec0a", ec0a}});
        square.set({{"ex0c", place_c.x()}, {"ey0c", place_c.y()}, {"ea0c", ea0c}, {"eb0c", eb0c}});
        square.set_tool({tool.x(), tool.y(), tool.z()});
    }
};

// Each 5 deg round, the last row the first one.
std::string table_of_c() {
    std::string text = "C,EXC,EAC";
    for (int c = -180; c <= 180; c += 5) {
        char row[80];
        const double at = c == 180 ? -180 : c;
        std::snprintf(row, sizeof row, "\n%d,%.17g,%.17g", c, exc(at), eac(at));
        text += row;
    }
    return closed(text + '\n');
}

// The component on a trunnion, its table of C if it is asked for.
struct OnTrunnion {
    explicit OnTrunnion(bool with_table = false)
        : square(trunnion + (with_table ? " table=" + folder.write("c.csv", table_of_c()).string() : "")) {
        machine.with_table = with_table;
        machine.set_up(square);
    }

    const Folder folder;
    Trunnion machine;
    Square square;
};

double rest(OnTrunnion& its, const Vector3d& q, double a, double c) {
    Square& square = its.square;
    const Trunnion& machine = its.machine;
    square.set({{"a-position", a}, {"c-position", c}});
    square.go({q.x(), q.y(), q.z(), 0});
    const Vec offset = square.get_xyz("correction");
    const Vector3d there = q + Vector3d(offset.x, offset.y, offset.z);
    return (machine.tip(there, a, c, 1) - machine.tip(q, a, c, 0)).norm();
}

TEST(SquarenessRotary, PlaceErrorsAndTiltsOfATrunnionAreCorrectedExactly) {
    OnTrunnion its;
    Square& square = its.square;
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(-100, 100), angle(-110, 110), turns(-500, 500);
    double worst = 0, before = 0;
    for (int n = 0; n < 40; ++n) {
        const Vector3d q = point + Vector3d(place(random), place(random), place(random) + 150);
        const double a = angle(random), c = turns(random);
        before = std::max(before, (its.machine.tip(q, a, c, 1) - its.machine.tip(q, a, c, 0)).norm());
        worst = std::max(worst, rest(its, q, a, c));
    }
    EXPECT_GT(before, 30 * um);
    EXPECT_LT(worst, 1e-9);
    EXPECT_EQ(square.get("fault-code"), 0);
}

TEST(SquarenessRotary, ATableOfCHoldsForAllTurns) {
    OnTrunnion its(true);
    Square& square = its.square;
    double worst = 0;
    for (const double c : {-723.0, -180.0, -2.0, 0.0, 91.3, 178.0, 182.0, 360.0, 3599.0})
        worst = std::max(worst, rest(its, point + Vector3d(80, -60, 170), 25, c));
    EXPECT_LT(worst, 0.1 * um) << "cubics each 5 deg";
    EXPECT_EQ(square.get("limited-code"), 0);
    EXPECT_EQ(square.get("tables"), 1);
}

TEST(SquarenessRotary, VelocityIsThatOfTheCorrectionWhileAllAxesMove) {
    OnTrunnion its(true);
    Square& square = its.square;
    square.set("c-position", 0);
    square.go({250, 100, -200, 0});
    std::string text =
        "time,square.x-position,square.x-velocity,square.a-position,square.a-velocity,square.c-position,"
        "square.c-velocity\n";
    char row[200];
    for (int n = 0; n <= 2000; ++n) {
        const double t = n * 0.001;
        std::snprintf(row, sizeof row, "%.3f,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", t,
                      250 + 40 * std::sin(t), 40 * std::cos(t), 30 * std::sin(1.3 * t),
                      39 * std::cos(1.3 * t), 90 * t, 90.0);
        text += row;
    }
    square.bench.client().replay({its.folder.write("path.csv", text)});
    std::vector<std::string> names;
    for (const char* axis : {"x", "y", "z"})
        for (const char* what : {"-corrected-position", "-corrected-velocity"})
            names.push_back(std::string("square.") + axis + what);
    const Table table = square.bench.trace(1.9, names);
    for (const std::string axis : {"x", "y", "z"})
        EXPECT_LT(worst_velocity(table, "square." + axis + "-corrected-position",
                                 "square." + axis + "-corrected-velocity"),
                  2e-4)
            << axis << ", mm/s; the correction itself moves at up to 0.05 mm/s";
}

TEST(SquarenessRotary, AgainstTheConventionIsTheOtherAngle) {
    OnTrunnion its;
    Square& square = its.square;
    const Trunnion& machine = its.machine;
    square.set({{"a-reversed", 1}, {"c-reversed", 1}, {"a-position", -30}, {"c-position", -75}});
    const Vector3d q = point + Vector3d(60, 50, 150);
    square.go({q.x(), q.y(), q.z(), 0});
    const Vec offset = square.get_xyz("correction");
    EXPECT_LT((machine.tip(q + Vector3d(offset.x, offset.y, offset.z), 30, 75, 1) - machine.tip(q, 30, 75, 0))
                  .norm(),
              1e-9);
}

TEST(SquarenessRotary, AJumpOfTheAngleIsRamped) {
    OnTrunnion its;
    Square& square = its.square;
    square.go({250, 100, -200, 0});
    square.set("max-rate", 0.1);
    square.never_faster_than(0.1);
    square.set("a-position", 70);  // as homing sets it
    square.run(0.01);
    EXPECT_TRUE(square.get("ramping"));
    square.run(2);
    EXPECT_FALSE(square.get("ramping"));
}

TEST(SquarenessRotary, ASingularPoseIsNamed) {
    // A head A carries Z: at 90 deg Z moves the tool along Y, and nothing moves it upwards.
    Square square("chain=w-Y.b-X-A-Z-t rotary=A");
    square.set({{"eb0z", 100 * urad}, {"ea0z", 50 * urad}, {"a-position", 20}});
    square.go({100, 50, -100, 0});
    EXPECT_EQ(square.get("fault-code"), 0);
    EXPECT_NE(square.get("z-correction"), 0);
    for (const double a : {90.0, 89.999, -90.0}) {
        square.set("a-position", a);
        square.run(0.5);
        EXPECT_EQ(square.get("fault-code"), 15) << a;
        EXPECT_EQ(square.get("z-correction"), 0) << a;
    }
    square.set("a-position", 20);
    square.run(0.5);
    EXPECT_EQ(square.get("fault-code"), 0);
}

// The tool is 8 m long: a turn of 0.09 mrad per mm of travel moves the tip by 0.72 mm per mm.
TEST(SquarenessRotary, ErrorsThatChangeTooFastAreNoSingularPose) {
    const Folder folder;
    Square square("chain=w-A-Y.b-X-Z-t rotary=A table=" +
                  folder.write("x.csv", closed("X,EBX\n0,0\n50,0.0045\n100,0.009\n")).string());
    square.set_tool({0, 0, -8000});
    square.go({50, 0, 0, 0});
    EXPECT_EQ(square.get("fault-code"), 9);
}

TEST(SquarenessRotary, WrongOnesAreRefused) {
    const Folder folder;
    Bench bench(Bench::Thread::none);
    const auto refused = [&](const std::string& options) {
        std::vector<std::string> words{"loadrt", "squareness", "names=square"};
        for (std::size_t begin = 0; begin < options.size(); begin = words.back().size() + begin + 1)
            words.push_back(options.substr(begin, options.find(' ', begin) - begin));
        const client::Halcmd answer = bench.client().halcmd(words);
        EXPECT_NE(answer.status, 0) << options;
        return answer.output;
    };
    EXPECT_THAT(refused("chain=w-A-Y.b-X-Z-t"), HasSubstr("rotary does not name"));
    EXPECT_THAT(refused("chain=w-Y.b-X-Z-t rotary=A"), HasSubstr("A is missing"));
    const auto table = [&](const std::string& text) {
        return refused(trunnion + " table=" + folder.write("c.csv", closed(text)).string());
    };
    EXPECT_THAT(table("C,EXC\n0,0\n180,0.001\n360,0.002\n"), HasSubstr("are one place"));
    EXPECT_THAT(table("C,EXC\n0,0\n180,0.001\n400,0\n"), HasSubstr("more than a turn"));
    EXPECT_THAT(table("C,EXC+,EXC-\n0,0,0\n180,0.001,0\n"), HasSubstr("not possible for a rotary axis"));
    EXPECT_THAT(table("B,EXB\n0,0\n180,0.001\n"), HasSubstr("an axis that the chain does not have"));
}

}  // namespace
}  // namespace plumb
