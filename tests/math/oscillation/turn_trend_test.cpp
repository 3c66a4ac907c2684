// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/oscillation/turn_trend.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3;

// Turns by `at_100` beyond its commanded end between strokes of 100 mm, and falls with a power of the length.
double beyond(double at_100, double falls, double length) {
    return at_100 * std::pow(100 / length, falls);
}

TEST(TurnTrend, AGuessErrsInwardAsTheEndGoesOutward) {
    for (const double at_100 : {-10.0, -0.2, 0.2, 3.0})
        for (const int power : {-1, 0, 1})
            for (const double more : {0.0, 0.5, 1.0}) {
                const double falls = -0.5 * power + (at_100 < 0 ? 0.5 : -0.5) + (at_100 < 0 ? -more : more);
                TurnTrend trend;
                trend.begin();
                trend.add({beyond(at_100, falls, 95), 95}, power, 0);
                EXPECT_TRUE(trend.guesses());
                const double end = trend.end(100);
                if (100 + end < 95) continue;
                EXPECT_LE(end + beyond(at_100, falls, 100 + end), 0.04 * std::abs(at_100) * more + um)
                    << at_100 << " " << power << " " << falls;
            }
}

TEST(TurnTrend, TwoTurnsGiveTheSlope) {
    for (const double at_100 : {-5.0, -0.2, 0.2, 2.0})
        for (const double falls : {0.1, 0.5, 1.0, 2.0}) {
            TurnTrend trend;
            trend.begin();
            trend.add({beyond(at_100, falls, 96), 96}, -1, 0);
            trend.add({beyond(at_100, falls, 100), 100}, -1, 0);
            EXPECT_FALSE(trend.guesses());
            EXPECT_NEAR(trend.end(100 + at_100), -at_100, 1e-9) << "strokes of 100 mm with the end";
            EXPECT_NEAR(trend.slope(), -falls * at_100 / 100, 0.15 * falls * std::abs(at_100) / 100);
        }
}

TEST(TurnTrend, ItsDoubtGrowsWithTheDistanceFromBothTurns) {
    TurnTrend trend;
    trend.begin();
    trend.add({-5, 96}, -1, 0);
    const double guessed = trend.doubt(100, 0.5);
    EXPECT_GT(guessed, 0);
    trend.add({-4.8, 100}, -1, 0);
    EXPECT_EQ(trend.doubt(100, 0.5), 0);
    EXPECT_EQ(trend.doubt(96, 0.5), 0);
    EXPECT_GT(trend.doubt(104, 0.5), trend.doubt(102, 0.5));
}

TEST(TurnTrend, ATurnOfAnotherAxisIsNotExplained) {
    TurnTrend trend;
    trend.begin();
    trend.add({-2, 100}, -1, 0);
    EXPECT_TRUE(trend.explains({-2.1, 95}, 0));
    EXPECT_TRUE(trend.explains({-1.99, 100}, 0.011));
    EXPECT_FALSE(trend.explains({-1.99, 100}, 0.009));
    EXPECT_FALSE(trend.explains({-2.5, 95}, 0.01));
}

TEST(TurnTrend, AVibrationChangesTheSlopeWithinItsBounds) {
    TurnTrend trend;
    trend.begin();
    trend.add({0.26, 20}, -1, 0);
    trend.add({0.32, 20.7}, -1, 0);
    EXPECT_NEAR(trend.slope(), 0.06 / 0.7, 1e-9);
    trend.add({5, 20.8}, -1, 0);
    EXPECT_NEAR(trend.slope(), 0.3, 1e-12);
    trend.add({5.1, 20.8}, -1, 0);
    EXPECT_NEAR(trend.slope(), 0.3, 1e-12) << "strokes of the same length show none";
}

TEST(TurnTrend, AnOvershootOfShorterStrokesIsTakenToGrowFast) {
    EXPECT_LT(TurnTrend::careful({0.3, 30}, -1), -0.029);
    EXPECT_EQ(TurnTrend::careful({-0.3, 30}, -1), TurnTrend::guess({-0.3, 30}, -1));
}

}  // namespace
}  // namespace plumb
