// SPDX-License-Identifier: GPL-2.0-or-later
// The radius of G41 and G42 as a part of the tool's vector: for a tip that is turned to the contour.
#include "tests/support/square.hpp"

#include <cstdio>
#include <limits>
#include <random>

namespace plumb {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double endless = std::numeric_limits<double>::infinity();
constexpr double radius = 25, length = 200, speed = 40;  // mm, mm/s

using Moving = Square::Moving;
using Path = std::function<Moving(double)>;

// The axis of the tool on a circle in X and Y, counterclockwise from +X.
Path circle(double its_radius) {
    const double turns = speed / its_radius;
    return [=](double t) {
        const double c = std::cos(turns * t), s = std::sin(turns * t);
        return Moving{{its_radius * c, its_radius * s, -50, 0}, {-speed * s, speed * c, 0, 0}};
    };
}

// A square pocket, counterclockwise from the middle of the right side: at each corner the direction jumps.
constexpr double half_side = 10;  // mm
Path pocket(std::size_t a = 0, std::size_t b = 1) {
    return [=](double t) {
        const double side = 2 * half_side / speed, since = t + side / 2;
        const int number = static_cast<int>(since / side);
        const double along = (since - number * side) * speed - half_side;
        const double directions[4][2] = {{0, 1}, {-1, 0}, {0, -1}, {1, 0}};
        const double* d = directions[number % 4];
        Moving now{{0, 0, -50, 0}, {}};
        now.position[a] = along * d[0] + half_side * d[1];
        now.position[b] = along * d[1] - half_side * d[0];
        now.velocity[a] = speed * d[0];
        now.velocity[b] = speed * d[1];
        return now;
    };
}

// Two of them on one path; the other one knows no contour, so the difference is the part of the radius.
struct Contouring {
    explicit Contouring(const std::string& chain = column_chain) : bench(Bench::Thread::servo) {
        bench.command("loadrt squareness names=square,other interlock=no " + chain + "," + chain.substr(6));
        bench.command("loadrt joint_offset names=x-stage,y-stage,z-stage interlock=no");
        for (const char* it : {"square", "other"})
            bench.command(std::string("addf ") + it + ".update servo-thread");
        for (const std::string it : {"x", "y", "z"}) {
            bench.command("net " + it + "-correction square." + it + "-correction => " + it +
                          "-stage.offset-0");
            for (const auto& [pin, value] : Square::Values{{"min-limit", -1000},
                                                           {"max-limit", 1000},
                                                           {"joint-acceleration", 1000},
                                                           {"offset-acceleration", acceleration},
                                                           {"homed", 1},
                                                           {"motion-enabled", 1}})
                bench.set(it + "-stage." + pin, value);
            bench.command("addf " + it + "-stage.update servo-thread");
        }
        set_both({{"all-homed", 1}, {"enable", 1}, {"max-speed", 1000}, {"max-rate", max_rate}});
        set_both({{"z-tool-offset", length}});
        if (chain == column_chain)
            set_both({{"ea0y", column.ea0y}, {"ec0y", column.ec0y}});
        else
            set_both(
                {{"ea0w", portal.ea0w}, {"eb0w", portal.eb0w}, {"ea0z", portal.ea0z}, {"eb0z", portal.eb0z}});
        set("tip-on-contour", 1);
    }

    void set(const std::string& pin, double value) { bench.set("square." + pin, value); }
    void set_both(const Square::Values& values) {
        for (const auto& [pin, value] : values)
            for (const char* it : {"square.", "other."}) bench.set(it + pin, value);
    }
    double get(const std::string& pin) { return bench.get("square." + pin); }
    void run(double seconds) { bench.run(seconds); }

    // Both go along the path from now on, as far as run() lets them.
    void follow(const Path& path, double seconds) {
        std::string text = "time";
        for (const char* it : {"square.", "other."})
            for (const char* axis : {"x", "y", "z"})
                text += std::string(",") + it + axis + "-position," + it + axis + "-velocity";
        for (int n = 0; n <= seconds * 1000 + 0.5; ++n) {
            const Moving at = path(n * 0.001);
            text += '\n' + std::to_string(n * 0.001);
            char number[40];
            for (int instance = 0; instance < 2; ++instance)
                for (std::size_t i = 0; i < 3; ++i)
                    for (const double value : {at.position[i], at.velocity[i]}) {
                        std::snprintf(number, sizeof number, ",%.17g", value);
                        text += number;
                    }
        }
        bench.client().replay({folder.write("path.csv", text + '\n')});
    }

    void begin(const Path& path, double seconds) {
        const Moving at = path(0);
        for (std::size_t i = 0; i < 3; ++i)
            set_both({{std::string(1, "xyz"[i]) + "-position", at.position[i]}});
        run(4);
        EXPECT_FALSE(get("ramping"));
        follow(path, seconds);
    }

    // The part of the correction that comes from the radius.
    Vec part() {
        const auto of = [&](const std::string& axis) {
            return get(axis + "-correction") - bench.get("other." + axis + "-correction");
        };
        return {of("x"), of("y"), of("z")};
    }
    // That part changes no faster than max-rate from now on.
    void never_faster() {
        bench.expect(
            "(x_rate - u_rate) * (x_rate - u_rate) + (y_rate - v_rate) * (y_rate - v_rate) + "
            "(z_rate - w_rate) * (z_rate - w_rate) <= 1.001 * " +
                std::to_string(max_rate * max_rate),
            {{"x", "square.x-correction"},
             {"y", "square.y-correction"},
             {"z", "square.z-correction"},
             {"u", "other.x-correction"},
             {"v", "other.y-correction"},
             {"w", "other.z-correction"}});
    }

    // How far the tip is off on the machine itself, with the tip in this direction from the tool's axis.
    template <typename Machine>
    double off(const Machine& machine, const Vec& tip) {
        const Vec tool = tip + Vec{0, 0, -length};
        const Position q{get("x-position"), get("y-position"), get("z-position"), 0};
        const Position there{q[0] + get("x-correction"), q[1] + get("y-correction"),
                             q[2] + get("z-correction"), 0};
        return (machine.tip(there, tool) - ideal_tip(q, tool)).length();
    }

    static constexpr double max_rate = 0.1, acceleration = 500;  // mm/s, mm/s2
    const LeaningColumn column{120 * urad, -160 * urad};
    const LeaningPortal portal{40 * urad, -30 * urad, -130 * urad, 90 * urad};
    Folder folder;
    Bench bench;
};

// From its place on the circle, not from its velocity.
Vec outwards(Contouring& square) {
    const double x = square.get("x-position"), y = square.get("y-position"), r = std::hypot(x, y);
    return {radius * x / r, radius * y / r, 0};
}

TEST(SquarenessContour, BoreAndBossAreRightAllAroundAndWrongWithoutTheRadius) {
    for (const bool bored : {true, false}) {
        Contouring square;
        square.set("compensation-radius", bored ? radius : -radius);  // the boss: G42, counterclockwise
        square.never_faster();
        square.begin(circle(bored ? 35 : 65), 12);
        square.run(0.2);
        for (int n = 0; n < 100; ++n) {
            square.run(0.1);
            const Vec tip = outwards(square) * (bored ? 1 : -1);
            EXPECT_LT(square.off(square.column, tip), 1e-9);
            EXPECT_FALSE(square.get("ramping")) << "an arc is followed without lag";
            const Vec first_order{-160 * urad * tip.y, 160 * urad * tip.x, -120 * urad * tip.y};
            EXPECT_LT((square.part() - first_order).length(), 0.01 * um);
        }
        square.set("tip-on-contour", 0);
        square.run(0.2);
        EXPECT_EQ(square.part().length(), 0);
        EXPECT_GT(square.off(square.column, outwards(square) * (bored ? 1 : -1)), 4 * um);
        EXPECT_EQ(square.get("fault-code"), 0);
    }
}

TEST(SquarenessContour, PlaneG18HasItsAxes) {
    Contouring square(portal_chain);
    square.set("compensation-radius", -radius);
    square.set("compensation-plane", 18);
    square.never_faster();
    const double turns = speed / 65;  // about a boss, towards +Z at -X: G42
    square.begin(
        [=](double t) {
            const double c = std::cos(turns * t), s = std::sin(turns * t);
            return Moving{{-65 * c, 0, 65 * s, 0}, {speed * s, 0, speed * c, 0}};
        },
        5);
    square.run(0.2);
    for (int n = 0; n < 40; ++n) {
        square.run(0.1);
        const double x = square.get("x-position"), z = square.get("z-position"), r = std::hypot(x, z);
        const Vec inwards{-radius * x / r, 0, -radius * z / r};
        EXPECT_LT(square.off(square.portal, inwards), 1e-9);
        EXPECT_GT(square.off(square.portal, inwards * -1), 2.9 * um) << "twice 60 urad of 25 mm, at least";
    }
}

// One round takes 2 s, and the part of the radius jumps by 7 um at each corner.
TEST(SquarenessContour, CornerIsRampedAndStepsNowhere) {
    Contouring square;
    square.set("compensation-radius", radius);
    square.never_faster();
    square.begin(pocket(), 6);
    square.run(0.2);
    const Vec sides[4] = {{radius, 0, 0}, {0, radius, 0}, {-radius, 0, 0}, {0, -radius, 0}};
    for (int n = 0; n < 10; ++n) {
        EXPECT_LT(square.off(square.column, sides[n % 4]), 1e-9) << n;
        square.run(0.052);
        EXPECT_TRUE(square.get("ramping")) << "behind the corner";
        square.run(0.448);
        EXPECT_FALSE(square.get("ramping"));
    }
}

TEST(SquarenessContour, StagesObeyTheirAccelerationAtEachCornerAndToggle) {
    Contouring square;
    square.set("compensation-radius", radius);
    square.begin(pocket(), 40);
    std::mt19937 random(7);
    const std::vector<std::pair<std::string, std::vector<double>>> toggles{
        {"compensation-radius", {radius, -radius, 0, 2 * radius}},
        {"tip-on-contour", {1, 0}},
        {"coordinated", {1, 0}},
        {"compensation-plane", {17, 18}}};
    double largest = 0, farthest = 0, most = 0;
    std::vector<double> last[3];
    for (int n = 0; n < 150; ++n) {
        const auto& [pin, values] = toggles[random() % toggles.size()];
        square.set(pin, values[random() % values.size()]);
        const Table table = square.bench.trace(
            0.02 + 0.001 * static_cast<double>(random() % 200),
            {"x-stage.applied-offset", "y-stage.applied-offset", "z-stage.applied-offset"});
        for (std::size_t i = 0; i < 3; ++i) {
            const std::string name = std::string(1, "xyz"[i]) + "-stage.applied-offset";
            for (const double value : table.column(name)) {
                if (last[i].size() == 2) {
                    largest = std::max(largest, std::abs(value - 2 * last[i][1] + last[i][0]) / 1e-6);
                    last[i].erase(last[i].begin());
                }
                last[i].push_back(value);
                most = std::max(most, std::abs(value));
            }
            farthest = std::max(farthest, std::abs(square.bench.get(name) -
                                                   square.get(std::string(1, "xyz"[i]) + "-correction")));
        }
    }
    EXPECT_LE(largest, Contouring::acceleration * (1 + 1e-6));
    EXPECT_GT(largest, 20);
    EXPECT_GT(most, 4 * um);
    EXPECT_LT(farthest, 0.3 * um);
}

TEST(SquarenessContour, SideAndRadiusMayChangeInMotionAndEndByTheRamp) {
    Contouring square;
    square.set("compensation-radius", radius);
    square.never_faster();
    square.begin(circle(35), 12);
    square.run(1);
    for (const double next : {-radius, radius / 2, 0.0, radius, -radius / 2, 0.0}) {
        square.set("compensation-radius", next);
        square.run(0.003);
        EXPECT_TRUE(square.get("ramping")) << next;
        square.run(0.3);
        EXPECT_FALSE(square.get("ramping")) << next;
        EXPECT_LT(square.off(square.column, outwards(square) * (next / radius)), 1e-9) << next;
    }
}

TEST(SquarenessContour, AtRestAndAcrossThePlaneTheDirectionStays) {
    Contouring square;
    square.set("compensation-radius", radius);
    square.never_faster();
    square.begin(
        [](double t) {
            if (t < 1) return Moving{{30 * t, 0, -50, 0}, {30, 0, 0, 0}};
            if (t < 2) return Moving{{30, 0, -50, 0}, {}};
            return Moving{{30, 0, -30 - 20 * t / 2, 0}, {0, 0, -10, 0}};
        },
        3);
    for (int n = 0; n < 30; ++n) {
        square.run(0.1);
        EXPECT_LT(square.off(square.column, {0, -radius, 0}), n ? 1e-9 : um);
    }
    square.set("compensation-radius", 0);
    square.run(0.1);
    EXPECT_EQ(square.part().length(), 0);
}

// Jogs are on no contour.
TEST(SquarenessContour, JogsAndAnAbortedProgramHaveNoRadius) {
    Contouring square;
    square.set("compensation-radius", radius);
    square.never_faster();
    square.begin(circle(35), 5);
    square.run(1);
    square.set("coordinated", 0);
    square.run(0.1);
    EXPECT_EQ(square.part().length(), 0);
    square.set("coordinated", 1);
    square.run(0.1);
    EXPECT_LT(square.off(square.column, outwards(square)), 1e-9);
}

TEST(SquarenessContour, ItTakesThePlaceOfTheRadialOffsetAndGivesItBack) {
    Contouring square;
    square.set_both({{"radial-offset", 10}, {"radial-direction", 30}});
    square.never_faster();
    square.begin(circle(35), 3);
    square.run(0.5);
    EXPECT_EQ(square.part().length(), 0);
    square.set("compensation-radius", radius);
    square.run(0.3);
    EXPECT_LT(square.off(square.column, outwards(square)), 1e-9);
    square.set("compensation-radius", 0);
    square.run(0.3);
    EXPECT_EQ(square.part().length(), 0);
}

TEST(SquarenessContour, OffItDoesNothingAtAll) {
    Contouring square;
    square.set("tip-on-contour", 0);
    square.bench.expect("x == u && y == v && z == w && fault == 0", {{"x", "square.x-correction"},
                                                                     {"y", "square.y-correction"},
                                                                     {"z", "square.z-correction"},
                                                                     {"u", "other.x-correction"},
                                                                     {"v", "other.y-correction"},
                                                                     {"w", "other.z-correction"},
                                                                     {"fault", "square.fault"}});
    square.begin(circle(35), 10);
    for (const double bad : {radius, -radius, not_a_number, 1e308, endless, 0.0})
        for (const char* pin : {"compensation-radius", "compensation-plane"}) {
            square.set(pin, bad);
            square.set("compensation-side", 0);
            square.run(0.5);
        }
}

// A cut does not wait for its corners, and no corner is a tool that changed in a cut.
TEST(SquarenessContour, NothingSettlesInTheCut) {
    Contouring square;
    square.begin(pocket(), 4);
    square.set("motion-type", 2);
    square.set("path-velocity", speed);
    square.bench.expect("settling == 0 && unsettled == 0",
                        {{"settling", "square.settling"}, {"unsettled", "square.unsettled"}});
    square.set("compensation-radius", radius);
    square.run(3);
    square.set("compensation-radius", 0);
    square.run(0.5);
}

// linuxcnc_link looks in each period here.
void watch(Contouring& square) {
    square.bench.command("loadrt not names=look");
    square.bench.command("addf look servo-thread");
    square.bench.command("net look look.out => look.in square.compensation-heartbeat");
}
constexpr double patience = 0.05;  // s, 50 looks

TEST(SquarenessContour, RadiusThatTheProgramContradictsIsAFaultAndIsNotCorrected) {
    for (const auto& [its_radius, side] :
         std::vector<std::pair<double, int>>{{radius, 0}, {radius, -1}, {-radius, 1}}) {
        Contouring square;
        watch(square);
        square.never_faster();
        square.begin(circle(35), 12);
        square.set("compensation-radius", its_radius);
        square.run(0.2);
        square.set("compensation-side", side);
        square.run(patience - 0.003);
        EXPECT_EQ(square.get("fault-code"), 0) << "linuxcnc_link is later than motion";
        EXPECT_LT(square.off(square.column, outwards(square) * (its_radius / radius)), 1e-9);
        square.run(0.2);
        EXPECT_EQ(square.get("fault-code"), 12);
        EXPECT_EQ(square.part().length(), 0);
        for (const int right : {its_radius > 0 ? 1 : -1, 2}) {
            square.set("compensation-side", right);
            square.run(0.3);
            EXPECT_EQ(square.get("fault-code"), 0);
            EXPECT_LT(square.off(square.column, outwards(square) * (its_radius / radius)), 1e-9);
        }
        square.set("compensation-side", side);
        square.run(0.2);
        EXPECT_EQ(square.get("fault-code"), 12);
        square.set("compensation-radius", 0);
        square.run(0.001);
        EXPECT_EQ(square.get("fault-code"), 0);
    }
}

TEST(SquarenessContour, AtRestNothingIsContradicted) {
    Contouring square;
    watch(square);
    square.set("compensation-radius", radius);
    square.set("compensation-side", 0);
    square.run(1);
    EXPECT_EQ(square.get("fault-code"), 0) << "G40 of MDI acts with the next move";
}

TEST(SquarenessContour, SideThatNoProgramLooksAtContradictsNothing) {
    Contouring square;
    square.begin(circle(35), 6);
    square.set("compensation-radius", radius);
    square.set("compensation-side", 0);
    square.run(5);
    EXPECT_EQ(square.get("fault-code"), 0);
}

TEST(SquarenessContour, InvalidRadiusOrPlaneLeavesTheLastGoodOneAlsoInMotion) {
    Contouring square;
    square.set("compensation-radius", radius);
    square.never_faster();
    square.begin(circle(35), 12);
    square.run(0.5);
    for (const auto& [pin, values] : std::map<std::string, std::vector<double>>{
             {"compensation-radius", {not_a_number, endless, -1e308, 1.1e4}},
             {"compensation-plane", {not_a_number, endless, -1e308, 0, 16, 17.5, 20}}})
        for (const double bad : values) {
            const double own = square.get(pin);
            square.set(pin, bad);
            square.run(0.2);
            EXPECT_EQ(square.get("fault-code"), 11) << pin << " = " << bad;
            EXPECT_LT(square.off(square.column, outwards(square)), 1e-9) << pin << " = " << bad;
            square.set(pin, own);
            square.run(0.001);
            EXPECT_EQ(square.get("fault-code"), 0);
        }
    square.set("compensation-radius", 0);
    square.set("compensation-plane", 0);
    square.run(0.1);
    EXPECT_EQ(square.get("fault-code"), 0) << "outputs of LinuxCNC before the first contour";
}

// All at once, at random: bound and rate hold, and given back, the tip is right again.
TEST(SquarenessContour, RandomInputsKeepBoundAndRate) {
    Contouring square;
    const double by_motion = 3 * speed * 160 * urad;
    for (const char* axis : {"x", "y", "z"})
        square.bench.expect(
            "abs(c) <= 1 && abs(c_rate) <= " + std::to_string(Contouring::max_rate + by_motion),
            {{"c", std::string("square.") + axis + "-correction"}});
    square.begin(circle(35), 120);
    std::mt19937 random(11);
    const std::vector<double> lengths{radius, -radius, 0,       1e4,          -1e4,
                                      1e308,  -1e308,  endless, not_a_number, 1e-300};
    const std::vector<double> bits{0, 1};
    const std::map<std::string, std::vector<double>> inputs{
        {"compensation-radius", lengths},
        {"compensation-plane", {17, 18, 19, 0, 17.5, 1e308, not_a_number}},
        {"compensation-side", {-1, 0, 1, 2, 7, -2147483648.0, 2147483647.0}},
        {"tip-on-contour", bits},
        {"coordinated", bits},
        {"compensation-heartbeat", bits},
        {"enable", bits},
        {"all-homed", bits},
        {"radial-offset", lengths},
        {"radial-direction", {0, 30, 1e308, not_a_number}},
        {"z-tool-offset", {length, 100, not_a_number, 1e308}}};
    for (int n = 0; n < 800; ++n) {
        auto input = inputs.begin();
        std::advance(input, random() % inputs.size());
        square.set(input->first, input->second[random() % input->second.size()]);
        square.run(0.001 * static_cast<double>(1 + random() % 100));
    }
    const Square::Values own{{"compensation-radius", radius},
                             {"compensation-plane", 17},
                             {"compensation-side", 2},
                             {"tip-on-contour", 1},
                             {"coordinated", 1},
                             {"enable", 1},
                             {"all-homed", 1},
                             {"radial-offset", 0},
                             {"radial-direction", 0},
                             {"z-tool-offset", length}};
    for (const auto& [pin, value] : own) square.set(pin, value);
    square.run(25);
    EXPECT_EQ(square.get("fault-code"), 0);
    EXPECT_LT(square.off(square.column, outwards(square)), 1e-9);
}

}  // namespace
}  // namespace plumb
