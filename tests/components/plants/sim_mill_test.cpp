// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/support/bench.hpp"
#include "tests/support/rounds.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace plumb {
namespace {

// A mill without growth, wear or play, and one that is left as it comes.
struct SimMill : testing::Test {
    Bench bench;

    SimMill() {
        bench.command("loadrt sim_mill names=mill,other");
        bench.command("addf mill.update servo-thread");
        still("mill");
    }

    void still(const std::string& mill) {
        for (const char* pin : {"encoder-step", "backlash", "seating", "wear-length", "spindle-growth",
                                "column-share", "screw-rise", "air-growth"})
            bench.set(mill + "." + pin, 0);
    }

    double growth() { return bench.get("mill.truth-growth"); }

    // Z from 1 mm above `bottom` down to it in 0.1 s, and there half a second.
    void feed_down(double bottom) {
        for (int i = 0; i <= 100; ++i) {
            bench.set("mill.z-position-cmd", bottom + 1 - 0.01 * i);
            bench.run(0.001);
        }
        bench.run(0.5);
    }

    // The same, and up again.
    void plunge(double bottom) {
        feed_down(bottom);
        bench.set("mill.z-position-cmd", bottom + 50);
        bench.run(1);
    }
};

TEST_F(SimMill, AxisSettlesWithTheTimeConstantOfItsGain) {
    bench.run(0.01);
    bench.set("mill.z-offset", 1);
    bench.run(1 / 30.);
    EXPECT_NEAR(bench.get("mill.z-position"), 1 - std::exp(-1), 0.01);
    EXPECT_EQ(bench.get("mill.applied-offset"), 1);
    bench.run(1);
    EXPECT_NEAR(bench.get("mill.z-position"), 1, 1e-9);
}

TEST_F(SimMill, TurningSpindleGrowsAsAFirstOrderLag) {
    bench.set("mill.spindle-growth", 0.06);
    bench.set("mill.spindle-speed-cmd", 8000);
    bench.run(600);
    EXPECT_NEAR(growth(), 60 * um * (1 - std::exp(-1)), 0.01 * um);
}

TEST_F(SimMill, StoppedSpindleShrinksWithATimeConstantOfItsOwn) {
    bench.set("mill.spindle-growth", 0.06);
    bench.set("mill.tau-turning", 0);
    bench.set("mill.spindle-speed-cmd", 8000);
    bench.run(1);
    EXPECT_NEAR(growth(), 60 * um, 0.01 * um);
    bench.set("mill.spindle-speed-cmd", 0);
    constexpr double time = rounds(3600, 360);
    bench.run(time);
    EXPECT_NEAR(growth(), 60 * um * std::exp(-time / 3600), 0.01 * um);
}

TEST_F(SimMill, GrowthRisesWithAPowerOfTheSpeed) {
    bench.set("mill.spindle-growth", 0.06);
    bench.set("mill.tau-turning", 0);
    for (const double speed : {2000., 4000., 8000., -4000.}) {
        bench.set("mill.spindle-speed-cmd", speed);
        bench.run(0.01);
        EXPECT_NEAR(growth(), 60 * um * std::pow(std::abs(speed) / 8000, 1.7), 1e-9) << speed;
    }
}

TEST_F(SimMill, HeadAndColumnUndoTheirShareSlowly) {
    bench.set("mill.spindle-growth", 0.06);
    bench.set("mill.column-share", 0.5);
    bench.set("mill.tau-turning", 0);
    bench.set("mill.spindle-speed-cmd", 8000);
    constexpr double time = rounds(7200, 720);
    bench.run(time);
    EXPECT_NEAR(growth(), 60 * um * (1 - 0.5 * (1 - std::exp(-time / 7200))), 0.01 * um);
}

TEST_F(SimMill, ScrewWarmsWithMotionAndMovesZByItsDistanceFromTheFixedBearing) {
    bench.set("mill.screw-rise", 2);
    bench.set("mill.screw-tau", 10);
    bench.set("mill.screw-fixed", 400);
    bench.set("mill.servo-gain", 60);
    // 10 mm/s there and back for 10 s: 2 K (1 - 1/e)
    bench.command("loadrt siggen");
    bench.command("addf siggen.0.update servo-thread");
    bench.command("net z siggen.0.triangle => mill.z-position-cmd");
    bench.set("siggen.0.frequency", 1);
    bench.set("siggen.0.amplitude", 2.5);
    bench.run(10);
    const double z = bench.get("mill.z-position");
    EXPECT_NEAR(growth(), 11.5e-6 * (400 - z) * 2 * (1 - std::exp(-1)), 0.3 * um);
}

TEST_F(SimMill, ShopAirSwingsEveryTwentyMinutesAndOverTheDay) {
    bench.set("mill.air-growth", 0.002);
    bench.set("mill.air-swing", 0.5);
    bench.set("mill.air-day", 0);
    bench.run(300);
    EXPECT_NEAR(bench.get("mill.shop-temperature"), 20.5, 1e-6);
    EXPECT_NEAR(growth(), 1 * um, 1e-6);
    bench.run(600);
    EXPECT_NEAR(growth(), -1 * um, 1e-6);
    bench.set("mill.air-day", 4);
    bench.set("mill.air-swing", 0);
    bench.set("mill.air-start", 21600 - 900);
    bench.run(0.001);
    EXPECT_NEAR(bench.get("mill.shop-temperature"), 24, 1e-3);
}

TEST_F(SimMill, ReplayedGrowthStandsForItsOwn) {
    bench.set("mill.use-replay", 1);
    bench.set("mill.growth-replay", 0.0123);
    bench.set("mill.spindle-speed-cmd", 8000);
    bench.run(60);
    EXPECT_EQ(growth(), 0.0123);
    bench.set("mill.growth-replay", std::nan(""));
    bench.run(1);
    EXPECT_EQ(growth(), 0.0123);
}

TEST_F(SimMill, TipErrorIsTheOffsetLessTheGrowthAndALongerTool) {
    bench.set("mill.use-replay", 1);
    bench.set("mill.growth-replay", 0.03);
    bench.set("mill.z-offset", 0.02);
    bench.set("mill.tool-deviation", 0.001);
    bench.run(2);
    EXPECT_NEAR(bench.get("mill.truth-tip-error"), -11 * um, 1e-6);
    bench.set("mill.z-position-cmd", -10);
    bench.run(0.02);  // on the way: following error is none of it
    EXPECT_NEAR(bench.get("mill.truth-tip-error"), -11 * um, 1e-6);
}

TEST_F(SimMill, EncoderReadsInSteps) {
    bench.set("mill.encoder-step", 0.001);
    bench.set("mill.z-position-cmd", 0.51234);
    for (int i = 0; i < 100; ++i) {
        bench.run(0.001);
        const double steps = bench.get("mill.z-position") / 0.001;
        EXPECT_NEAR(steps, std::round(steps), 1e-9);
    }
}

TEST_F(SimMill, BacklashIsLostOnReversal) {
    bench.set("mill.backlash", 0.003);
    const auto error_after = [&](double z) {
        bench.set("mill.z-position-cmd", z);
        bench.run(1);
        return bench.get("mill.truth-tip-error");
    };
    bench.run(0.1);
    const double down = error_after(-1), up = error_after(1);
    EXPECT_NEAR(down - up, 3 * um, 1e-6);
    EXPECT_NEAR(error_after(1.0005), up, 1e-6) << "onwards nothing is lost";
}

TEST_F(SimMill, EachToolChangeSeatsTheToolAgain) {
    bench.set("mill.seating", 0.001);
    double sum = 0, squares = 0;
    constexpr int n = 2000;
    for (int tool = 1; tool <= n; ++tool) {
        bench.set("mill.tool-number", tool % 7);
        bench.run(0.002);
        const double seat = bench.get("mill.truth-tip-error");
        sum += seat;
        squares += seat * seat;
    }
    EXPECT_NEAR(sum / n, 0, 0.07 * um);
    EXPECT_NEAR(std::sqrt(squares / n), 1 * um, 0.06 * um);
}

TEST_F(SimMill, ContactIsWhereTheTipMeetsTheWork) {
    bench.set("mill.use-replay", 1);
    bench.set("mill.growth-replay", 0.04);
    bench.set("mill.work-top", -5);
    bench.set("mill.stock-deviation", 0.002);
    bench.set("mill.operation", 10);
    bench.set("mill.event", 3);
    bench.set("mill.z-position-cmd", -4.5);
    bench.run(1);
    plunge(-5.5);
    EXPECT_EQ(bench.get("mill.truth-contacts"), 1);
    EXPECT_NEAR(bench.get("mill.truth-contact-coordinate"), -5 + 0.002 + 0.04, 0.01 * um);
    EXPECT_EQ(bench.get("mill.truth-contact-growth"), 0.04);
    EXPECT_EQ(bench.get("mill.truth-contact-operation"), 10);
    EXPECT_EQ(bench.get("mill.truth-contact-event"), 3);
    // The command meets -4.958 mm when 0.0459 s of the plunge have passed; at full speed the axis is 1/Kv
    // later.
    EXPECT_GT(bench.get("mill.truth-contact-time"), 1 + 0.0458);
    EXPECT_LT(bench.get("mill.truth-contact-time"), 1 + 0.0458 + 1 / 30. + 0.002);
    plunge(-5.5);
    EXPECT_EQ(bench.get("mill.truth-contacts"), 2);
}

TEST_F(SimMill, CutErrorIsThatOfTheDeepestTip) {
    bench.set("mill.use-replay", 1);
    bench.set("mill.growth-replay", 0.04);
    bench.set("mill.z-offset", 0.025);
    bench.set("mill.operation", 20);
    bench.set("mill.occurrence", 2);
    bench.set("mill.tool-number", 4);
    bench.set("mill.z-position-cmd", 10);
    bench.set("mill.stock-deviation", 0.3);  // moves the contact, not the depth
    bench.run(1);
    feed_down(-0.5);
    EXPECT_EQ(bench.get("mill.truth-cuts"), 0) << "not before the tool leaves";
    bench.set("mill.growth-replay", 0.01);  // after the bottom it does not count
    bench.set("mill.z-position-cmd", 10);
    bench.run(1);
    EXPECT_EQ(bench.get("mill.truth-cuts"), 1);
    EXPECT_NEAR(bench.get("mill.truth-cut-error"), -15 * um, 1e-3 * um);
    EXPECT_EQ(bench.get("mill.truth-cut-growth"), 0.04);
    EXPECT_EQ(bench.get("mill.truth-cut-operation"), 20);
    EXPECT_EQ(bench.get("mill.truth-cut-occurrence"), 2);
    EXPECT_EQ(bench.get("mill.truth-cut-tool"), 4);
}

TEST_F(SimMill, WithoutWorkThereIsNeitherContactNorCut) {
    bench.set("mill.work-present", 0);
    bench.set("mill.operation", 10);
    bench.set("mill.z-position-cmd", 10);
    bench.run(1);
    bench.expect("power == 0", {{"power", "mill.cutting-power"}});
    plunge(-2);
    EXPECT_EQ(bench.get("mill.truth-contacts"), 0);
    EXPECT_EQ(bench.get("mill.truth-cuts"), 0);
}

TEST_F(SimMill, ChipIsCutEarlyButIsNotTheWork) {
    bench.set("mill.chip-height", 0.3);
    bench.set("mill.z-position-cmd", 10);
    bench.set("mill.spindle-speed-cmd", 8000);
    bench.run(1);
    bench.set("mill.z-position-cmd", 0.2);
    double highest = -1;  // where the first power is taken
    for (int i = 0; i < 300 && highest < 0; ++i) {
        bench.run(0.001);
        if (bench.get("mill.cutting-power") > 0) highest = bench.get("mill.z-position");
    }
    EXPECT_NEAR(highest, 0.3, 0.02);
    bench.run(1);
    EXPECT_EQ(bench.get("mill.truth-contacts"), 0);
}

TEST_F(SimMill, PlungeTakesThePowerOfItsChipVolume) {
    bench.set("mill.tool-diameter", 12);
    bench.set("mill.spindle-speed-cmd", 6000);
    bench.set("mill.z-position-cmd", 1);
    bench.run(1);
    double z = 1;
    for (int i = 0; i < 2000; ++i) {
        bench.set("mill.z-position-cmd", z -= 0.002);
        bench.run(0.001);
    }
    EXPECT_EQ(bench.get("mill.engagement"), 1);
    EXPECT_NEAR(bench.get("mill.cutting-power"), 2.5 * M_PI / 4 * 12 * 12 * 2, 0.1);  // 2500 N/mm2, 2 mm/s
}

// Depth below the top where the engagement first reaches a half.
double half_engaged(Bench& bench, double speed) {
    bench.set("mill.spindle-speed-cmd", speed);
    bench.set("mill.z-position-cmd", 1);
    bench.run(1);
    for (double z = 1; z > -5; z -= 0.002) {
        bench.set("mill.z-position-cmd", z);
        bench.run(0.001);
        if (bench.get("mill.engagement") >= 0.5) return -bench.get("mill.z-position");
    }
    return -1;
}

TEST_F(SimMill, EndMillEngagesOverOneTurnAndADrillOverItsPoint) {
    bench.set("mill.tool-diameter", 8);
    EXPECT_NEAR(half_engaged(bench, 60), 0.5 * 2, 0.005);       // 2 mm/s, a turn a second
    EXPECT_NEAR(half_engaged(bench, 6000), 0.5 * 0.02, 0.003);  // a hundred
    bench.set("mill.tool-kind", 1);
    EXPECT_NEAR(half_engaged(bench, 6000), std::sqrt(0.5) * 0.3 * 8, 0.005);
}

TEST_F(SimMill, FromTheSideDepthAloneIsNoContact) {
    bench.set("mill.from-side", 1);
    bench.set("mill.operation", 30);
    bench.set("mill.tool-diameter", 32);
    bench.set("mill.side-feed", 16);
    bench.set("mill.z-position-cmd", 10);
    bench.run(1);
    bench.set("mill.z-position-cmd", -1);
    bench.run(2);
    EXPECT_EQ(bench.get("mill.cutting-power"), 0);
    bench.set("mill.side-entry", 16);
    bench.run(0.1);
    EXPECT_NEAR(bench.get("mill.cutting-power"), 2.5 * 1 * 16 * 16, 0.1);  // 1 mm deep, 16 mm wide, 16 mm/s
    bench.set("mill.z-position-cmd", 10);
    bench.run(1);
    EXPECT_EQ(bench.get("mill.truth-contacts"), 0);
    EXPECT_EQ(bench.get("mill.truth-cuts"), 1);
}

TEST_F(SimMill, WearShortensTheToolAndAWornOutOneIsReplaced) {
    bench.set("mill.wear-length", 0.01);
    bench.set("mill.tool-life", 100);
    bench.set("mill.tool-number", 1);
    bench.set("mill.from-side", 1);
    bench.set("mill.side-entry", 1);
    bench.set("mill.side-feed", 10);
    bench.set("mill.work-top", 5);
    bench.run(50);
    EXPECT_NEAR(bench.get("mill.tool-wear"), 0.5, 1e-3);
    EXPECT_NEAR(bench.get("mill.truth-tip-error"), 5 * um, 0.01 * um);
    bench.set("mill.tool-number", 2);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("mill.tool-wear"), 0, 1e-3) << "another tool";
    bench.set("mill.tool-number", 1);
    bench.run(100);
    EXPECT_EQ(bench.get("mill.tool-wear"), 1);
    bench.set("mill.tool-number", 2);
    bench.run(0.01);
    bench.set("mill.tool-number", 1);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("mill.tool-wear"), 0, 1e-3);
}

TEST_F(SimMill, MachinesAreDrawnEvenlyFromTheirRange) {
    bench.set("mill.spindle-growth", -1);
    bench.set("mill.tau-turning", 0);
    bench.set("mill.spindle-speed-cmd", 8000);
    bench.set("mill.seed", 0);
    bench.run(0.01);
    EXPECT_NEAR(growth(), 60 * um, 1e-9);
    std::vector<double> drawn;
    for (int seed = 1; seed <= 300; ++seed) {
        bench.set("mill.seed", seed);
        bench.run(0.002);
        drawn.push_back(growth());
    }
    const double mean = std::accumulate(drawn.begin(), drawn.end(), 0.0) / 300;
    EXPECT_GE(*std::min_element(drawn.begin(), drawn.end()), 20 * um);
    EXPECT_LE(*std::max_element(drawn.begin(), drawn.end()), 70 * um);
    EXPECT_NEAR(mean, 45 * um, 5 * 50 * um / std::sqrt(12 * 300));
    bench.set("mill.seed", 17);
    bench.run(0.002);
    EXPECT_EQ(growth(), drawn[16]);
}

TEST_F(SimMill, GivenPropertyStandsOverTheDrawnOneAndNonsenseIsNotGiven) {
    bench.set("mill.tau-turning", 0);
    bench.set("mill.spindle-speed-cmd", 8000);
    const auto growth_with = [&](double given) {
        bench.set("mill.spindle-growth", given);
        bench.run(0.01);
        return growth();
    };
    EXPECT_NEAR(growth_with(0.033), 33 * um, 1e-9);
    for (const double nonsense : {-1.0, std::nan(""), 1e308, 5e-324})
        EXPECT_NEAR(growth_with(nonsense), 60 * um, 1e-9);
}

TEST_F(SimMill, InstancesAreIndependent) {
    bench.command("addf other.update servo-thread");
    bench.set("other.seed", 3);
    bench.set("other.spindle-speed-cmd", 8000);
    bench.set("other.z-position-cmd", 20);
    bench.run(60);
    EXPECT_EQ(growth(), 0);
    EXPECT_EQ(bench.get("mill.z-position"), 0);
    EXPECT_GT(bench.get("other.truth-growth"), 1 * um);
}

TEST(TypicalMill, GrowthIsNotMonotonic) {
    Bench bench(Bench::Thread::none);
    bench.command("loadrt threads name1=slow period1=10000000");
    bench.command("loadrt sim_mill names=mill");
    bench.command("addf mill.update slow");
    bench.command("start");
    bench.set("mill.spindle-speed-cmd", 8000);
    const std::vector<double> g =
        bench.trace(4 * 3600, {"mill.truth-growth"}, 60).column("mill.truth-growth");
    const auto peak = std::max_element(g.begin(), g.end());
    EXPECT_NEAR(*peak, 55 * um, 10 * um);
    EXPECT_GT(peak - g.begin(), 20) << "minutes";
    EXPECT_LT(peak - g.begin(), 90) << "minutes";
    EXPECT_LT(g.back(), *peak - 5 * um);
}

TEST(SimMillPeriod, DoesNotMatter) {
    struct Truth {
        double growth, contact;
    };
    const auto truth = [](const std::string& period) {
        Bench bench(Bench::Thread::none);
        bench.command("loadrt threads name1=t period1=" + period);
        bench.command("loadrt sim_mill names=mill");
        bench.command("loadrt siggen");
        bench.command("addf siggen.0.update t");
        bench.command("addf mill.update t");
        bench.command("net z siggen.0.cosine => mill.z-position-cmd");
        bench.set("siggen.0.frequency", 0.1);
        bench.set("siggen.0.amplitude", 2);
        bench.set("mill.spindle-speed-cmd", 8000);
        bench.command("start");
        bench.run(299);
        return Truth{bench.get("mill.truth-growth"), bench.get("mill.truth-contact-coordinate")};
    };
    const Truth fine = truth("500000"), coarse = truth("4000000");
    EXPECT_NEAR(fine.growth, coarse.growth, 0.01 * um);
    EXPECT_NEAR(fine.contact, coarse.contact, 0.05 * um);
}

// Two mills on the same signals: the effect of an impossible value on one must end with the value.
TEST(SimMillPoison, IsForgotten) {
    Bench bench;
    bench.command("loadrt sim_mill names=mill,twin");
    bench.command("addf mill.update servo-thread");
    bench.command("addf twin.update servo-thread");
    for (const std::string mill : {"mill.", "twin."}) {
        bench.set(mill + "spindle-speed-cmd", 6000);
        bench.set(mill + "z-position-cmd", 5);
        bench.set(mill + "z-offset", 0.01);
    }
    bench.run(10);
    for (const char* pin :
         {"z-position", "engagement", "cutting-power", "tool-wear", "truth-growth", "truth-tip-error"})
        bench.expect("finite(x)", {{"x", std::string("mill.") + pin}});
    for (const std::string pin :
         {"z-position-cmd", "z-offset",        "spindle-speed-cmd", "tool-diameter", "tool-deviation",
          "work-top",       "stock-deviation", "chip-height",       "side-entry",    "side-feed",
          "growth-replay",  "growth-speed",    "servo-gain",        "encoder-step",  "backlash",
          "spindle-growth", "growth-exponent", "tau-turning",       "column-tau",    "screw-rise",
          "air-growth",     "tool-life"}) {
        SCOPED_TRACE(pin);
        bench.poison("mill." + pin, 0.01);
        bench.run(2);
        EXPECT_NEAR(bench.get("mill.truth-growth"), bench.get("twin.truth-growth"), 0.02 * um);
        EXPECT_NEAR(bench.get("mill.z-position"), bench.get("twin.z-position"), 1 * um);
    }
}

}  // namespace
}  // namespace plumb
