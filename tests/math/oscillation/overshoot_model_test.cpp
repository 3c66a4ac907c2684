// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/overshoot_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3, unit = 5 * um;

// An axis that follows with a first-order lag of T s, and stands c mm short by friction.
double beyond(const OvershootModel::Turn& turn, double T, double c) {
    const double square = 2 * turn.acceleration / turn.length;
    return turn.length / 2 * (1 / std::sqrt(1 + square * T * T) - 1) - c;
}

OvershootModel::Turn crank(double acceleration, double length) {
    return {acceleration, acceleration, length, 1};
}

TEST(OvershootModel, PredictsOtherStrokesOfALinearAxisWithinItsDoubt) {
    for (const double T : {0.005, 0.02, 0.04}) {
        OvershootModel model;
        for (double part = 0.04; part < 1.01; part *= 1.6)
            model.add(crank(1000 * part, 40), beyond(crank(1000 * part, 40), T, 2 * um));
        for (const double length : {25.0, 40.0, 60.0})
            for (const double acceleration : {200.0, 600.0, 1000.0}) {
                const auto wanted = crank(acceleration, length);
                const auto its = model.predict(wanted, unit);
                const double truth = beyond(wanted, T, 2 * um);
                EXPECT_LE(std::abs(its.beyond - truth), its.doubt) << T << " " << length;
                EXPECT_NEAR(its.beyond, truth, 0.05 * std::abs(truth) + um) << T << " " << length;
                if (length == 40 && acceleration < 1000) {
                    EXPECT_LT(its.doubt, 0.2 * std::abs(truth) + 20 * um) << T << " " << acceleration;
                }
            }
    }
}

TEST(OvershootModel, FewStrokesGiveAWidePrediction) {
    OvershootModel model;
    EXPECT_TRUE(model.empty());
    model.add(crank(200, 40), -0.1);
    const auto wide = model.predict(crank(1000, 40), unit);
    EXPECT_GT(wide.doubt, 0.3 * std::abs(wide.beyond));
    const auto like = model.predict(crank(200, 40), unit);
    EXPECT_NEAR(like.beyond, -0.1, um);
    EXPECT_LT(like.doubt, 20 * um);
}

TEST(OvershootModel, ALikeStrokeReplacesTheOldOneAndAnotherShapeIsDoubted) {
    OvershootModel model;
    model.add(crank(1000, 40), -0.5);
    model.add(crank(1001, 40), -0.2);
    EXPECT_NEAR(model.predict(crank(1000, 40), unit).beyond, -0.2, um);
    const double like = model.predict(crank(1000, 40), unit).doubt;
    const auto capped = model.predict({1000, 1000, 40, 0.5}, unit);
    EXPECT_GT(capped.doubt, like + 0.2 * 0.2);
    model.forget();
    EXPECT_TRUE(model.empty());
}

// A climb brakes by less than it accelerates with.
TEST(OvershootModel, StrokesThatBrakeGentlyPredictOneThatDoesNot) {
    OvershootModel model;
    const auto turn = [](const OvershootModel::Turn& its) {
        return -2e-4 * its.acceleration - 5e-5 * its.leaving;
    };
    for (double level = 64; level < 700; level *= 1.6) {
        const OvershootModel::Turn its{level / 1.6, level, 40, 1};
        model.add(its, turn(its));
    }
    model.add(crank(40, 40), turn(crank(40, 40)));
    const auto its = model.predict(crank(700, 40), unit);
    EXPECT_NEAR(its.beyond, -0.175, 0.025);
    EXPECT_LE(std::abs(its.beyond + 0.175), its.doubt);
}

TEST(OvershootModel, CoversTheFrequenciesOfItsTurnsAndTheLowerOnes) {
    OvershootModel model;
    EXPECT_FALSE(model.covers(1, 100));
    model.add({1000, 1000, 50, 1}, -0.2);
    model.add({500, 500, 50, 1}, -0.1);
    EXPECT_TRUE(model.covers(1000, 50));
    EXPECT_TRUE(model.covers(1500, 100));
    EXPECT_TRUE(model.covers(1050, 50)) << "nearly";
    EXPECT_FALSE(model.covers(1200, 50));
    EXPECT_FALSE(model.covers(900, 25)) << "less acceleration, but quicker";
}

TEST(OvershootModel, NothingImpossibleIsAdded) {
    OvershootModel model;
    for (const double bad : {0.0, -1.0, std::nan("")}) {
        model.add({bad, 1, 40, 1}, 0);
        model.add({1, 1, bad, 1}, 0);
        model.add({1, 1, 40, bad}, 0);
        if (std::isnan(bad)) model.add(crank(1, 40), bad);
    }
    EXPECT_TRUE(model.empty());
    for (int i = 1; i < 100; ++i) model.add(crank(10 * i, 40), -1e-4 * i);
    EXPECT_TRUE(std::isfinite(model.predict(crank(900, 40), unit).beyond));
}

}  // namespace
}  // namespace plumb
