// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/contact/growth_estimator.hpp"

#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

using Verdict = GrowthEstimator::Verdict;
using Withdrawal = GrowthEstimator::Withdrawal;

constexpr double um = 1e-3;  // mm

// Cycles of a machine at rest, a minute apart, with gauges of two tools: 0 and 1 of tool 1, 2 of tool 2.
struct Machine {
    GrowthEstimator::Settings settings{{true, 15 * um, 6 * um, 1 * um, 3 * um}, 15 * um, 60 * um};
    GrowthEstimator estimator{};
    double noise = 0.5 * um, reference_sigma = 0.5 * um;
    std::int32_t cycle = 0;

    Machine() {
        step(1);
        for (int i = 0; i < 3; ++i) estimator.learn(0, 0.5 * um, true, settings);
        estimator.renew_gauges();
    }

    void step(double seconds) {
        for (double t = 0; t < seconds; ++t) estimator.step(0, 20, false, settings, 1);
    }
    void begin() {
        ++cycle;
        step(60);
    }
    Verdict contact(int gauge, double growth, double offset = 0, bool admitted = true) {
        GrowthEstimator::Reading r;
        r.growth = growth;
        r.noise = noise;
        r.reference_sigma = reference_sigma;
        r.applied_offset = offset;
        r.gauge = gauge;
        r.tool = gauge < 2 ? 1 : 2;
        r.cycle = cycle;
        r.other_tools = true;
        r.admitted = admitted;
        return estimator.judge(r, settings);
    }
};

TEST(GrowthEstimator, ManyContactsOfOneGaugeAreNoMoreCertainThanItsReference) {
    Machine machine;
    machine.reference_sigma = 10 * um;
    for (int n = 0; n < 200; ++n) {
        machine.begin();
        machine.contact(0, 0);
    }
    const double one = machine.estimator.sigma();
    EXPECT_GT(one, 0.9 * um) << "that of the learning cycle, at least";
    Machine far;
    far.estimator.forget();
    far.reference_sigma = 10 * um;
    for (int n = 0; n < 200; ++n) {
        far.begin();
        far.contact(0, 5 * um);
    }
    EXPECT_GT(far.estimator.sigma(), 9 * um);
    for (int n = 0; n < 200; ++n) {
        far.begin();
        far.contact(0, 5 * um);
        far.contact(2, 5 * um);
    }
    EXPECT_LT(far.estimator.sigma(), 8.5 * um) << "two references have less in common";
    EXPECT_GT(far.estimator.sigma(), 6.5 * um);
}

TEST(GrowthEstimator, AStepThatTwoToolsShowIsTakenWhole) {
    Machine machine;
    machine.begin();
    EXPECT_EQ(machine.contact(0, 20 * um), Verdict::claim);
    EXPECT_EQ(machine.contact(1, 20 * um), Verdict::claim) << "the same tool";
    EXPECT_NEAR(machine.estimator.growth(), 0, 1 * um);
    EXPECT_EQ(machine.contact(2, 20 * um), Verdict::accepted);
    EXPECT_NEAR(machine.estimator.growth(), 20 * um, 1 * um);
    EXPECT_EQ(machine.contact(0, 20 * um), Verdict::accepted);
    EXPECT_FALSE(machine.estimator.contradicted());
}

TEST(GrowthEstimator, AStepAfterAnotherIsTakenWholeByItsSecondContact) {
    Machine machine;
    machine.noise = 1 * um;
    for (double growth : {0 * um, 0 * um, 0 * um, 8 * um}) {
        machine.begin();
        for (int gauge : {0, 1, 2}) machine.contact(gauge, growth);
    }
    machine.begin();
    EXPECT_EQ(machine.contact(0, 16 * um), Verdict::accepted) << "in part, as far as it is possible";
    EXPECT_LT(machine.estimator.growth(), 12 * um);
    EXPECT_EQ(machine.contact(1, 16 * um), Verdict::accepted);
    EXPECT_NEAR(machine.estimator.growth(), 16 * um, 1 * um);
}

TEST(GrowthEstimator, AChipShiftsNothing) {
    Machine machine;
    machine.begin();
    EXPECT_EQ(machine.contact(0, 40 * um), Verdict::claim);
    EXPECT_EQ(machine.contact(2, 0), Verdict::accepted);
    machine.begin();
    EXPECT_EQ(machine.contact(0, 0), Verdict::accepted);
    EXPECT_NEAR(machine.estimator.growth(), 0, 1 * um);
    EXPECT_FALSE(machine.estimator.contradicted());
}

TEST(GrowthEstimator, AfterAPauseNoFirstContactIsTakenAlone) {
    Machine machine;
    machine.estimator.forget();
    machine.begin();
    EXPECT_EQ(machine.contact(0, 40 * um), Verdict::claim);
    EXPECT_EQ(machine.contact(2, 3 * um), Verdict::accepted) << "it moves little";
    EXPECT_NEAR(machine.estimator.growth(), 3 * um, 1 * um);
}

TEST(GrowthEstimator, ALongerToolIsWithdrawnAndSaidFromItsSecondCycleOn) {
    Machine machine;
    for (int n = 1; n <= 4; ++n) {
        machine.begin();
        machine.contact(2, 30 * um, 0, n != 2);
        EXPECT_EQ(machine.contact(0, 0), Verdict::accepted);
        EXPECT_EQ(machine.contact(1, 0), Verdict::accepted);
        EXPECT_EQ(machine.estimator.contradicted(), n >= 2) << n;
    }
    EXPECT_EQ(machine.estimator.withdrawal(2), Withdrawal::contradiction);
    EXPECT_EQ(machine.estimator.withdrawal(0), Withdrawal::none);
    EXPECT_NEAR(machine.estimator.growth(), 0, 1 * um);
    machine.estimator.renew_gauges();
    EXPECT_FALSE(machine.estimator.contradicted()) << "it was learnt again";
}

TEST(GrowthEstimator, AReferenceThatIsALittleOffIsAllowedFor) {
    Machine machine;
    for (int n = 1; n <= 8; ++n) {
        machine.begin();
        const Verdict verdict = machine.contact(2, 10 * um);
        EXPECT_EQ(machine.contact(0, 0), Verdict::accepted);
        EXPECT_EQ(machine.contact(1, 0), Verdict::accepted);
        EXPECT_FALSE(machine.estimator.contradicted()) << n;
        EXPECT_NEAR(machine.estimator.growth(), 0, (n < 5 ? 2.5 : 1) * um) << n;
        if (n > 3) EXPECT_EQ(verdict, Verdict::accepted) << n;
    }
    EXPECT_EQ(machine.estimator.withdrawal(2), Withdrawal::none);
}

TEST(GrowthEstimator, BeyondTheGateNothingIsTakenHoweverOftenItIsClaimed) {
    Machine machine;
    for (int n = 0; n < 20; ++n) {
        machine.begin();
        for (const int gauge : {0, 1, 2})
            EXPECT_NE(machine.contact(gauge, 50 * um, 0, false), Verdict::accepted);
    }
    EXPECT_NEAR(machine.estimator.growth(), 0, 1 * um);
}

TEST(GrowthEstimator, ContactsThatScatterMoreThanTheirNoiseWidenSigma) {
    Machine clean, rough;
    Random random(3);
    for (int n = 0; n < 100; ++n) {
        clean.begin();
        rough.begin();
        clean.contact(0, 0.5 * um * random.gaussian());
        rough.contact(0, 6 * um * random.gaussian());
    }
    EXPECT_LT(clean.estimator.sigma(), 1.5 * um);
    EXPECT_GT(rough.estimator.sigma(), 1.3 * clean.estimator.sigma());
    EXPECT_LT(std::abs(rough.estimator.growth()), 3 * rough.estimator.sigma());
}

TEST(GrowthEstimator, AGaugeThatMovesWithTheOffsetIsWithdrawn) {
    Machine machine;
    for (int n = 0; n < 12; ++n) {
        machine.begin();
        machine.contact(0, 0);
        const double offset = n == 9 ? 10 * um : 0;  // as after another setting
        machine.contact(2, offset, offset);
    }
    machine.begin();
    machine.contact(2, 10 * um, 10 * um);
    EXPECT_NE(machine.estimator.withdrawal(2), Withdrawal::none);
    EXPECT_EQ(machine.estimator.withdrawal(0), Withdrawal::none);
}

}  // namespace
}  // namespace plumb
