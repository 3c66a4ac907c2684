// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/contact/growth_authority.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

struct Applied {
    GrowthAuthority::Settings settings{15 * um, 600, 10 * um};
    GrowthAuthority::Evidence now{};
    GrowthAuthority authority{};
    bool single = true;  // the growth has one explanation

    explicit Applied(double growth = 40 * um) {
        now.held = now.predicted = growth;
        now.sigma = 1 * um;
        now.spread = 60 * um;
        now.accepted = true;
        step();
        now.accepted = false;
    }
    double step(double seconds = 1) {
        if (single) now.possible = {{{1, now.predicted, now.sigma}}};
        for (double t = 0; t < seconds; ++t) authority.step(now, settings, 1);
        return authority.offset();
    }
};

TEST(GrowthAuthority, FollowsACertainPrediction) {
    Applied mill;
    EXPECT_NEAR(mill.step(), 40 * um, 1e-12);
    mill.now.predicted = 45 * um;
    mill.now.since_sigma = 3 * um;
    EXPECT_NEAR(mill.step(), 45 * um, 1e-12);
    EXPECT_EQ(mill.authority.doubt(), Doubt::none);
}

TEST(GrowthAuthority, HoldsTheLastContactWhereThePredictionIsUncertain) {
    Applied mill;
    mill.now.predicted = 95 * um;
    mill.now.since_sigma = mill.now.sigma = 20 * um;
    mill.step();
    EXPECT_LE(mill.authority.offset(), 40 * um);
    EXPECT_EQ(mill.authority.doubt(), Doubt::prediction);
}

TEST(GrowthAuthority, InACycleALossOfTrustMovesNothing) {
    Applied mill;
    mill.now.predicted = 45 * um;
    mill.step();
    mill.now.in_cycle = true;
    mill.now.since_sigma = mill.now.sigma = 30 * um;
    mill.now.load_valid = false;
    for (int i = 0; i < 3000; ++i) {
        mill.now.predicted += 0.01 * um;
        ASSERT_NEAR(mill.step(), 45 * um, 1e-12);
    }
    EXPECT_EQ(mill.authority.doubt(), Doubt::load);
    mill.now.in_cycle = false;
    EXPECT_EQ(mill.step(), 0) << "hold-time has passed twice";
}

TEST(GrowthAuthority, WithoutContactsTheOffsetHoldsAndReturnsToZeroBetweenCycles) {
    Applied mill;
    mill.now.predicted = 45 * um;
    mill.step();
    mill.now.barren = true;
    mill.now.predicted = 60 * um;
    EXPECT_NEAR(mill.step(599), 45 * um, 1 * um) << "it holds, and follows no prediction";
    EXPECT_EQ(mill.authority.doubt(), Doubt::missed);
    double last = mill.authority.offset();
    for (int i = 0; i < 650; ++i) {
        const double now = mill.step();
        ASSERT_LE(now, last + 1e-12);
        ASSERT_LT(last - now, 0.5 * um);
        last = now;
    }
    EXPECT_EQ(last, 0);
    EXPECT_EQ(mill.authority.doubt(), Doubt::old);
    mill.now.barren = false;
    mill.now.accepted = true;
    mill.now.held = mill.now.predicted;
    EXPECT_NEAR(mill.step(), 60 * um, 1e-12) << "a contact brings it back";
}

TEST(GrowthAuthority, StaysWithinTheGateAboutTheLastContact) {
    Applied mill;
    mill.now.spread = 15 * um;
    mill.now.predicted = 90 * um;
    EXPECT_LE(mill.step(), 55 * um + 1e-12);
}

TEST(GrowthAuthority, HoldsAContactWhosePredictionIsWideButOnTheSameSide) {
    Applied mill;
    mill.now.predicted = 200 * um;
    mill.now.since_sigma = mill.now.sigma = 50 * um;
    EXPECT_NEAR(mill.step(), 40 * um, 1e-12) << "half of it is left, by more than three standard deviations";
    mill.now.predicted = 40 * um;
    EXPECT_LT(mill.step(), 1 * um);
}

TEST(GrowthAuthority, AnErrorToExpectBeyondTheToleranceIsADoubt) {
    Applied mill(70 * um);
    mill.now.sigma = 9 * um;
    mill.step();
    EXPECT_EQ(mill.authority.doubt(), Doubt::none);
    mill.now.sigma = 10.5 * um;
    mill.step();
    EXPECT_EQ(mill.authority.doubt(), Doubt::uncertain);
    mill.now.sigma = 9 * um;
    mill.step();
    EXPECT_EQ(mill.authority.doubt(), Doubt::uncertain) << "it ends at 8, so that noise sends no messages";
    mill.now.sigma = 7 * um;
    mill.step();
    EXPECT_EQ(mill.authority.doubt(), Doubt::none);
    mill.settings.tolerance = 5 * um;
    mill.step();
    EXPECT_EQ(mill.authority.doubt(), Doubt::uncertain);
}

TEST(GrowthAuthority, HarmIsRarerThanOneCutIn700) {
    std::mt19937 generator(1);
    constexpr double harmless = 5 * um;
    for (const double growth : {6 * um, 10 * um, 25 * um, 55 * um})
        for (const double sigma : {1 * um, 3 * um, 8 * um}) {
            GrowthAuthority::Evidence e;
            e.possible = {{{1, growth, sigma}}};
            const double correction = std::min(growth, GrowthAuthority::allowed(growth, e, harmless));
            std::normal_distribution<double> truth(growth, sigma);
            int harm = 0;
            constexpr int draws = 100000;
            for (int i = 0; i < draws; ++i) {
                const double grown = truth(generator);
                harm += std::abs(grown - correction) - std::abs(grown) > harmless + 1e-12;
            }
            EXPECT_LT(harm, draws / 600.0) << growth << ' ' << sigma;
            if (growth > 2 * sigma) {
                EXPECT_GE(correction, harmless - 1e-12) << growth << ' ' << sigma;
            }
            if (growth + harmless > 6 * sigma) {
                EXPECT_NEAR(correction, growth, 1e-12) << growth << ' ' << sigma;
            }
        }
    GrowthAuthority::Evidence e;
    e.possible = {{{1, 4 * um, 4 * um}}};
    EXPECT_EQ(GrowthAuthority::allowed(4 * um, e, harmless), 0) << "as large as its uncertainty";
}

// Has the spindle shrunk by 8 um, or is the work higher? The offset is right for the one, and harmless for
// the other.
TEST(GrowthAuthority, TwoExplanationsAreNoWideUncertainty) {
    Applied mill(16 * um);
    mill.single = false;
    mill.now.possible = {{{0.6, 16 * um, 1 * um}, {0.4, 8 * um, 1 * um}}};
    mill.now.sigma = 6 * um;
    EXPECT_NEAR(mill.step(), 16 * um, 0.5 * um);
    mill.now.possible[1].growth = 2 * um;
    EXPECT_NEAR(mill.step(), 5 * um, 2 * um);
    mill.now.possible[1].weight = 1e-3;
    EXPECT_NEAR(mill.step(), 16 * um, 0.5 * um) << "too unlikely to count";
}

TEST(GrowthAuthority, ACutThatDiffersFromTheGaugesMakesTheOffsetSmaller) {
    Applied alike(12 * um), apart(12 * um);
    EXPECT_NEAR(alike.step(), 12 * um, 1e-12);
    apart.now.apart = 4 * um;
    EXPECT_LT(apart.step(), 8 * um);
    EXPECT_GT(apart.step(), 4 * um);
}

TEST(GrowthAuthority, NoiseOfTheCertaintyDoesNotMoveTheOffset) {
    Applied mill(25 * um);
    mill.now.sigma = 8.1 * um;
    const double before = mill.step();
    ASSERT_LT(before, 20 * um);
    ASSERT_GT(before, 3 * um);
    for (int i = 0; i < 100; ++i) {
        mill.now.sigma = (i % 2 ? 8 : 8.1) * um;
        EXPECT_NEAR(mill.step(), before, 1e-12);
    }
}

TEST(GrowthAuthority, AGrowthThatIsHeldBackIsADoubt) {
    Applied mill;
    mill.now.held = mill.now.predicted = 58 * um;
    mill.now.sigma = 25 * um;
    mill.step();
    EXPECT_LT(mill.authority.offset(), 30 * um);
    EXPECT_EQ(mill.authority.doubt(), Doubt::held_back);
}

TEST(GrowthAuthority, NamesEachDoubt) {
    const auto doubt = [](auto change) {
        Applied mill(70 * um);
        change(mill.now);
        mill.step();
        return mill.authority.doubt();
    };
    using Evidence = GrowthAuthority::Evidence;
    EXPECT_EQ(doubt([](Evidence& e) { e.shift = Shift::one_tool; }), Doubt::contradiction);
    EXPECT_EQ(doubt([](Evidence& e) { e.shift = Shift::all; }), Doubt::shift);
    EXPECT_EQ(doubt([](Evidence& e) { e.shift = Shift::only_tool; }), Doubt::shift);
    EXPECT_EQ(doubt([](Evidence& e) { e.shift = Shift::by_feed; }), Doubt::shift_by_feed);
    EXPECT_EQ(doubt([](Evidence& e) { e.program_event = true; }), Doubt::program_event);
    EXPECT_EQ(doubt([](Evidence& e) { e.sigma = e.reference_sigma = 11 * um; }), Doubt::poor_reference);
    EXPECT_EQ(doubt([](Evidence& e) { e.barren = true; }), Doubt::missed);
    EXPECT_EQ(doubt([](Evidence& e) { e.sigma = 11 * um; }), Doubt::uncertain);
    EXPECT_EQ(doubt([](Evidence& e) { e.sigma = e.since_sigma = 11 * um; }), Doubt::prediction);
    EXPECT_EQ(doubt([](Evidence& e) { e.sigma = 11 * um, e.compared = false; }), Doubt::unknown);
    EXPECT_EQ(doubt([](Evidence&) {}), Doubt::none);
}

}  // namespace
}  // namespace plumb
