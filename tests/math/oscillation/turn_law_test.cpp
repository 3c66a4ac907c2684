// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/turn_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3, unit = 5 * um;

// An axis that follows with a first-order lag of T s, and stands c mm short by friction.
double beyond(const TurnLaw::Turn& turn, double T, double c) {
    const double square = 2 * turn.acceleration / turn.length;
    return turn.length / 2 * (1 / std::sqrt(1 + square * T * T) - 1) - c;
}

TurnLaw::Turn crank(double acceleration, double length) {
    return {acceleration, acceleration, length};
}

TEST(TurnLaw, PredictsOtherStrokesOfALinearAxisWithinItsDoubt) {
    for (const double T : {0.005, 0.02, 0.04}) {
        TurnLaw law;
        for (double part = 0.04; part < 1.01; part *= 1.6)
            law.add(crank(1000 * part, 40), beyond(crank(1000 * part, 40), T, 2 * um), unit);
        EXPECT_EQ(law.surprise(), 0) << T;
        for (const double length : {25.0, 40.0, 60.0})
            for (const double acceleration : {200.0, 600.0, 1000.0}) {
                const auto wanted = crank(acceleration, length);
                const auto its = law.predict(wanted, unit);
                const double truth = beyond(wanted, T, 2 * um);
                EXPECT_LE(std::abs(its.beyond - truth), its.doubt) << T << " " << length;
                if (law.covers(wanted)) {
                    EXPECT_NEAR(its.beyond, truth, 0.05 * std::abs(truth) + um) << T << " " << length;
                }
                if (length == 40 && acceleration < 1000) {
                    EXPECT_LT(its.doubt, 0.2 * std::abs(truth) + 20 * um) << T << " " << acceleration;
                }
            }
    }
}

TEST(TurnLaw, FewStrokesGiveAWidePrediction) {
    TurnLaw law;
    EXPECT_TRUE(law.empty());
    law.add(crank(200, 40), -0.1, unit);
    const auto wide = law.predict(crank(1000, 40), unit);
    EXPECT_GT(wide.doubt, 0.3 * std::abs(wide.beyond));
    const auto like = law.predict(crank(200, 40), unit);
    EXPECT_NEAR(like.beyond, -0.1, um);
    EXPECT_LT(like.doubt, um);
}

TEST(TurnLaw, AnAxisThatTurnsWhereItsCommandDoesIsPredicted) {
    TurnLaw law;
    for (const double acceleration : {40.0, 400.0, 1000.0}) law.add(crank(acceleration, 40), 0, unit);
    const auto its = law.predict(crank(1000, 41), unit);
    EXPECT_NEAR(its.beyond, 0, um);
    EXPECT_GE(its.doubt, 0);
    EXPECT_LT(its.doubt, 2 * um);
}

// A climb brakes by less than it accelerates with.
TEST(TurnLaw, StrokesThatBrakeGentlyPredictOneThatDoesNot) {
    TurnLaw law;
    const auto turn = [](const TurnLaw::Turn& its) { return -2e-4 * its.acceleration - 5e-5 * its.leaving; };
    for (double level = 64; level < 700; level *= 1.6) {
        const TurnLaw::Turn its{level / 1.6, level, 40};
        law.add(its, turn(its), unit);
    }
    law.add(crank(40, 40), turn(crank(40, 40)), unit);
    const auto its = law.predict(crank(700, 40), unit);
    EXPECT_NEAR(its.beyond, -0.175, 0.025);
    EXPECT_LE(std::abs(its.beyond + 0.175), its.doubt);
}

TEST(TurnLaw, CoversTheFrequenciesOfItsTurnsAndTheLowerOnesWithItsSections) {
    TurnLaw law;
    EXPECT_FALSE(law.covers(crank(1, 100)));
    law.add(crank(1000, 50), -0.2, unit);
    law.add(crank(500, 50), -0.1, unit);
    EXPECT_TRUE(law.covers(crank(1000, 50)));
    EXPECT_TRUE(law.covers(crank(1500, 100)));
    EXPECT_TRUE(law.covers(crank(1050, 50))) << "nearly";
    EXPECT_FALSE(law.covers(crank(1200, 50)));
    EXPECT_FALSE(law.covers(crank(900, 25))) << "less acceleration, but quicker";
    EXPECT_FALSE(law.covers({500, 500, 50, 7})) << "with sections";
    law.add({400, 400, 50, 7}, -0.1, unit);
    EXPECT_TRUE(law.covers({500, 500, 50, 7}));
}

TEST(TurnLaw, ATurnBesideASectionReplacesAllEvenOnes) {
    TurnLaw law;
    for (double part = 0.04; part < 1.01; part *= 1.6) law.add(crank(1000 * part, 40), -0.5 * part, unit);
    const TurnLaw::Turn section{1000, 1000, 40, 7};
    EXPECT_NEAR(law.predict(section, unit).beyond, -0.5, 0.05);
    law.add(section, 0.3, unit);
    EXPECT_EQ(law.surprise(), 0) << "no even stroke explains it";
    EXPECT_NEAR(law.predict(section, unit).beyond, 0.3, um);
    EXPECT_NEAR(law.predict(crank(1000, 40), unit).beyond, -0.5, 0.05);
}

// By the mean length of the strokes before and after it.
TEST(TurnLaw, TwoTurnsGiveTheSlopeBesideASection) {
    for (const double at_100 : {-5.0, -0.2, 0.2, 2.0})
        for (const double falls : {0.1, 0.5, 1.0}) {
            const auto its = [&](double length) { return TurnLaw::Turn{1000, 1000, length, 7}; };
            const auto truth = [&](double length) { return at_100 * std::pow(100 / length, falls); };
            TurnLaw law;
            law.add(its(96), truth(96), unit);
            const double guessed = law.predict(its(100), unit).doubt;
            EXPECT_LE(std::abs(law.predict(its(100), unit).beyond - truth(100)), guessed) << at_100;
            law.add(its(99), truth(99), unit);
            const auto known = law.predict(its(100), unit);
            EXPECT_LT(known.doubt, guessed / 2) << at_100 << " " << falls;
            EXPECT_LE(std::abs(known.beyond - truth(100)), known.doubt) << at_100 << " " << falls;
        }
}

TEST(TurnLaw, ASurpriseIsADoubtUntilATurnAgrees) {
    TurnLaw law;
    for (double part = 0.04; part < 1.01; part *= 1.6) law.add(crank(1000 * part, 40), -0.5 * part, unit);
    law.add(crank(1000, 40), -0.5, unit);
    const double before = law.predict(crank(1000, 40), unit).doubt;
    law.add(crank(1000, 40), -0.3, unit);
    EXPECT_GT(law.surprise(), 0.1);
    EXPECT_GT(law.predict(crank(1000, 40), unit).doubt, before + 0.1);
    law.add(crank(1000, 40), -0.3, unit);
    EXPECT_EQ(law.surprise(), 0);
    EXPECT_LT(law.predict(crank(1000, 40), unit).doubt, 5 * um);
    const double odd = law.predict(crank(1000, 41), unit).doubt;
    law.begin();
    EXPECT_LT(law.predict(crank(1000, 41), unit).doubt, odd) << "of another stroke";
}

// It would give a slope between two axes.
TEST(TurnLaw, ARememberedTurnOfAnotherAxisIsForgotten) {
    TurnLaw law;
    TurnLaw::Turn remembered = crank(1000, 41);
    remembered.remembered = true;
    law.add(remembered, -0.9, unit);
    law.add(crank(1000, 40), -0.5, unit);
    EXPECT_GT(law.surprise(), 0.3);
    law.add(crank(1000, 40), -0.5, unit);
    EXPECT_NEAR(law.predict(crank(1000, 40.5), unit).beyond, -0.5, 0.02);
}

TEST(TurnLaw, TheFirstTurnAfterAStartIsDoubted) {
    TurnLaw::Turn first = crank(1000, 40);
    first.starts = true;
    TurnLaw law, usual;
    law.add(first, -0.5, unit);
    usual.add(crank(1000, 40), -0.5, unit);
    EXPECT_GT(law.predict(crank(1000, 40), unit).doubt, usual.predict(crank(1000, 40), unit).doubt + 3 * um);
}

TEST(TurnLaw, NothingImpossibleIsAdded) {
    TurnLaw law;
    for (const double bad : {0.0, -1.0, std::nan("")}) {
        law.add({bad, 1, 40}, 0, unit);
        law.add({1, 1, bad}, 0, unit);
        if (std::isnan(bad)) law.add(crank(1, 40), bad, unit);
    }
    EXPECT_TRUE(law.empty());
    for (int i = 1; i < 100; ++i) law.add(crank(10 * i, 40), -1e-4 * i, unit);
    EXPECT_TRUE(std::isfinite(law.predict(crank(900, 40), unit).beyond));
}

}  // namespace
}  // namespace plumb
