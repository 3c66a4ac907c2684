// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/axis_growth/probed_reference.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb::axis_growth {
namespace {

constexpr double um = 1e-3;

// A bore at 100 mm whose machine is cold at first.
struct Bore : testing::Test {
    ProbedReference bore;
    ProbedReference::Settings settings;

    Bore() { EXPECT_EQ(bore.probe(100, 0, true, settings), Probing::reference); }
    Probing warm(double grown, double law) { return bore.probe(100 + grown, law, false, settings); }
    // Two touches, a work zero, which moves nothing, and two hours. Returns the growth at the zero.
    double zero_after_two_touches(double law) {
        for (int touch = 0; touch < 2; ++touch) warm(75 * um, 60 * um);
        bore.take_over();
        const double before = bore.corrected(law);
        bore.count_from_zero(law, settings);
        EXPECT_NEAR(bore.corrected(law), before, 1e-12);
        for (int second = 0; second < 7200; ++second) bore.step(1, settings);
        return before;
    }
};

TEST_F(Bore, ColdIsAReferenceOnly) {
    EXPECT_EQ(bore.probe(100 + 40 * um, 1 * um, true, settings), Probing::reference);
    bore.take_over();
    EXPECT_EQ(bore.corrected(30 * um), 30 * um);
    EXPECT_EQ(bore.change(30 * um), 0);
}

TEST_F(Bore, WithoutAReferenceAWarmProbingChangesNothing) {
    bore.forget();
    EXPECT_EQ(warm(50 * um, 30 * um), Probing::no_reference);
    EXPECT_EQ(bore.corrected(30 * um), 30 * um);
}

// The zero contains the error of 15 um that the touches found: it is no error of the next part.
TEST_F(Bore, AWorkZeroMakesTheTouchBeforeItTheReference) {
    const double before = zero_after_two_touches(62 * um);
    for (int touch = 0; touch < 2; ++touch) warm(95 * um, 80 * um);
    bore.take_over();
    EXPECT_NEAR(bore.corrected(80 * um), before + 18 * um, 0.1 * um);
    for (int touch = 0; touch < 2; ++touch) warm(105 * um, 80 * um);
    EXPECT_GT(bore.change(80 * um), 0.5 * um) << "an error that came after the zero";
}

TEST_F(Bore, AWorkZeroWithoutATouchEndsTheCorrections) {
    const double before = zero_after_two_touches(90 * um);
    bore.take_over();
    EXPECT_NEAR(bore.corrected(100 * um), before + 10 * um, 1e-12) << "the law goes on, and nothing fades";
    EXPECT_EQ(warm(120 * um, 100 * um), Probing::no_reference);
    bore.count_from_zero(101 * um, settings);
    EXPECT_EQ(warm(120 * um, 100 * um), Probing::first) << "the touch before this zero is its reference";
}

TEST_F(Bore, TouchesThatDisagreeAreNoReferenceOfAZero) {
    warm(30 * um, 30 * um);
    EXPECT_EQ(warm(38 * um, 30 * um), Probing::moved);
    bore.count_from_zero(30 * um, settings);
    EXPECT_EQ(warm(38 * um, 30 * um), Probing::no_reference);
}

TEST_F(Bore, TouchesLowerTheUncertaintyOfTheGrowth) {
    const double without = 20 * um;
    EXPECT_EQ(bore.sigma(60 * um, without), without);
    EXPECT_EQ(warm(75 * um, 60 * um), Probing::first);
    EXPECT_EQ(bore.sigma(60 * um, without), without) << "one touch is no reading";
    for (int touch = 0; touch < 3; ++touch) warm(75 * um, 60 * um);
    const double not_in_force = bore.sigma(60 * um, without);
    EXPECT_GT(not_in_force, bore.change(60 * um));
    bore.take_over();
    EXPECT_LT(bore.sigma(60 * um, without), not_in_force);
    const double now = bore.sigma(60 * um, without);
    EXPECT_LT(now, 0.6 * without);
    EXPECT_GT(now, settings.uncertainty);
    EXPECT_GT(bore.sigma(120 * um, without), now) << "by the scale";
    for (int second = 0; second < 7200; ++second) bore.step(1, settings);
    EXPECT_GT(bore.sigma(60 * um, without), now) << "another error comes";
}

// Of an error, by Student's t with three degrees of freedom.
double likelihood(double error, double variance) {
    return std::pow(1 + error * error / (3 * variance), -2) / std::sqrt(variance);
}

// A Kalman gain of the offset times the probability that the error lasts. Readings of 6.25 um with noise of
// 2 um twice and of the reference: 1.5 * 4 um².
TEST_F(Bore, OffsetFollowsTwoTouchesThatAgreeAndScaleStaysWhileTheDriftIsSmall) {
    EXPECT_EQ(warm(14 * um, 8 * um), Probing::first);
    EXPECT_EQ(bore.change(8 * um), 0) << "one touch changes nothing";
    EXPECT_EQ(warm(14.5 * um, 8 * um), Probing::corrected);
    const double lasts = likelihood(6.25, 25 + 6), comes_and_goes = lasts, none = likelihood(6.25, 6);
    const double expected = lasts / (lasts + comes_and_goes + none) * 6.25 * um * 25 / (25 + 6);
    EXPECT_NEAR(bore.change(8 * um), expected, 1e-9);
    EXPECT_EQ(bore.corrected(8 * um), 8 * um) << "between parts only";
    bore.take_over();
    EXPECT_EQ(bore.scale(), 1);
    EXPECT_NEAR(bore.corrected(8 * um), 8 * um + expected, 1e-9);
    EXPECT_EQ(bore.change(8 * um), 0);
    bore.probe(100, 0, true, settings);
    bore.take_over();
    EXPECT_EQ(bore.corrected(8 * um), 8 * um) << "cold again";
}

TEST_F(Bore, OffsetFadesByItsTimeConstantBetweenPartsOnly) {
    warm(14 * um, 8 * um);
    warm(14 * um, 8 * um);
    bore.take_over();
    const double before = bore.corrected(0);
    for (int i = 0; i < 7200; ++i) bore.step(1, settings);
    EXPECT_EQ(bore.corrected(0), before) << "in a part";
    bore.take_over();
    EXPECT_NEAR(bore.corrected(0), std::exp(-1) * before, 1e-9);
}

TEST_F(Bore, ScaleTakesTheErrorOfALargeDriftThatLasts) {
    for (int touch = 0; touch < 4; ++touch) warm(75 * um, 60 * um);
    bore.take_over();
    EXPECT_NEAR(bore.corrected(60 * um), 74 * um, 1.5 * um);
    EXPECT_NEAR(bore.scale(), 1.22, 0.04);
    EXPECT_NEAR(bore.corrected(90 * um), 110 * um, 3 * um) << "of a drift that comes later";
}

TEST_F(Bore, TheScatterOfTouchesCorrectsLittle) {
    for (int touch = 0; touch < 2; ++touch) warm(10.5 * um, 8 * um);
    EXPECT_LT(bore.change(8 * um), 0.7 * um);
    EXPECT_GT(bore.change(8 * um), 0);
}

TEST_F(Bore, ScaleStaysWithinItsLimits) {
    for (int touch = 0; touch < 2; ++touch) warm(100 * um, 60 * um);
    bore.take_over();
    EXPECT_GT(bore.scale(), 1.4);
    EXPECT_LE(bore.scale(), 1.5);
}

// An error that changes its sign from reading to reading shows that neither offset nor scale lasts.
TEST_F(Bore, AnErrorThatDoesNotLastIsCorrectedLessAndLess) {
    const auto read = [&](double left) {
        for (int touch = 0; touch < 2; ++touch) warm(30 * um + left, 30 * um);
        bore.take_over();
        return std::abs(bore.corrected(30 * um) - 30 * um);
    };
    const double first = read(8 * um);
    EXPECT_GT(first, 2 * um);
    double most = 0;
    for (int i = 0; i < 6; ++i) {
        for (int second = 0; second < 1800; ++second) bore.step(1, settings);
        most = read(i % 2 ? 8 * um : -8 * um);
    }
    EXPECT_LT(most, 0.1 * first);
}

TEST_F(Bore, TwoTouchesThatDisagreeOrThatNoScaleExplainsAskForBoreAndProbe) {
    warm(30 * um, 30 * um);
    EXPECT_EQ(warm(38 * um, 30 * um), Probing::moved);
    EXPECT_EQ(warm(90 * um, 30 * um), Probing::moved) << "does not agree with the one before";
    EXPECT_EQ(warm(90 * um, 30 * um), Probing::moved) << "agrees, and needs a scale of 3";
    EXPECT_EQ(bore.change(30 * um), 0);
}

TEST_F(Bore, ALawThatTwoProbingsFindWorseThanNoneIsRevoked) {
    EXPECT_EQ(warm(2 * um, 30 * um), Probing::first);
    EXPECT_EQ(warm(2 * um, 30 * um), Probing::revoked);
    EXPECT_NEAR(bore.change(30 * um), -30 * um, 1e-12);
    EXPECT_EQ(bore.corrected(30 * um), 30 * um) << "the part is finished with the law";
    bore.take_over();
    EXPECT_EQ(bore.corrected(30 * um), 0);
    EXPECT_EQ(bore.scale(), 0);
    EXPECT_EQ(bore.probe(100, 0, true, settings), Probing::reference);
    EXPECT_TRUE(bore.revoked()) << "a cold machine does not make the law right";
}

TEST_F(Bore, OneWorseProbingBetweenGoodOnesRevokesNothing) {
    warm(30 * um, 30 * um);
    warm(2 * um, 30 * um);
    warm(30 * um, 30 * um);
    EXPECT_FALSE(bore.revoked());
}

// At the end of a day the growth passes 0, and what the law may leave is more than all of it.
TEST_F(Bore, AMachineThatCoolsRevokesNoLaw) {
    for (const double grown : {30 * um, 10 * um, 1 * um, -2 * um})
        for (int touch = 0; touch < 2; ++touch) warm(grown, grown + 6 * um);
    EXPECT_FALSE(bore.revoked());
    ProbedReference other;
    other.probe(100, 0, true, settings);
    for (int touch = 0; touch < 2; ++touch) other.probe(100 + 1 * um, 6 * um, false, settings);
    EXPECT_FALSE(other.revoked()) << "nor one that warms up";
}

TEST_F(Bore, RevokedTheGrowthIsThatOfTheReference) {
    ProbedReference later;
    later.probe(100, 40 * um, true, settings);
    later.probe(100, 70 * um, false, settings);
    EXPECT_EQ(later.probe(100, 70 * um, false, settings), Probing::revoked);
    later.take_over();
    EXPECT_EQ(later.corrected(70 * um), 40 * um);
    EXPECT_EQ(later.corrected(20 * um), 40 * um);
}

// Laws of drawn scale and offset error; noise of the probing.
TEST(ProbedReference, DrawnLawsAreCorrectedAndRarelySpoiled) {
    Random random(31);
    double without = 0, with = 0;
    int spoiled = 0;
    constexpr int machines = 2000;
    for (int i = 0; i < machines; ++i) {
        ProbedReference bore;
        const ProbedReference::Settings settings;
        const double scale = 1 + 0.3 * random.gaussian(), offset = 4 * um * random.gaussian();
        const double law = random.uniform(5, 60) * um, later = law * random.uniform(0.6, 1.4);
        const auto probe = [&](double drift, double by_law, bool cold) {
            bore.probe(100 + drift + settings.uncertainty * random.gaussian(), by_law, cold, settings);
        };
        probe(0, 0, true);
        probe(scale * law + offset, law, false);
        probe(scale * law + offset, law, false);
        bore.take_over();
        const double truth = scale * later + offset;
        without += std::pow(truth - later, 2);
        with += std::pow(truth - bore.corrected(later), 2);
        spoiled += std::abs(truth - bore.corrected(later)) > std::abs(truth - later) + 5 * um;
    }
    EXPECT_LT(std::sqrt(with), 0.6 * std::sqrt(without));
    EXPECT_LE(spoiled, machines / 50);
}

}  // namespace
}  // namespace plumb::axis_growth
