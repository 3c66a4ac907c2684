// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/contact/plausibility_gate.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm

PlausibilityGate::Settings settings(std::int32_t confirm = 0) {
    PlausibilityGate::Settings s;
    s.max_growth_rate = 0.1 * um;
    s.floor = 15 * um;
    s.cap = 60 * um;
    s.confirm = confirm;
    return s;
}

PlausibilityGate at_rest() {
    PlausibilityGate gate;
    gate.accept(0);
    return gate;
}

TEST(PlausibilityGate, SpreadGrowsWithTimeBetweenFloorAndCap) {
    PlausibilityGate gate = at_rest();
    EXPECT_NEAR(gate.spread(settings()), 15 * um, 1e-12);
    gate.step(300);
    EXPECT_NEAR(gate.spread(settings()), 30 * um, 1e-12);
    gate.step(3600);
    EXPECT_NEAR(gate.spread(settings()), 60 * um, 1e-12);
    gate.accept(40 * um);
    EXPECT_NEAR(gate.spread(settings()), 15 * um, 1e-12);
}

TEST(PlausibilityGate, BeforeTheFirstContactTheSpreadIsTheCap) {
    PlausibilityGate gate;
    EXPECT_TRUE(gate.admits(59 * um, 1, 1, settings()));
    EXPECT_FALSE(gate.admits(-61 * um, 1, 1, settings()));
    gate.accept(0);
    gate.forget();
    EXPECT_NEAR(gate.spread(settings()), 60 * um, 1e-12);
}

TEST(PlausibilityGate, AdmitsChangesSinceTheLastAcceptedContact) {
    PlausibilityGate gate = at_rest();
    for (int i = 1; i <= 10; ++i) {
        EXPECT_TRUE(gate.admits(i * 14 * um, 1, i, settings()));
        gate.accept(i * 14 * um);
    }
    EXPECT_FALSE(gate.admits(140 * um - 16 * um, 1, 11, settings()));
}

TEST(PlausibilityGate, NothingBeyondIsAdmittedHoweverOftenItIsSeen) {
    PlausibilityGate gate = at_rest();
    for (int cycle = 1; cycle <= 100; ++cycle)
        EXPECT_FALSE(gate.admits(100 * um, cycle % 3, cycle, settings())) << cycle;
}

TEST(PlausibilityGate, ConfirmationNeedsAnotherToolInAnotherCycle) {
    PlausibilityGate gate = at_rest();
    const auto s = settings(1);
    EXPECT_FALSE(gate.admits(100 * um, 1, 1, s));
    EXPECT_FALSE(gate.admits(101 * um, 2, 1, s)) << "the same odd blank";
    EXPECT_FALSE(gate.admits(101 * um, 1, 2, s)) << "the same wrong tool";
    EXPECT_TRUE(gate.admits(101 * um, 2, 2, s));
}

TEST(PlausibilityGate, EachOfSeveralConfirmationsMustAgree) {
    PlausibilityGate gate = at_rest();
    const auto s = settings(2);
    EXPECT_FALSE(gate.admits(100 * um, 1, 1, s));
    EXPECT_FALSE(gate.admits(105 * um, 2, 2, s));
    EXPECT_FALSE(gate.admits(200 * um, 1, 3, s)) << "disagrees, so it starts a claim of its own";
    EXPECT_FALSE(gate.admits(205 * um, 2, 4, s));
    EXPECT_TRUE(gate.admits(198 * um, 1, 5, s));
}

TEST(PlausibilityGate, AnOrdinaryContactEndsAClaim) {
    PlausibilityGate gate = at_rest();
    const auto s = settings(1);
    EXPECT_FALSE(gate.admits(100 * um, 1, 1, s));
    EXPECT_TRUE(gate.admits(2 * um, 1, 2, s));
    EXPECT_FALSE(gate.admits(100 * um, 2, 3, s));
}

TEST(PlausibilityGate, NeverAdmitsWhatIsNotANumber) {
    PlausibilityGate gate = at_rest();
    for (int cycle = 1; cycle < 5; ++cycle)
        EXPECT_FALSE(gate.admits(std::numeric_limits<double>::quiet_NaN(), cycle, cycle, settings(1)));
}

TEST(PlausibilityGate, SettingsThatContradictThemselvesAreNotValid) {
    EXPECT_TRUE(settings().valid());
    auto s = settings();
    s.cap = 10 * um;
    EXPECT_FALSE(s.valid());
    s = settings();
    s.max_growth_rate = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(s.valid());
    s = settings(-1);
    EXPECT_FALSE(s.valid());
}

}  // namespace
}  // namespace plumb
