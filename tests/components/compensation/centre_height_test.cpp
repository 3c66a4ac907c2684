// SPDX-License-Identifier: GPL-2.0-or-later
// centre_height against a lathe of exact geometry.
#include "tests/support/bench.hpp"
#include "tests/support/hal_pins.hpp"
#include "tests/support/impossible.hpp"
#include "tests/support/module.hpp"
#include "tests/support/place.hpp"
#include "tests/support/rounds.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace plumb {
namespace {

const double degree = std::acos(-1.0) / 180;

// The tip of a tool, and the positions of its axes.
struct Lathe {
    double tip_x = 0.02;   // true distance from the axis less the position of X, outward
    double tip_y = 0.035;  // true height at Y = 0
    double angle = 90 * degree;
    double outward = 1;

    double radius(double x, double y) const {
        return std::hypot(outward * x + tip_x + y * std::cos(angle), tip_y + y * std::sin(angle));
    }
};

class CentreHeight : public testing::Test {
protected:
    CentreHeight() : bench(Bench::Thread::servo, with_specimens(true)) {
        bench.command("loadrt centre_height names=centre interlock=no posts=4 keyed_cuts=12");
        bench.command("addf centre.update servo-thread");
        set("gauge-sigma", 0.0003);
        set("enable", 1);
        set("land-step", 1);
    }
    ~CentreHeight() override {
#ifndef PLUMB_SANITIZED
        for (const client::GuardViolation& violation : bench.client().guard())
            ADD_FAILURE() << violation.function << ": " << violation.what;
#endif
    }

    void set(const std::string& pin, double value) {
        bench.set("centre." + pin, value);
    }
    double get(const std::string& pin) {
        return bench.get("centre." + pin);
    }
    void step() {
        bench.run(0.002);
    }
    void pulse(const std::string& pin) {
        set(pin, 1);
        step();
        set(pin, 0);
        step();
    }

    void begin(int cuts, int method, double y = 0) {
        y_origin = y;
        set("y-position-0", y);
        set("method", method);
        set("cuts", cuts);
        pulse("start");
    }
    void cut(const Lathe& lathe, double x, double y, const std::string& post = "0") {
        place(x, y, post);
        pulse("cut-done");
        EXPECT_EQ(get("measure"), 1);
        enter(2 * lathe.radius(x, y));
    }
    // The cut that it asks for, whose diameter the others predict.
    void check(const Lathe& lathe, const std::string& post = "0") {
        EXPECT_EQ(get("status-code"), 53);
        EXPECT_EQ(get("move-allowed"), 0);
        EXPECT_EQ(get("x-allowed"), 0);
        ASSERT_EQ(get("check-due"), 1);
        cut(lathe, get("x-zero-" + post) + get("next-x"), y_origin + get("next-y"), post);
    }
    void place(double x, double y, const std::string& post = "0") {
        set("x-position-" + post, x);
        set("y-position-" + post, y);
    }
    void enter(double diameter) {
        set("diameter", diameter);
        pulse("value-ready");
    }

    // Computes from keyed cuts: diameter, X, Y of each.
    struct Keyed {
        double diameter, x = 0, y = 0;
    };
    void key(int method, const std::vector<Keyed>& cuts, double travel = 0) {
        set("method", method);
        set("keyed", 1);
        set("cuts", static_cast<double>(cuts.size()));
        set("travel", travel);
        for (std::size_t i = 0; i < cuts.size(); ++i) {
            const std::string number = std::to_string(i);
            set("cut-diameter-" + number, cuts[i].diameter);
            set("cut-x-" + number, cuts[i].x);
            set("cut-y-" + number, cuts[i].y);
        }
        pulse("compute");
    }
    void expect_refused(int code) {
        EXPECT_EQ(get("detail-code"), code);
        EXPECT_EQ(get("fault"), 1);
        EXPECT_EQ(get("value-valid"), 0);
        EXPECT_EQ(get("move-allowed"), 0);
        EXPECT_EQ(get("y-move"), 0);
        EXPECT_EQ(get("x-correction"), 0);
    }
    void expect_held(int code) {
        EXPECT_EQ(get("detail-code"), code);
        EXPECT_EQ(get("value-valid"), 1);
        EXPECT_EQ(get("move-allowed"), 0);
    }

    Bench bench;
    double y_origin = 0;
};

enum { two_cuts, two_lands, y_step, any_cuts };

TEST_F(CentreHeight, ComputesTheExampleOfItsSource) {
    set("gauge-kind", 0);
    key(two_cuts, {{10}, {2 * std::sqrt(10.0)}}, 3);
    EXPECT_NEAR(get("height-size"), 3, 1e-12);
    EXPECT_NEAR(get("tip-x"), 4, 1e-12);
    EXPECT_NEAR(get("theta"), std::asin(0.6) / degree, 1e-9);
    EXPECT_NEAR(get("smallest-diameter"), 6, 1e-12);
    EXPECT_EQ(get("sign-known"), 0);
    expect_held(32);  // nothing moves before the sign is known
    EXPECT_EQ(get("y-move"), 0);
    set("sign", -1);
    pulse("compute");
    EXPECT_NEAR(get("height"), -3, 1e-12);
    expect_held(35);  // beyond max-move
    set("max-move", 5);
    pulse("compute");
    EXPECT_EQ(get("status-code"), 53) << "two cuts alone are not checked";
    EXPECT_EQ(get("move-allowed"), 0);
    key(two_cuts, {{10, 4}, {2 * std::sqrt(10.0), 1}, {2 * std::hypot(0.5, 3), 0.5}});
    EXPECT_EQ(get("move-allowed"), 1);
    EXPECT_NEAR(get("y-move"), 3, 1e-12);
    set("gauge-kind", 1);  // radii
    key(two_cuts, {{5}, {std::sqrt(10.0)}}, 3);
    EXPECT_NEAR(get("height"), -3, 1e-12);
}

TEST_F(CentreHeight, SensitivitiesOfTwoCutsAreDifferences) {
    const auto height = [&](double d1, double d2, double travel) {
        key(two_cuts, {{d1}, {d2}}, travel);
        return get("height-size");
    };
    const double h = 1e-5, d2 = 2 * std::sqrt(10.0);
    const double by_1 = (height(10 + h, d2, 3) - height(10 - h, d2, 3)) / (2 * h);
    const double by_2 = (height(10, d2 + h, 3) - height(10, d2 - h, 3)) / (2 * h);
    const double by_travel = (height(10, d2, 3 + h) - height(10, d2, 3 - h)) / (2 * h);
    height(10, d2, 3);
    EXPECT_NEAR(get("height-by-diameter-1"), by_1, 1e-6);
    EXPECT_NEAR(get("height-by-diameter-2"), by_2, 1e-6);
    EXPECT_NEAR(get("height-by-travel"), by_travel, 1e-6);
}

TEST_F(CentreHeight, LandsGiveTheMoveOfYAndTheCorrectionOfX) {
    const Lathe lathe;
    for (const double y0 : {0.0, -3.5}) {
        SCOPED_TRACE(y0);
        Lathe here = lathe;
        here.tip_y -= y0;
        place(10, y0);
        begin(4, two_lands, y0);
        EXPECT_EQ(get("status-code"), 41);
        for (const char* land : {"land-1-y", "land-2-y", "land-2-y", "land-1-y"})
            cut(here, 5, y0 + get(land));
        check(here);
        EXPECT_EQ(get("value-valid"), 1);
        EXPECT_NEAR(get("height"), 0.035, 1e-9);
        EXPECT_EQ(get("move-allowed"), 1);
        EXPECT_NEAR(get("y-move"), -0.035, 1e-9);
        EXPECT_NEAR(get("x-correction"), -lathe.tip_x, 1e-9);
        EXPECT_NEAR(get("tip-x"), 5.02, 1e-9);
    }
}

// The programmed radius is the one that is cut, at every diameter.
TEST_F(CentreHeight, AfterTheMoveEachProgrammedRadiusIsTurned) {
    for (const double angle : {90.0, 80.0, 100.0}) {
        SCOPED_TRACE(angle);
        set("axes-angle-0", angle);
        set("x-zero-0", 2);  // the program's X0
        Lathe lathe;
        lathe.angle = angle * degree;
        lathe.tip_x = -2.1;
        place(7, 0);
        begin(4, two_lands);
        for (const double y : {1.0, -1.0, -1.0, 1.0}) cut(lathe, 7, y);
        check(lathe);
        ASSERT_EQ(get("move-allowed"), 1);
        const double y = get("y-move"), x_zero = 2 + get("x-correction");
        for (const double programmed : {0.1, 2.0, 5.0})
            EXPECT_NEAR(lathe.radius(x_zero + programmed, y), programmed, 1e-9);
    }
}

TEST_F(CentreHeight, EveryMethodAndPostFindsTheHeight) {
    for (const char* pin : {"gauge-sigma", "gauge-scale-sigma", "cut-repeatability", "travel-sigma",
                            "step-sigma", "drift-sigma", "bend-per-depth"})
        set(pin, 1e-6);
    for (const int post : {0, 3}) {
        const std::string number = std::to_string(post);
        set("post", post);
        set("x-reversed-" + number, post == 3);
        set("axes-angle-" + number, post == 3 ? 95 : 90);
        Lathe lathe;
        lathe.tip_y = -0.3;
        lathe.outward = post == 3 ? -1 : 1;
        lathe.angle = (post == 3 ? 95 : 90) * degree;
        const auto x = [&](double outward) { return lathe.outward * outward; };
        const std::vector<std::array<double, 2>> cuts{{5, 0}, {4, 0}, {3.5, 0.4}, {3, -0.4}, {2.5, 0.2}};
        for (const int method : {two_cuts, y_step, any_cuts}) {
            SCOPED_TRACE(method * 10 + post);
            set("sign", method == two_cuts ? -1 : 0);
            const int count = method == two_cuts ? 2 : method == y_step ? 3 : 5;
            place(x(9), 0, number);
            begin(count, method);
            for (int i = 0; i < count; ++i) cut(lathe, x(cuts[i][0]), cuts[i][1], number);
            EXPECT_EQ(get("detail-code"), 0);
            EXPECT_NEAR(get("height"), -0.3, 1e-8);
            EXPECT_NEAR(get("x-correction"), (-0.02 - get("y-move") * std::cos(lathe.angle)) * lathe.outward,
                        1e-7);
        }
    }
}

// Typed 10.1721 for 10.2721.
TEST_F(CentreHeight, AWrongDiameterIsCorrectedAtAnyStepAndTheHeightIsThatOfTheRightOne) {
    const Lathe lathe;
    set("land-diameter", 10);
    const auto again = [&](int cut, double diameter) {
        set("entered-cut", cut);
        set("entered-diameter", diameter);
        set("entered", 1);
        step();
        const bool taken = get("value-taken") == 1;
        set("entered", 0);
        step();
        set("entered-cut", 0);
        return taken;
    };
    const auto wrong_at = [&](double y) {
        place(5, y);
        pulse("cut-done");
        enter(2 * lathe.radius(5, y) - 0.1);
    };
    begin(2, two_lands);
    wrong_at(1);
    EXPECT_EQ(get("cut-number"), 1);
    EXPECT_FALSE(again(2, 10)) << "no such cut";
    place(5, -1);
    pulse("cut-done");
    EXPECT_TRUE(again(1, 2 * lathe.radius(5, 1))) << "while the next one waits";
    EXPECT_EQ(get("measure"), 1);
    EXPECT_EQ(get("cut-number"), 1);
    enter(2 * lathe.radius(5, -1) - 0.1);
    EXPECT_GT(std::abs(get("height") - 0.035), 0.05);
    EXPECT_TRUE(again(2, 2 * lathe.radius(5, -1)));
    EXPECT_EQ(get("value-valid"), 1);
    EXPECT_NEAR(get("height"), 0.035, 1e-9);
    EXPECT_TRUE(again(2, lathe.radius(5, -1))) << "a radius";
    EXPECT_EQ(get("fault"), 1);
    EXPECT_TRUE(again(2, 2 * lathe.radius(5, -1)));
    EXPECT_NEAR(get("height"), 0.035, 1e-9) << "a slip has changed nothing";
    pulse("abort");
    EXPECT_FALSE(again(1, 10));
    for (const double number : {0.5, -1.0, -3.0, -1.5, -1e308, 1e308, std::nan("")}) {
        SCOPED_TRACE(number);
        pulse("resume");
        set("entered-cut", number);
        set("entered-diameter", 12);
        pulse("entered");
        set("entered-cut", 0);
        EXPECT_NEAR(get("height"), 0.035, 1e-9);
    }
}

TEST_F(CentreHeight, TheDiameterOfTheLastCutIsTakenBackAndTheCutWaitsForItAgain) {
    const Lathe lathe;
    set("land-diameter", 10);
    const auto take_back = [&](int number) {
        set("entered-cut", -number);
        set("entered", 1);
        step();
        const bool taken = get("value-taken") == 1;
        set("entered", 0);
        step();
        set("entered-cut", 0);
        return taken;
    };
    begin(2, two_lands);
    EXPECT_FALSE(take_back(1)) << "there is none";
    place(5, 1);
    pulse("cut-done");
    EXPECT_FALSE(take_back(1)) << "it has no diameter yet";
    enter(2 * lathe.radius(5, 1) - 0.1);
    place(7, -3);  // the tool has gone on: the cut keeps the place of its end
    EXPECT_TRUE(take_back(1));
    EXPECT_EQ(get("cut-number"), 0);
    EXPECT_EQ(get("measure"), 1);
    EXPECT_EQ(get("status-code"), 42);
    enter(2 * lathe.radius(5, 1));
    place(5, -1);
    pulse("cut-done");
    EXPECT_FALSE(take_back(1)) << "a later cut waits";
    enter(2 * lathe.radius(5, -1) - 0.2);
    EXPECT_FALSE(take_back(1)) << "it is not the last one";
    EXPECT_TRUE(take_back(2)) << "the height was known";
    EXPECT_EQ(get("value-valid"), 0);
    enter(2 * lathe.radius(5, -1));
    EXPECT_NEAR(get("height"), 0.035, 1e-9);
    pulse("abort");
    EXPECT_FALSE(take_back(2));
}

TEST_F(CentreHeight, ProgramChoosesMethodAndCutsAndEntersDiameters) {
    const Lathe lathe;
    set("program-method", 2);  // two lands
    set("program-cuts", 2);
    begin(12, two_cuts);
    for (const double y : {1.0, -1.0}) {
        place(5, y);
        pulse("cut-done");
        set("entered-diameter", 2 * lathe.radius(5, y));
        set("entered", 1);
        step();
        EXPECT_EQ(get("value-taken"), 1);
        set("entered", 0);
        step();
        EXPECT_EQ(get("value-taken"), 0);
    }
    EXPECT_NEAR(get("height"), 0.035, 1e-9);
    set("program-method", 7);
    pulse("compute");
    expect_refused(8);
    set("program-method", 2);
    set("program-post", 3);
    set("post", 0);
    set("inverted-2", 1);
    set("clearance-angle", 7);
    set("land-diameter", 10);
    step();
    EXPECT_EQ(get("land-2-y"), 0) << "the tool of post 2 rubs below";
    set("program-post", 5);
    pulse("compute");
    expect_refused(8);
}

TEST_F(CentreHeight, InternalTurningGoesOutward) {
    set("inside", 1);
    set("sign", 1);
    const Lathe lathe{0, 0.4};
    begin(2, two_cuts);
    cut(lathe, 5, 0);
    cut(lathe, 8, 0);
    EXPECT_NEAR(get("height"), 0.4, 1e-9);
    begin(2, two_cuts);
    cut(lathe, 8, 0);
    cut(lathe, 5, 0);
    EXPECT_EQ(get("fault"), 1);
}

TEST_F(CentreHeight, LaserBeamsGiveDiameters) {
    const Lathe lathe;
    const double pi = std::acos(-1.0);
    for (const int kind : {2, 3}) {
        set("gauge-kind", kind);
        set("beam-size", kind == 2 ? 2 : 8);
        set("emitted-area", kind == 2 ? 60 : 64 * pi);
        begin(2, two_lands);
        for (const double y : {1.0, -1.0}) {
            place(5, y);
            pulse("cut-done");
            const double a = lathe.radius(5, y);
            const double covered =
                kind == 2 ? 4 * a : 2 * (a * std::sqrt(64 - a * a) + 64 * std::asin(a / 8));
            set("received-area", get("emitted-area") - covered);
            pulse("value-ready");
        }
        EXPECT_NEAR(get("height"), 0.035, 1e-8) << kind;
        begin(2, two_lands);
        pulse("cut-done");
        set("received-area", 1000);
        pulse("value-ready");
        EXPECT_EQ(get("detail-code"), 6) << "more is received than emitted";
        EXPECT_EQ(get("measure"), 1) << "measure again";
    }
}

TEST_F(CentreHeight, SlipIsNamedAndEnteredAgain) {
    set("x-is-radius", 1);
    const Lathe lathe;
    begin(2, two_lands);
    place(5, 1);
    pulse("cut-done");
    const double diameter = 2 * lathe.radius(5, 1);
    for (const auto& [entry, code] : std::vector<std::pair<double, int>>{{diameter / 2, 2},
                                                                         {diameter * 2, 3},
                                                                         {diameter / 25.4, 4},
                                                                         {diameter * 25.4, 5},
                                                                         {0, 1},
                                                                         {-10, 1}}) {
        enter(entry);
        expect_refused(code);
        EXPECT_EQ(get("measure"), 1);
        EXPECT_EQ(get("cut-number"), 0);
    }
    enter(diameter);
    EXPECT_EQ(get("fault"), 0);
    EXPECT_EQ(get("cut-number"), 1);
    cut(lathe, 5, -1);
    EXPECT_NEAR(get("height"), 0.035, 1e-9);
}

TEST_F(CentreHeight, CutIsAcknowledgedThoughTheGaugeHasAnswered) {
    begin(2, two_lands);
    place(5, 1);
    set("cut-done", 1);
    step();
    enter(10.2);
    EXPECT_EQ(get("measure"), 0);
    EXPECT_EQ(get("cut-taken"), 1);
    set("cut-done", 0);
    step();
    EXPECT_EQ(get("cut-taken"), 0);
    pulse("abort");
    set("cut-done", 1);
    step();
    EXPECT_EQ(get("cut-taken"), 0) << "no cut was due";
}

TEST_F(CentreHeight, AnnouncedDiameterOfLandsShowsSlips) {
    const Lathe lathe;
    for (const char* sigma : {"gauge-sigma", "cut-repeatability", "drift-sigma", "step-sigma"}) set(sigma, 0);
    for (const auto& [factor, code] :
         std::vector<std::pair<double, int>>{{0.5, 2}, {2, 3}, {1 / 25.4, 4}, {1, 0}}) {
        SCOPED_TRACE(factor);
        const auto lands = [&](double announced) {
            set("land-diameter", announced);
            key(two_lands,
                {{2 * factor * lathe.radius(5, 1), 5, 1}, {2 * factor * lathe.radius(5, -1), 5, -1}});
        };
        lands(10);
        EXPECT_EQ(get("detail-code"), code);
        lands(0);
        EXPECT_EQ(get("detail-code"), 0) << "nothing to compare with";
        EXPECT_NEAR(get("height"), 0.035 * factor * factor, 1e-9);
    }
}

TEST_F(CentreHeight, SwappedLandsShowInTheOrder1221) {
    const Lathe lathe;
    const auto land = [&](double y, double measured_y) {
        return Keyed{2 * lathe.radius(5, measured_y), 5, y};
    };
    key(two_lands, {land(1, -1), land(-1, 1)});
    EXPECT_EQ(get("detail-code"), 0);
    EXPECT_NEAR(get("height"), -0.035, 1e-9) << "one pair shows nothing";
    key(two_lands, {land(1, -1), land(-1, 1), {2 * lathe.radius(4.5, 2), 4.5, 2}});
    expect_held(45);
    EXPECT_EQ(get("suspect-cut"), 3) << "a check shows it";
    key(two_lands, {land(1, -1), land(-1, 1), land(-1, -1), land(1, 1)});
    EXPECT_EQ(get("move-allowed"), 0);
    EXPECT_NE(get("detail-code"), 0);
}

TEST_F(CentreHeight, WithoutYXTurnsTheProgrammedDiameterAndAShimRaisesTheTool) {
    Lathe lathe;
    lathe.tip_y = -0.4;
    set("without-y", 1);
    set("x-is-radius", 1);
    set("stock-diameter", 10.6);
    begin(2, two_cuts);
    cut(lathe, 5, 0);
    cut(lathe, 0.6, 0);
    check(lathe);
    expect_held(39);
    EXPECT_NEAR(get("height-size"), 0.4, 1e-9);
    EXPECT_EQ(get("status-code"), 51);
    ASSERT_EQ(get("x-allowed"), 1) << "X needs no sign";
    const double correction = get("x-correction");

    set("largest-burr", 0.04);
    begin(2, two_cuts);
    cut(lathe, 5, 0);
    cut(lathe, 0.6, 0);
    expect_held(41);
    EXPECT_EQ(get("x-allowed"), 0) << "a burr could have made it";
    EXPECT_EQ(get("status-code"), 45);
    EXPECT_EQ(get("detail-code"), 41);
    EXPECT_EQ(get("cuts-needed"), 3);
    cut(lathe, 0.5, 0);
    EXPECT_EQ(get("status-code"), 51) << "the third cut shows that there is no burr";
    EXPECT_EQ(get("cuts-needed"), 0);
    ASSERT_EQ(get("x-allowed"), 1);
    EXPECT_NEAR(get("x-correction"), correction, 1e-12);
    set("gauge-sigma", 0.1);
    pulse("compute");
    EXPECT_EQ(get("x-allowed"), 0);
    EXPECT_EQ(get("status-code"), 45);
    EXPECT_EQ(get("detail-code"), 44) << "more cuts do not help";
    EXPECT_EQ(get("cuts-needed"), 0);
    set("gauge-sigma", 0.0003);
    set("largest-burr", 0);
    lathe.tip_x += correction;
    EXPECT_NEAR(lathe.radius(5, 0), 5, 1e-9);

    set("tolerance", 0.004);  // a pair knows X to no less with 99 %
    const double shim = 1;    // below the tool for the second land: its position of Y
    begin(2, two_lands);
    cut(lathe, 5, 0);
    cut(lathe, 5, shim);
    check(lathe);
    expect_held(38);
    EXPECT_NEAR(get("y-move"), 0.4, 1e-9);
    EXPECT_EQ(get("x-allowed"), 0) << "X turns the diameter";
    EXPECT_EQ(get("status-code"), 46);
    EXPECT_EQ(get("on-centre"), 0);

    lathe.tip_y += get("y-move");
    begin(4, two_lands);
    for (const double y : {0.0, shim, shim, 0.0}) cut(lathe, 5, y);
    check(lathe);
    EXPECT_NEAR(get("height"), 0, 1e-9);
    EXPECT_EQ(get("status-code"), 51)
        << "at the new height X is wrong by as much as it had to be wrong before";
    lathe.tip_x += get("x-correction");
    EXPECT_NEAR(lathe.radius(5, 0), 5, 1e-9);
}

TEST_F(CentreHeight, ImpossibleCutsAreRefusedAndNothingMoves) {
    set("sign", 1);
    set("max-move", 100);
    const auto refused = [&](int code, const std::vector<Keyed>& cuts, double travel = 0,
                             int method = two_cuts) {
        SCOPED_TRACE(code);
        key(method, cuts, travel);
        expect_refused(code);
        key(two_cuts, {{10}, {8}}, 1.001);
        EXPECT_EQ(get("value-valid"), 1);
    };
    refused(1, {{0}, {8}}, 1);
    refused(1, {{std::nan("")}, {8}}, 1);
    refused(9, {{10}});
    refused(10, {{10, 5}, {8, 5}});
    refused(10, {{10}, {8}}, -1);
    refused(11, {{10, 5}, {8, 4}}, 2);  // in diameter
    refused(12, {{8}, {10}}, 1);        // swapped
    refused(12, {{10}, {10}}, 1);
    refused(13, {{10}, {8}}, 0.95);
    refused(14, {{10}, {8}}, 9.5);
    refused(15, {{10}, {8}}, 3.5);
    refused(18, {{10, 5}, {8, 4}, {6, 3}}, 0, any_cuts);
    refused(19, {{10, 5, 0}, {8, 4, 0.1}, {6, 3, 0.2}}, 0, any_cuts);
    refused(16, {{10, 5, 0}, {8, 4, 0}, {8, 3.5, 0.2}}, 0, y_step);
    refused(7, {{10, 5, HUGE_VAL}, {8, 4, 0}}, 0, two_lands);
    refused(9, {{10, 5, 0}, {8, 4, 0}}, 0, y_step);
    set("stock-diameter", 9);
    key(two_lands, {{8, 4, 0.1}, {9, 4, -0.1}});
    expect_refused(16);
    set("stock-diameter", 0);
    set("clearance-angle", 7);
    refused(17, {{8, 4, 0.6}, {8.1, 4, -0.6}}, 0, two_lands);
    set("inverted-0", 1);
    refused(17, {{8, 4, 0.4}, {8.1, 4, -0.6}}, 0, two_lands);
    set("inverted-0", 0);
    set("inverted-1", 1);
    set("post", 1);
    refused(17, {{8, 4, 0.4}, {8.1, 4, -0.6}}, 0, two_lands);
    set("post", 0);
    set("clearance-angle", 0);
    for (const auto& [pin, value] : std::vector<std::pair<std::string, double>>{{"method", 5},
                                                                                {"post", -1},
                                                                                {"sign", 2},
                                                                                {"axes-angle-0", 0},
                                                                                {"gauge-sigma", -1},
                                                                                {"gauge-scale-sigma", -1},
                                                                                {"max-move", std::nan("")},
                                                                                {"correction-factor", 0}}) {
        const double good = get(pin);
        set(pin, value);
        pulse("compute");
        EXPECT_EQ(get("detail-code"), 8) << pin;
        EXPECT_EQ(get("move-allowed"), 0) << pin;
        set(pin, good);
    }
}

TEST_F(CentreHeight, HeightIsValidButHeldForAReason) {
    const Lathe lathe;
    const auto lands = [&](double factor = 1) {
        begin(2, two_lands);
        cut(lathe, 5, 1);
        place(5, -1);
        pulse("cut-done");
        enter(2 * lathe.radius(5, -1) * factor);
    };
    lands();
    EXPECT_EQ(get("detail-code"), 0);
    set("enable", 0);
    lands();
    check(lathe);
    expect_held(31);
    EXPECT_NEAR(get("y-move"), -0.035, 1e-9) << "to be moved by hand";
    set("enable", 1);
    set("max-sigma", 0.001);
    lands();
    expect_held(34);
    set("max-sigma", 0.1);
    set("max-move", 0.03);
    lands();
    expect_held(35);
    set("max-move", 0.5);
    set("cut-repeatability", 0.02);
    lands();
    expect_held(43);
    EXPECT_GT(3 * get("sigma"), 0.035);
}

// Of lands and of any cuts, too: the pair reversed, or another cut.
TEST_F(CentreHeight, RedundantLandsMustAgree) {
    const Lathe lathe;
    for (const int method : {two_lands, any_cuts}) {
        for (const double error : {0.0, 0.002, 0.01}) {
            SCOPED_TRACE(std::to_string(method) + " " + std::to_string(error));
            const bool agrees = error < 0.005;  // two sigmas of a prediction
            begin(method == two_lands ? 4 : 5, method);
            cut(lathe, 5, 1);
            cut(lathe, 5, -1);
            cut(lathe, method == two_lands ? 5 : 3, -1);
            if (method == any_cuts) cut(lathe, 4, 1);
            place(5, 1);
            pulse("cut-done");
            enter(2 * (lathe.radius(5, 1) + error));
            EXPECT_NEAR(get("predicted-diameter"), 2 * lathe.radius(5, 1), 1e-9) << "by the others";
            EXPECT_EQ(get("move-allowed"), 0);
            EXPECT_EQ(get("detail-code"), agrees ? 0 : 45);
            EXPECT_EQ(get("suspect-cut"), agrees ? 0 : method == two_lands ? 4 : 5);
            EXPECT_EQ(get("disagreement") > 3, !agrees);
            if (!agrees) continue;
            check(lathe);
            EXPECT_EQ(get("move-allowed"), 1);
        }
    }
}

TEST_F(CentreHeight, RedundantCutMustAgree) {
    const Lathe lathe;
    set("pass-depth", 0.05);  // however deep a cut, so that it bends the work by the same
    set("sign", 1);
    set("max-sigma", 1);
    for (const int method : {two_cuts, y_step}) {
        for (const double error : {0.0, 0.02}) {
            SCOPED_TRACE(method * 10 + error);
            begin(method == two_cuts ? 2 : 3, method);
            Lathe high = lathe;
            high.tip_y = 0.45;
            cut(high, 5, 0);
            cut(high, 1, 0);
            if (method == y_step) cut(high, 0.8, -0.3);
            EXPECT_EQ(get("status-code"), 53);
            const double x = method == two_cuts ? 0.7 : 0.6;
            place(x, 0);
            pulse("cut-done");
            EXPECT_EQ(get("move-allowed"), 0) << "not before the check is measured";
            enter(2 * (high.radius(x, 0) - error));
            EXPECT_NEAR(get("predicted-diameter"), 2 * high.radius(x, 0), error == 0 ? 1e-9 : 0.1);
            EXPECT_EQ(get("move-allowed"), error == 0);
            EXPECT_EQ(get("detail-code"), error == 0 ? 0 : 45);
        }
    }
}

// On eight lands the burr is the one that does not fit; on four it is not known which of a pair it is on.
TEST_F(CentreHeight, BurrIsLeftOutOrReported) {
    const Lathe lathe;
    set("stock-diameter", 12);
    const auto lands = [&](int count, int burred, double burr) {
        begin(count, two_lands);
        for (int i = 0; i < count; ++i) {
            const double y = i % 4 == 0 || i % 4 == 3 ? 1 : -1;
            place(5, y);
            pulse("cut-done");
            enter(2 * lathe.radius(5, y) + (i == burred ? burr : 0));
        }
    };
    for (int burred = 0; burred < 8; ++burred) {
        SCOPED_TRACE(burred);
        lands(8, burred, 0.02);
        EXPECT_EQ(get("rejected-cuts"), 1);
        EXPECT_EQ(get("rejected-cut"), burred + 1);
        EXPECT_EQ(get("detail-code"), burred < 7 ? 0 : 45) << "the edge may have chipped";
        EXPECT_NEAR(get("height"), 0.035, 1e-6);
        if (burred == 7) cut(lathe, 5, 1);
        EXPECT_EQ(get("rejected-cut"), burred + 1);
        check(lathe);
        EXPECT_EQ(get("move-allowed"), 1);
    }
    lands(8, 3, -0.02);
    EXPECT_EQ(get("rejected-cuts"), 0) << "a burr makes no diameter smaller";
    expect_held(36);
    lands(4, 1, 0.02);
    EXPECT_EQ(get("rejected-cuts"), 0);
    expect_held(36);
    const double disagree = get("status-code");
    EXPECT_NE(disagree, 0);
    EXPECT_NEAR(get("height"), 0.035, 2 * get("sigma")) << "sigma knows that the cuts disagree";
    EXPECT_EQ(get("cuts-needed"), 8);
    for (const double y : {1.0, -1.0, -1.0, 1.0}) cut(lathe, 5, y);
    EXPECT_EQ(get("rejected-cut"), 2) << "four more lands decide";
    EXPECT_NE(get("status-code"), disagree);
    check(lathe);
    EXPECT_EQ(get("move-allowed"), 1);
}

// Nothing shows a burr on one pair.
TEST_F(CentreHeight, HeightThatAnUnseenBurrCouldHaveMadeMovesNothing) {
    set("largest-burr", 0.04);
    set("stock-diameter", 12);
    set("x-is-radius", 1);
    set("max-sigma", 1);
    const auto lands = [&](const Lathe& lathe, int count, double burr) {
        begin(count, two_lands);
        for (int i = 0; i < count; ++i) {
            const double y = i % 4 == 0 || i % 4 == 3 ? 1 : -1;
            place(5, y);
            pulse("cut-done");
            enter(2 * lathe.radius(5, y) + (i == 0 ? burr : 0));
        }
    };
    lands({0, 0}, 2, 0.04);
    EXPECT_GT(get("height"), 0.04);
    expect_held(41);
    EXPECT_EQ(get("status-code"), 45) << "cut again";
    EXPECT_EQ(get("x-allowed"), 0);
    EXPECT_EQ(get("cuts-needed"), 8);
    lands({0, 0}, 4, 0.04);
    expect_held(45);
    cut({0, 0}, 5, 1);
    expect_held(45);  // the first land has a burr, or the edge has slipped since
    lands({0, 0.2}, 2, 0);
    check({0, 0.2});
    EXPECT_EQ(get("move-allowed"), 1) << "no burr makes as much";
    lands({0, 0.035}, 4, 0);
    check({0, 0.035});
    EXPECT_EQ(get("move-allowed"), 1) << "the lands agree";
    set("sign", 1);
    set("pass-depth", 0.05);
    begin(2, two_cuts);
    cut({0, 0.35}, 5, 0);
    cut({0, 0.35}, 2.5, 0);
    EXPECT_EQ(get("move-allowed"), 0);
    set("largest-burr", 0);
    pulse("compute");
    check({0, 0.35});
    EXPECT_EQ(get("move-allowed"), 1);
}

// The tip touches the first land again, at another Y; or a third cut there.
TEST_F(CentreHeight, SignOfTwoCutsByTouchOrByWord) {
    set("cut-repeatability", 0.0003);
    set("stock-diameter", 1);
    for (const double height : {0.03, -0.03}) {
        SCOPED_TRACE(height);
        const Lathe lathe{0, height};
        const auto two = [&](int count) {
            begin(count, two_cuts);
            cut(lathe, 0.45, 0);
            cut(lathe, 0.01, 0);
        };
        two(3);
        const double y = 0.2, radius = lathe.radius(0.45, 0);
        place(std::sqrt(radius * radius - (y + height) * (y + height)), y);
        pulse("cut-done");
        enter(2 * radius);
        EXPECT_EQ(get("sign-known"), 1);
        EXPECT_NEAR(get("height"), height, 1e-9);
        EXPECT_EQ(get("detail-code"), 0);
        EXPECT_NEAR(get("y-move"), -height, 1e-9);
        two(3);
        place(std::sqrt(radius * radius - (y + height) * (y + height)) + (height > 0 ? 0.0146 : -0.0146), y);
        pulse("cut-done");
        enter(2 * radius);
        EXPECT_EQ(get("move-allowed"), 0) << "a touch that fits neither side";
        set("program-sign", height > 0 ? 1 : -1);
        two(2);
        check(lathe);
        EXPECT_NEAR(get("height"), height, 1e-9);
        EXPECT_EQ(get("move-allowed"), 1);
        for (const double word : {2.0, 0.5, std::nan("")}) {
            set("program-sign", word);
            pulse("compute");
            expect_refused(8);
        }
        set("program-sign", 0);
        two(2);
        expect_held(32);
    }
}

// Y of the third cut cannot show a sign that is not there: two lands show more, not one more cut.
TEST_F(CentreHeight, ThirdCutOfAToolThatMayBeOnCentreAsksForLands) {
    set("stock-diameter", 1);
    const Lathe lathe{0, 0.0001};
    begin(3, two_cuts);
    cut(lathe, 0.4, 0);
    cut(lathe, 0.01, 0);
    cut(lathe, 0.3, 0.2);
    EXPECT_EQ(get("sign-known"), 0);
    EXPECT_EQ(get("move-allowed"), 0);
    EXPECT_EQ(get("detail-code"), 42);
    EXPECT_EQ(get("on-centre"), 0) << get("within");
}

// Where the load of the spindle is wired.
TEST_F(CentreHeight, CutThatTheSpindleDoesNotFeelIsRefused) {
    set("least-load", 5);
    const Lathe lathe;
    const auto cut_with = [&](double load) {
        set("spindle-load", load);
        step();
        set("spindle-load", 2);
        step();
        place(5, 1);
        pulse("cut-done");
    };
    begin(2, two_lands);
    cut_with(8);
    EXPECT_EQ(get("measure"), 1);
    enter(2 * lathe.radius(5, 1));
    cut_with(3);
    expect_refused(21);
    EXPECT_EQ(get("measure"), 0);
    cut_with(std::nan(""));
    begin(2, two_lands);
    cut_with(std::nan(""));
    expect_refused(21);
    set("at-rest", 1);
    begin(2, two_lands);
    cut_with(2);
    EXPECT_EQ(get("fault"), 0) << "a spring pass";
}

// Under the cut the work bends away from the tool; in spring passes it does not.
TEST_F(CentreHeight, HeightAtRestIsToldFromTheOneUnderTheCut) {
    Lathe cutting, at_rest;
    at_rest.tip_y = cutting.tip_y + 0.008;
    const auto measure_from = [&](const Lathe& lathe, double y) {
        place(7, y);
        begin(2, two_lands, y);
        cut(lathe, 5, y + 1);
        cut(lathe, 5, y - 1);
    };
    set("program-tool", 1);
    measure_from(cutting, 0);
    EXPECT_EQ(get("bend-known"), 0);
    EXPECT_EQ(get("status-code"), 53);
    set("at-rest", 1);
    measure_from(at_rest, 0.1);  // from another Y
    EXPECT_EQ(get("bend-known"), 1);
    EXPECT_NEAR(get("bend"), 0.008, 1e-9);
    EXPECT_NEAR(get("bend-sigma"), std::sqrt(2.0) * get("sigma"), 1e-5);
    expect_held(37);  // the part is turned under the cut
    set("at-rest", 0);
    set("program-tool", 2);
    measure_from(cutting, 0);
    EXPECT_EQ(get("bend-known"), 0);
    EXPECT_EQ(get("bend"), 0);
}

// A tip on centre leaves a larger radius than its X where Y is stepped: no slip.
TEST_F(CentreHeight, StepOfYIsNoSlip) {
    set("x-is-radius", 1);
    const Lathe lathe{0, 0.01};
    begin(3, y_step);
    cut(lathe, 0.5, 0);
    cut(lathe, 0.35, 0);
    cut(lathe, 0.2, 0.25);
    EXPECT_EQ(get("fault"), 0);
    EXPECT_NEAR(get("height"), 0.01, 1e-9);
}

// At every step, and by every method: nothing may move, and the height is the same as without the abort.
TEST_F(CentreHeight, AbortAtAnyStepIsResumedOrBegunAgain) {
    Lathe lathe;
    lathe.tip_y = 0.45;
    set("sign", 1);
    set("max-sigma", 1);
    const std::vector<std::vector<std::array<double, 2>>> plans{{{5, 0}, {3, 0}},
                                                                {{5, 1}, {5, -1}},
                                                                {{5, 0}, {4, 0}, {3.5, 0.4}},
                                                                {{5, 0}, {4, 0}, {4, 0.4}, {5, 0.4}}};
    for (int method = two_cuts; method <= any_cuts; ++method) {
        const auto& plan = plans[static_cast<std::size_t>(method)];
        const int count = static_cast<int>(plan.size()), last = 4 * count + 1;
        for (int abort_at = 0; abort_at < last; ++abort_at) {
            for (const bool resume : {true, false}) {
                SCOPED_TRACE(std::to_string(method) + " aborted at " + std::to_string(abort_at));
                int now = 0;
                bool begun_again = false;
                const auto interrupted = [&] {
                    if (now++ != abort_at || begun_again) return false;
                    const double before = get("status-code");
                    pulse("abort");
                    EXPECT_EQ(get("status-code"), 48);
                    for (const char* pin : {"measure", "value-valid", "move-allowed", "y-move", "fault"})
                        EXPECT_EQ(get(pin), 0) << pin;
                    for (const char* pin : {"cut-done", "value-ready", "entered", "compute"}) pulse(pin);
                    EXPECT_EQ(get("status-code"), 48) << "nothing goes on by itself";
                    if (resume) {
                        pulse("resume");
                        EXPECT_EQ(get("status-code"), before == 52 ? 42 : before) << "a slip is told once";
                    }
                    return begun_again = !resume;
                };
                const auto work_through = [&] {
                    now = 0;
                    begin(count, method);
                    if (interrupted()) return false;
                    for (const auto& [x, y] : plan) {
                        place(x, y);
                        if (interrupted()) return false;
                        pulse("cut-done");
                        if (interrupted()) return false;
                        if (abort_at % 2 != 0) {  // after a slip
                            enter(0);
                            EXPECT_EQ(get("fault"), 1);
                        }
                        if (interrupted()) return false;
                        enter(2 * lathe.radius(x, y));
                        if (interrupted()) return false;
                    }
                    return true;
                };
                if (!work_through()) work_through();
                EXPECT_EQ(get("cut-number"), count);
                EXPECT_NEAR(get("height"), 0.45, 1e-8);
                if (method != any_cuts) check(lathe);  // the first three of four predict the last one
                EXPECT_EQ(get("move-allowed"), 1);
            }
        }
    }
}

TEST_F(CentreHeight, RefusedCutsStayRefusedAfterAnAbort) {
    set("stock-diameter", 9);
    begin(2, two_lands);
    place(5, 1);
    pulse("cut-done");
    enter(10);
    expect_refused(16);
    pulse("abort");  // by which LinuxCNC tells of it
    expect_refused(16);
    EXPECT_EQ(get("status-code"), 47);
    pulse("resume");
    expect_refused(16);
}

// A height that a program has stored must not be stored again.
TEST_F(CentreHeight, StoredHeightIsForgotten) {
    const Lathe lathe;
    begin(2, two_lands);
    cut(lathe, 5, 1);
    cut(lathe, 5, -1);
    check(lathe);
    EXPECT_EQ(get("move-allowed"), 1);
    pulse("stored");
    EXPECT_EQ(get("status-code"), 40);
    EXPECT_EQ(get("move-allowed"), 0);
    EXPECT_EQ(get("y-move"), 0);
    pulse("abort");
    pulse("resume");
    EXPECT_EQ(get("value-valid"), 0);
    pulse("compute");
    EXPECT_EQ(get("move-allowed"), 0);
}

TEST_F(CentreHeight, TargetHeightAndHabitsOfTheMachineCount) {
    set("stock-diameter", 12);
    set("tolerance", 0.02);
    set("target-height", 0.01);
    set("correction-offset", 0.002);
    set("correction-factor", 1.5);
    const Lathe lathe;
    begin(2, two_lands);
    cut(lathe, 5, 1);
    cut(lathe, 5, -1);
    check(lathe);
    EXPECT_NEAR(get("height"), 0.002 + 1.5 * 0.035, 1e-9);
    EXPECT_NEAR(get("y-move"), 0.01 - get("height"), 1e-12);
    EXPECT_EQ(get("on-centre"), 0);
    set("target-height", 0.0545);
    pulse("compute");
    EXPECT_EQ(get("on-centre"), 1);
    EXPECT_EQ(get("detail-code"), 0);
    EXPECT_EQ(get("move-allowed"), 0);
    set("target-height", 0);
    set("correction-offset", 0);
    set("correction-factor", 1);
    set("diameter-offset", 0.01);
    set("diameter-factor", 2);
    begin(2, two_lands);
    for (const double y : {1.0, -1.0}) {
        place(5, y);
        pulse("cut-done");
        enter((2 * lathe.radius(5, y) - 0.01) / 2);
    }
    EXPECT_NEAR(get("height"), 0.035, 1e-9);
}

TEST_F(CentreHeight, ShowsWhichDiameterCanBeTurnedAndWhere) {
    Lathe lathe;
    set("target-diameter", 0.06);
    begin(2, two_lands);
    cut(lathe, 5, 1);
    cut(lathe, 5, -1);
    EXPECT_NEAR(get("smallest-diameter"), 0.07, 1e-9);
    EXPECT_EQ(get("target-reachable"), 0);
    set("target-diameter", 0.5);
    step();
    EXPECT_EQ(get("target-reachable"), 1);
    EXPECT_NEAR(lathe.radius(get("target-x"), 0), 0.25, 1e-9);
}

TEST_F(CentreHeight, ZeroSigmasAreAllowed) {
    for (const char* pin : {"gauge-sigma", "gauge-scale-sigma", "cut-repeatability", "travel-sigma",
                            "step-sigma", "drift-sigma", "bend-per-depth"})
        set(pin, 0);
    const Lathe lathe;
    key(two_lands, {{2 * lathe.radius(5, 1), 5, 1}, {2 * lathe.radius(5, -1), 5, -1}});
    EXPECT_NEAR(get("height"), 0.035, 1e-9);
    EXPECT_LT(get("sigma"), 1e-9);
    set("sign", 1);
    std::vector<Keyed> cuts;
    for (const double x : {0.5, 0.1, 0.3}) cuts.push_back({2 * lathe.radius(x, 0), x, 0});
    key(two_cuts, cuts);
    EXPECT_NEAR(get("height"), 0.035, 1e-9);
    EXPECT_EQ(get("move-allowed"), 1);
}

enum Verdicts { on_centre = 43, both, unsure, held, unchecked = 49, only_y, only_x };

// Four lands of a tool that is close to the centre.
class CloseToCentre : public CentreHeight {
protected:
    CloseToCentre() {
        set("x-is-radius", 1);
        set("stock-diameter", 10.6);
        set("tolerance", 0.005);
        set("cut-repeatability", 0.0005);
    }
    void cut_lands(const Lathe& lathe, int lands = 4) {
        place(10, 0);
        begin(lands, two_lands);
        for (int i = 0; i < lands; ++i) cut(lathe, 5, i % 4 == 0 || i % 4 == 3 ? 1 : -1);
        if (get("check-due") == 1) check(lathe);
    }
    void expect_verdict(int code) {
        EXPECT_EQ(get("status-code"), code);
        EXPECT_EQ(get("on-centre"), code == on_centre);
        EXPECT_EQ(get("move-allowed"), code == both || code == only_y);
        EXPECT_EQ(get("x-allowed"), code == both || code == only_x);
    }
};

TEST_F(CloseToCentre, OnCentreIsKnownByNinetyNineInAHundred) {
    cut_lands({0, 0.001});
    ASSERT_LE(0.001 + 2.33 * get("sigma"), 0.005);
    expect_verdict(on_centre);
    EXPECT_EQ(get("cuts-needed"), 0);
    set("tolerance", 0.001 + 2.3 * get("sigma"));
    pulse("compute");
    expect_verdict(unsure);
    expect_held(41);
    set("tolerance", 0.005);
    set("max-sigma", 0.05);
    set("cut-repeatability", 0.002);
    pulse("compute");
    expect_verdict(unsure);
}

// As many cuts as it asks for do answer.
TEST_F(CloseToCentre, CutsThatItAsksForMakeTheHeightKnown) {
    set("cut-repeatability", 0.0012);
    cut_lands({0, 0.0005});
    expect_verdict(unsure);
    EXPECT_EQ(get("detail-code"), 41);
    const int needed = static_cast<int>(get("cuts-needed"));
    EXPECT_GT(needed, 4);
    EXPECT_LE(needed, 16);
    for (int i = 4; i < needed; ++i) cut({0, 0.0005}, 5, i % 4 == 0 || i % 4 == 3 ? 1 : -1);
    EXPECT_EQ(get("cut-number"), needed);
    check({0, 0.0005});
    expect_verdict(on_centre);
    set("cut-repeatability", 0.02);
    set("max-sigma", 1);
    pulse("compute");
    EXPECT_EQ(get("detail-code"), 43) << "no number of cuts";
    EXPECT_EQ(get("cuts-needed"), 0);
}

TEST_F(CloseToCentre, TwoCutsThatDoNotKnowAskForLands) {
    set("sign", 1);
    set("max-sigma", 1);
    begin(2, two_cuts);
    cut({0, 0.1}, 5, 0);
    cut({0, 0.1}, 2.5, 0);
    expect_verdict(unsure);
    EXPECT_EQ(get("detail-code"), 42);
    EXPECT_GE(get("cuts-needed"), 4);
}

TEST_F(CloseToCentre, YAndXAreTwoAnswers) {
    cut_lands({0.05, 0});
    expect_verdict(only_x);
    EXPECT_NEAR(get("x-correction"), -0.05, 1e-6);
    EXPECT_GT(get("x-sigma"), 0);
    EXPECT_LT(get("x-sigma"), 0.002);
    cut_lands({0, 0.05});
    expect_verdict(only_y);
    cut_lands({0.05, 0.05});
    expect_verdict(both);
    EXPECT_NEAR(get("x-correction"), -0.05, 1e-6);
    set("enable", 0);
    pulse("compute");
    expect_verdict(held);
    set("enable", 1);
    set("x-is-radius", 0);
    cut_lands({0.05, 0});
    expect_verdict(on_centre);
    EXPECT_EQ(get("x-allowed"), 0) << "the programmed radius is not known";
}

// With the noise of the gauge, and a bar that is not exactly its nominal diameter.
TEST_F(CloseToCentre, ToolThatTouchesNothingIsNotOnCentre) {
    for (const double off : {0.0, 0.001, -0.001, -0.015}) {
        SCOPED_TRACE(off);
        begin(4, two_lands);
        place(5, 1);
        pulse("cut-done");
        enter(10.6 + off);
        expect_refused(16);
        EXPECT_EQ(get("on-centre"), 0);
    }
    for (const char* pin : {"stock-diameter", "program-stock"}) {
        set("stock-diameter", 0);
        set("program-stock", 0);
        cut_lands({0, 0});
        expect_verdict(unchecked);
        EXPECT_EQ(get("checked-for-air"), 0);
        set(pin, 10.6);
        cut_lands({0, 0});
        expect_verdict(on_centre);
        EXPECT_EQ(get("checked-for-air"), 1);
    }
    for (const double stock : {-1.0, 1e9, std::nan("")}) {
        set("program-stock", stock);
        pulse("compute");
        expect_refused(8);
    }
}

TEST_F(CloseToCentre, DiameterMustFollowFromXOfTheTool) {
    for (const double error : {0.49, 0.52, -0.49, -0.52}) {
        SCOPED_TRACE(error);
        set("stock-diameter", 13);
        set("max-move", 0.001);
        begin(2, two_lands);
        place(5, 0);
        pulse("cut-done");
        enter(2 * (5 + error));
        EXPECT_EQ(get("detail-code"), std::abs(error) < 0.5 ? 0 : 20);
    }
}

// The work bends by 5 um per mm of depth, away from the tool.
TEST_F(CloseToCentre, UnequalDepthsCountInSigma) {
    set("max-sigma", 1);
    const auto height_of = [&](const std::array<double, 3>& depths) {
        double radius = 5.3;
        begin(3, y_step);
        for (std::size_t i = 0; i < 3; ++i) {
            const double y = i == 2 ? 1 : 0;
            radius -= depths[i];
            place(std::sqrt(radius * radius - (y + 0.1) * (y + 0.1)), y);
            pulse("cut-done");
            enter(2 * (radius + 0.005 * depths[i]));
        }
        return get("height");
    };
    const double equal = height_of({0.8, 0.8, 0.8}), sigma = get("sigma");
    EXPECT_NEAR(equal, 0.1, 2 * sigma);
    const double unequal = height_of({0.3, 2, 0.5});
    EXPECT_GT(std::abs(unequal - 0.1), 3 * std::abs(equal - 0.1)) << "what unequal depths do";
    EXPECT_GT(get("sigma"), 1.5 * sigma);
    EXPECT_NEAR(unequal, 0.1, 2 * get("sigma"));
    set("pass-depth", 0.1);
    height_of({0.3, 2, 0.5});
    EXPECT_LT(get("sigma"), 1.2 * sigma) << "all passes are as deep";
}

// The gauge stands at the first land, or its operator always measures that one.
TEST_F(CloseToCentre, TheSameReadingForEachLandIsNotOnCentre) {
    for (const double height : {0.0, 0.05, 0.1}) {
        SCOPED_TRACE(height);
        const Lathe lathe{0, height};
        const double stuck = 2 * lathe.radius(5, 1);
        place(10, 0);
        begin(4, two_lands);
        for (int i = 0; i < 7; ++i) {
            place(get("next-x"), get("next-y"));
            pulse("cut-done");
            enter(stuck);
            EXPECT_EQ(get("on-centre"), 0);
            EXPECT_EQ(get("move-allowed"), 0);
            EXPECT_EQ(get("x-allowed"), 0);
            if (i == 3) {
                EXPECT_EQ(get("status-code"), 53);
            }
            if (i == 4 || i == 5) {
                expect_held(45);
                EXPECT_EQ(get("cuts-needed"), i + 2);
            }
        }
        expect_refused(22);
    }
}

// The edge of the tool chips by 20 um, so that all later diameters are larger, or slips inward.
TEST_F(CloseToCentre, NothingIsStoredOfAnEdgeThatChipsOrSlipsAtAnyCut) {
    for (const double diameter : {10.0, 1.0}) {
        const double x = diameter / 2, step = diameter / 10 * (diameter < 5 ? 2 : 1);
        set("land-step", step);
        set("land-diameter", diameter);
        set("stock-diameter", diameter < 5 ? 1.4 : 10.6);
        for (const double chip : {0.02, -0.02}) {
            for (int first = 1; first <= 12; ++first) {  // the cut at which it happens
                SCOPED_TRACE(std::to_string(diameter) + ", " + std::to_string(chip) + ", cut " +
                             std::to_string(first + 1));
                const int lands = first < 6 ? 4 : 8;
                const Lathe before{0, 0.1};
                Lathe after{chip, 0.1 - chip / 2};
                place(x + 5, 0);
                begin(lands, two_lands);
                int cuts = 0;
                for (; cuts < 18 && get("fault") == 0; ++cuts) {
                    const Lathe& now = cuts < first ? before : after;
                    const double next = get("next-x");
                    if (cuts >= lands && get("cut-due") == 0) {
                        if (get("cuts-needed") <= cuts) break;
                        cut(now, x, cuts % 4 == 0 || cuts % 4 == 3 ? step : -step);
                    } else {
                        cut(now, next, get("next-y"));
                    }
                    EXPECT_EQ(get("on-centre"), 0);
                    if (get("move-allowed") == 0) continue;
                    // What it stores is the tool of now.
                    EXPECT_NEAR(get("height"), now.tip_y, 0.012);
                    break;
                }
                if (first == lands - 1 || first == lands) {
                    EXPECT_EQ(get("detail-code"), 22) << "the last land, and the check";
                }
            }
        }
    }
}

TEST_F(CloseToCentre, ALandMoreShowsThatTheLastOneOnlyHadABurr) {
    const Lathe lathe{0, 0.05};
    place(10, 0);
    begin(4, two_lands);
    for (const double y : {1.0, -1.0, -1.0}) cut(lathe, 5, y);
    place(5, 1);
    pulse("cut-done");
    enter(2 * lathe.radius(5, 1) + 0.03);
    expect_held(45);
    EXPECT_EQ(get("suspect-cut"), 4);
    EXPECT_EQ(get("cut-due"), 1);
    EXPECT_EQ(get("check-due"), 0);
    EXPECT_NEAR(get("next-x"), 5, 1e-9);
    EXPECT_NEAR(get("next-y"), 1, 1e-9);
    cut(lathe, 5, 1);
    EXPECT_EQ(get("rejected-cut"), 4);
    check(lathe);
    EXPECT_EQ(get("move-allowed"), 1);
    EXPECT_NEAR(get("height"), 0.05, 0.001);
}

// 0.5 mm too much on a micrometer.
TEST_F(CloseToCentre, AReadingThatContradictsTheStockIsReadAgain) {
    const Lathe lathe{0, 0.05};
    const auto type = [&](double diameter) {
        set("entered-diameter", diameter);
        pulse("entered");
    };
    begin(4, two_lands);
    for (int i = 0; i < 4; ++i) {
        const double y = get("next-y");
        place(5, y);
        pulse("cut-done");
        type(2 * lathe.radius(5, y) + 0.5);
        EXPECT_EQ(get("detail-code"), 16);
        EXPECT_EQ(get("suspect-cut"), i + 1);
        EXPECT_EQ(get("measure"), 1);
        EXPECT_EQ(get("status-code"), 52);
        if (i == 2) {  // it did remove nothing: the land is cut again
            place(5, y);
            pulse("cut-done");
            EXPECT_EQ(get("fault"), 0);
        }
        type(2 * lathe.radius(5, y));
        EXPECT_EQ(get("fault"), 0);
        EXPECT_EQ(get("cut-number"), i + 1);
    }
    check(lathe);
    EXPECT_EQ(get("move-allowed"), 1);
}

TEST_F(CloseToCentre, ALandAfterTheStoreShowsWhatWasStored) {
    set("max-move", 0.6);
    for (const bool second_slide : {false, true}) {
        for (const double off : {0.0, 0.025, -0.025}) {
            SCOPED_TRACE(off);
            Lathe lathe{0.03, 0.08};
            lathe.outward = second_slide ? -1 : 1;
            set("x-reversed-0", second_slide);
            const double side = lathe.outward, x_zero = 2 * side;
            lathe.tip_x -= 2;
            set("x-zero-0", x_zero);
            place(12 * side, 7);
            lathe.tip_y -= 7;
            begin(4, two_lands, 7);
            for (const double y : {1.0, -1.0, -1.0, 1.0}) cut(lathe, x_zero + 5 * side, 7 + y);
            check(lathe);
            ASSERT_EQ(get("move-allowed"), 1);
            ASSERT_EQ(get("x-allowed"), 1);
            const double y_zero = 7 + get("y-move"), new_zero = x_zero + get("x-correction");
            pulse("stored");
            lathe.tip_y += off;  // another edge than the one that was measured
            set("x-zero-0", new_zero);
            set("program-method", 6);
            set("program-cuts", 1);
            place(12 * side, y_zero - 0.3);
            set("entered-diameter", -0.3);  // what the program calls this Y
            pulse("start");
            EXPECT_EQ(get("cut-due"), 1);
            EXPECT_EQ(get("shown"), 0);
            EXPECT_NEAR(get("next-diameter"), 2 * std::hypot(get("next-x"), get("next-y")), 1e-9);
            cut(lathe, new_zero + get("next-x"), y_zero + get("next-y"));
            EXPECT_EQ(get("shown"), off == 0);
            if (off == 0) {
                EXPECT_EQ(get("status-code"), 54);
            } else {
                EXPECT_EQ(get("detail-code"), 23);
                EXPECT_EQ(get("fault"), 1);
            }
            pulse("start");
            EXPECT_EQ(get("detail-code"), 24) << "shown once";
            set("program-method", 0);
            set("program-cuts", 0);
        }
    }
}

// Somebody has changed the table while LinuxCNC was off.
TEST_F(CloseToCentre, NothingIsStoredWhileTheToolTableAsks) {
    set("table-asks", 1);
    step();
    EXPECT_EQ(get("status-code"), 55);
    place(10, 0);
    begin(4, two_lands);
    for (int i = 0; i < 5; ++i) cut({0.05, 0.05}, i < 4 ? 5 : get("next-x"), get("next-y"));
    EXPECT_EQ(get("move-allowed"), 0);
    EXPECT_EQ(get("x-allowed"), 0);
    EXPECT_EQ(get("status-code"), 55);
    set("table-asks", 0);
    pulse("compute");
    EXPECT_EQ(get("move-allowed"), 1);
    set("table-asks", 1);
    step();
    EXPECT_EQ(get("move-allowed"), 0);
}

// Variation 2 of the source.
TEST_F(CentreHeight, AHeightFromElsewhereIsEnteredAndStored) {
    set("program-method", 5);
    set("entered-diameter", 0);
    for (const double height : {0.03, -0.2}) {
        pulse("start");
        EXPECT_EQ(get("measure"), 1);
        set("entered-diameter", height);
        pulse("entered");
        EXPECT_EQ(get("height"), height);
        EXPECT_EQ(get("y-move"), -height);
        EXPECT_EQ(get("move-allowed"), 1);
        EXPECT_EQ(get("x-allowed"), 0);
        EXPECT_EQ(get("on-centre"), 0);
        EXPECT_EQ(get("status-code"), 50);
    }
    set("entered-diameter", 0.6);
    pulse("start");
    pulse("entered");
    expect_held(35);
    set("axes-angle-0", 80);
    set("entered-diameter", 0.1);
    pulse("start");
    pulse("entered");
    EXPECT_EQ(get("x-allowed"), 1) << "Y moves the tip in X, too";
    EXPECT_NEAR(get("x-correction"), 0.1 / std::tan(80 * degree), 1e-12);
    set("entered-diameter", std::nan(""));
    pulse("start");
    pulse("entered");
    expect_refused(20);
}

// Two readings at a right angle: an oval bar, 30 um.
TEST_F(CloseToCentre, ABarThatIsNotRoundMovesNothingNearTheCentre) {
    const auto lands = [&](double height, double oval, bool twice) {
        place(10, 0);
        begin(4, two_lands);
        for (int i = 0; i < 4; ++i) {
            const double y = get("next-y"), turned = y > 0 ? 0.2 : 2.9;
            place(5, y);
            pulse("cut-done");
            const double diameter = 2 * Lathe{0, height}.radius(5, y);
            set("second-diameter", twice ? diameter - oval * std::cos(turned) : 0);
            set("entered-diameter", diameter + oval * std::cos(turned));
            pulse("entered");
        }
        set("second-diameter", 0);
    };
    set("tolerance", 0.01);
    set("max-sigma", 0.05);
    lands(0.02, 0.03, false);
    EXPECT_GT(std::abs(get("height") - 0.02), 0.02) << "one reading a land";
    lands(0.02, 0.03, true);
    EXPECT_NEAR(get("height"), 0.02, 1e-6);
    EXPECT_EQ(get("move-allowed"), 0);
    EXPECT_EQ(get("status-code"), 45);
    EXPECT_EQ(get("detail-code"), 46);
    lands(0.3, 0.03, true);
    EXPECT_EQ(get("status-code"), 53) << "a height that no lobe makes";
    lands(0.02, 0.0005, true);
    EXPECT_EQ(get("status-code"), 53) << "a round bar";
    EXPECT_EQ(get("reads-twice"), 0);
    place(get("next-x"), get("next-y"));
    pulse("cut-done");
    EXPECT_EQ(get("reads-twice"), 1);
    const double diameter = 2 * Lathe{0, 0.02}.radius(get("x-position-0"), get("y-position-0"));
    set("entered-diameter", diameter);
    pulse("entered");
    EXPECT_EQ(get("detail-code"), 25);
    EXPECT_EQ(get("status-code"), 52) << "a check by hand is read at two angles";
    set("second-diameter", diameter + 0.0005);
    pulse("entered");
    EXPECT_EQ(get("cut-number"), 5);
    EXPECT_EQ(get("fault"), 0);
    // What an entry has left does not count for the gauge.
    place(10, 0);
    begin(2, two_lands);
    set("second-diameter", 8);
    cut({0, 0.02}, 5, get("next-y"));
    EXPECT_EQ(get("fault"), 0);
    EXPECT_NEAR(get("next-diameter"), 2 * std::hypot(5, 1), 1e-6);
}

// X grows by 1.5 um from land to land, on a bar of 1 mm.
TEST_F(CloseToCentre, GrowthOfXBetweenTheLandsIsInItsSigma) {
    set("land-step", 0.2);
    set("land-diameter", 1);
    set("stock-diameter", 1.5);
    const auto measured = [&](double growth) {
        place(5, 0);
        begin(4, two_lands);
        for (int i = 0; i < 4; ++i) cut({-growth * i, 0}, 0.5, i % 4 == 0 || i % 4 == 3 ? 0.2 : -0.2);
    };
    measured(0);
    const double sigma = get("x-sigma");
    measured(0.0015);
    EXPECT_GT(get("x-sigma"), 1.3 * sigma);
    EXPECT_NEAR(get("x-correction"), 3 * 0.0015, 2 * get("x-sigma")) << "as after the last land";
}

TEST_F(CentreHeight, HasThePinsOfItsPostsAndKeyedCuts) {
    bench.command("unloadrt centre_height");
    bench.command("loadrt centre_height names=one,two posts=1,2 keyed_cuts=0,3");
    for (const std::string stem :
         {"x-position-", "y-position-", "x-zero-", "x-reversed-", "inverted-", "axes-angle-"}) {
        bench.get("one." + stem + "0");
        EXPECT_ANY_THROW(bench.get("one." + stem + "1")) << stem;
        bench.get("two." + stem + "1");
        EXPECT_ANY_THROW(bench.get("two." + stem + "2")) << stem;
    }
    for (const std::string pin : {"keyed", "cut-diameter-2", "cut-x-2", "cut-y-2"}) {
        EXPECT_ANY_THROW(bench.get("one." + pin)) << pin;
        bench.get("two." + pin);
    }
    EXPECT_ANY_THROW(bench.get("two.cut-x-3"));
}

// A program may name a post that the machine does not have.
TEST_F(CentreHeight, APostThatIsNotThereIsRefused) {
    bench.command("unloadrt centre_height");
    bench.command("loadrt centre_height names=centre interlock=no posts=2 keyed_cuts=2");
    bench.command("addf centre.update servo-thread");
    for (const int post : {1, 2}) {
        set("post", post);
        set("largest-burr", 0);
        const Lathe lathe;
        key(1, {{2 * lathe.radius(5, 1), 5, 1}, {2 * lathe.radius(5, -1), 5, -1}});
        step();
        EXPECT_EQ(get("value-valid"), post == 1) << "post " << post;
        set("compute", 0);
        step();
    }
}

// Whatever an input holds, no output is nonsense, and Y moves no further than max-move.
TEST_F(CentreHeight, NoInputMakesNonsense) {
    const Lathe lathe;
    const Module module(build_folder() + "/modules/centre_height.so");
    const hal::Declarations declared(
        module.model(), {{"interlock", "no"}, {"posts", "4"}, {"keyed_cuts", "12"}});  // as in the fixture
    for (const hal::PinInfo& pin : declared.pins)
        if (pin.output && pin.type == hal::Type::real)
            bench.expect("finite(x)", {{"x", "centre." + pin.name}});
    bench.expect("allowed == 0 || abs(move) <= 0.5",
                 {{"allowed", "centre.move-allowed"}, {"move", "centre.y-move"}});
    int number = 0;
    for (const hal::PinInfo& pin : declared.pins) {
        if (pin.output || pin.type == hal::Type::bit || pin.name == "max-move") continue;
        if (number++ % rounds(1, 6) != 0) continue;
        SCOPED_TRACE(pin.name);
        const double own = get(pin.name);
        const std::vector<double> poisons = pin.type == hal::Type::real
                                                ? std::vector<double>(impossible.begin(), impossible.end())
                                                : std::vector<double>{-2147483648.0, -1, 2147483647.0};
        for (const double poison : poisons) {
            set("keyed", 0);
            place(5, 1);
            pulse("start");
            for (const double y : {1.0, -1.0}) {
                place(5, y);
                set(pin.name, poison);
                pulse("cut-done");
                set("diameter", 2 * lathe.radius(5, y));
                set(pin.name, poison);
                pulse("value-ready");
            }
            set("keyed", 1);
            pulse("compute");
            set(pin.name, own);
        }
    }
    place(0, 0);
    set("keyed", 0);
    begin(2, two_lands);
    cut(lathe, 5, 1);
    cut(lathe, 5, -1);
    EXPECT_NEAR(get("height"), 0.035, 1e-9);
}

}  // namespace
}  // namespace plumb
