// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/volume/volume_readings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3, minute = 60;

TEST(CircleTurn, IsTheLawOfTheTurn) {
    const CircleTurn slow{10 * um, 0.5 * um, 125}, fast{10 * um, 0.5 * um, 500};
    EXPECT_NEAR(slow.kept(1000 / minute, 150), 1.2 * um, 0.05 * um);
    EXPECT_NEAR(slow.kept(3000 / minute, 50), 4.7 * um, 0.05 * um);
    EXPECT_NEAR(fast.kept(3000 / minute, 50), 2.6 * um, 0.05 * um);
    EXPECT_NEAR(slow.kept(5000 / minute, 25), 7.9 * um, 0.1 * um);
    EXPECT_LT(slow.kept(1e4, 1), 10 * um) << "never more than the lost motion";
}

TEST(CircleTurn, FeedIsTheOneThatKeepsWhatIsAllowed) {
    const CircleTurn turn{12 * um, 0.5 * um, 125};
    for (const double radius : {10.0, 50.0, 150.0}) {
        const double speed = turn.speed_for(3 * um, radius);
        EXPECT_NEAR(turn.kept(speed, radius), 3 * um, 1e-6 * um);
        EXPECT_GT(turn.kept(1.01 * speed, radius), 3 * um);
    }
    EXPECT_EQ(turn.speed_for(0.1 * um, 50), 0) << "reversal-distance alone is more";
}

// Play that is taken up behind a motor whose command turns at rest, an acceleration-limited step added to it
// after reversal-distance: the largest distance from the ideal place.
double simulated(double lost, double distance, double a, double an) {
    const double dt = 1e-5, begin = std::sqrt(2 * distance / an), half = std::sqrt(lost / a);
    double lowest = 1e9, worst = 0, first = 0;
    for (int n = 0; n * dt < begin + 2 * half + 3 * std::sqrt(2 * lost / std::min(a, an)); ++n) {
        const double t = n * dt, u = std::max(0.0, t - begin), left = std::max(0.0, 2 * half - u);
        const double step = u < half ? a * u * u / 2 : lost - a * left * left / 2;
        const double ideal = -an * t * t / 2, motor = ideal + lost / 2 - step;
        if (n == 0) first = motor - lost / 2;
        lowest = std::min(lowest, motor + lost / 2);
        worst = std::max(worst, std::abs(std::min(first, lowest) - ideal));
    }
    return worst;
}

TEST(CircleTurn, IsThatOfAPlayWithAStepThatTakesTime) {
    for (const double an : {2.0, 10.0, 30.0, 60.0, 120.0, 200.0, 500.0, 2000.0})
        for (const double lost : {1 * um, 4 * um, 15 * um}) {
            const CircleTurn turn{lost, 0.5 * um, 125};
            EXPECT_NEAR(turn.kept(std::sqrt(an * 50), 50), simulated(lost, 0.5 * um, 125, an),
                        0.05 * lost + 0.1 * um)
                << an;
        }
}

}  // namespace
}  // namespace plumb
