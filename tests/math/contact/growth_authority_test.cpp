// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/contact/growth_authority.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

struct Applied {
    GrowthAuthority::Settings settings{15 * um, 600};
    GrowthAuthority::Evidence now{};
    GrowthAuthority authority{};

    Applied() {
        now.held = now.predicted = 40 * um;
        now.sigma = 1 * um;
        now.spread = 60 * um;
        now.accepted = true;
        step();
        now.accepted = false;
    }
    double step(double seconds = 1) {
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
    mill.now.agreement = 0;
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

TEST(GrowthAuthority, AnOffsetThatMayDoHarmIsDoubtedAndAPartOfItIsNot) {
    Applied mill;
    mill.authority.forget();
    mill.now.held = mill.now.predicted = 8 * um;
    mill.now.sigma = 5.7 * um;
    mill.step();
    EXPECT_LT(mill.authority.part(), 0.5) << "the machine has begun to warm";
    EXPECT_EQ(mill.authority.doubt(), Doubt::none);
    mill.now.predicted = 20 * um;
    mill.now.sigma = 3 * um;
    mill.step();
    EXPECT_EQ(mill.authority.part(), 1);
    EXPECT_EQ(mill.authority.doubt(), Doubt::none);
    mill.now.in_cycle = true;
    mill.now.sigma = 13 * um;
    mill.step();
    EXPECT_EQ(mill.authority.part(), 1) << "in a cycle it holds";
    EXPECT_EQ(mill.authority.doubt(), Doubt::uncertain);
    mill.now.in_cycle = false;
    mill.now.sigma = 20 * um;
    mill.step();
    EXPECT_EQ(mill.authority.offset(), 0);
    EXPECT_EQ(mill.authority.doubt(), Doubt::uncertain) << "it was applied, and no longer is";
}

TEST(GrowthAuthority, NamesEachDoubt) {
    const auto doubt = [](auto change) {
        Applied mill;
        change(mill.now);
        mill.step();
        return mill.authority.doubt();
    };
    using Evidence = GrowthAuthority::Evidence;
    EXPECT_EQ(doubt([](Evidence& e) { e.contradicted = true; }), Doubt::contradiction);
    EXPECT_EQ(doubt([](Evidence& e) { e.program_event = true; }), Doubt::program_event);
    EXPECT_EQ(doubt([](Evidence& e) { e.no_growth = true; }), Doubt::no_growth);
    EXPECT_EQ(doubt([](Evidence& e) { e.reference_sigma = 8 * um; }), Doubt::poor_reference);
    EXPECT_EQ(doubt([](Evidence& e) { e.agreement = 0.3; }), Doubt::missed);
    EXPECT_EQ(doubt([](Evidence& e) { e.sigma = 20 * um; }), Doubt::uncertain);
    EXPECT_EQ(doubt([](Evidence&) {}), Doubt::none);
}

}  // namespace
}  // namespace plumb
