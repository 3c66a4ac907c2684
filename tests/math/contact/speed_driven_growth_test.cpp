// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/contact/speed_driven_growth.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3;  // mm
constexpr double exact = 1e-12;
constexpr double tau = 600;  // s

SpeedDrivenGrowth::Prior prior() {
    return {15 * um, 0.1 * um, 3 * um};
}

SpeedDrivenGrowth started() {
    SpeedDrivenGrowth filter;
    filter.start(prior());
    return filter;
}

TEST(SpeedDrivenGrowth, FollowsTheExponentialOfItsLagForAnyPeriod) {
    for (const double dt : {0.001, 0.1, 60.0}) {
        SpeedDrivenGrowth filter = started();
        for (int i = 0; i < std::lround(tau / dt); ++i) filter.step(2, tau, dt);
        EXPECT_NEAR(filter.growth(), 15 * um * 2 * (1 - std::exp(-1)), 1e-6 * um) << dt;
    }
}

TEST(SpeedDrivenGrowth, DoubtIsThatOfThePriorForEachPart) {
    SpeedDrivenGrowth filter = started();
    const double bias = 30 * um, heat = 10 * um;
    EXPECT_NEAR(filter.variance(), bias * bias + heat * heat, exact);
    filter.temperature(2);
    EXPECT_NEAR(filter.variance(), bias * bias + heat * heat + 6 * um * 6 * um, exact);
}

TEST(SpeedDrivenGrowth, AContactWeighsByHowMuchIsInDoubt) {
    SpeedDrivenGrowth filter = started();
    const double before = filter.growth(), doubt = filter.variance(), noise = 9 * um * 9 * um;
    filter.correct(20 * um, noise);
    EXPECT_NEAR(filter.growth() - before, (20 * um - before) * doubt / (doubt + noise), exact);
    EXPECT_NEAR(filter.variance(), doubt * noise / (doubt + noise), exact);
}

TEST(SpeedDrivenGrowth, LikelihoodIsThatOfTheNormalDistribution) {
    SpeedDrivenGrowth filter = started(), other = started();
    const double sum = filter.variance() + um * um;
    const double near = filter.correct(0, um * um), far = other.correct(50 * um, um * um);
    EXPECT_NEAR(near - far, 0.5 * 50 * um * 50 * um / sum, 1e-9);
}

// A machine of the filter's own kind, warm at the start.
TEST(SpeedDrivenGrowth, LearnsGainAndHeatAtTheStart) {
    SpeedDrivenGrowth filter;
    filter.start({15 * um, 0.01 * um, 0});
    double spindle = 12 * um;
    const double at_start = spindle;
    const auto run = [&](double u, int minutes, bool contacts) {
        for (int i = 0; i < 60 * minutes; ++i) {
            filter.step(u, tau, 1);
            spindle += (40 * um * u - spindle) * -std::expm1(-1 / tau);
            filter.wander(1);
            if (contacts && i % 300 == 0) filter.correct(spindle - at_start, 0.1 * um * 0.1 * um);
        }
    };
    run(1, 30, true);
    run(0.2, 40, true);
    run(1.5, 30, false);
    EXPECT_NEAR(filter.growth(), spindle - at_start, 1 * um);
}

TEST(SpeedDrivenGrowth, LearnsTheGrowthByATemperature) {
    SpeedDrivenGrowth filter = started();
    for (int i = 0; i < 24; ++i) {
        const double T = 2 * std::sin(i * 0.5);
        filter.temperature(T);
        filter.step(0, tau, 300);
        filter.correct(4 * um * T, 0.1 * um * 0.1 * um);
    }
    filter.temperature(3);
    EXPECT_NEAR(filter.growth(), 12 * um, 1 * um);
}

TEST(SpeedDrivenGrowth, WanderWidensTheBiasAndNothingEverMoreThanAtTheStart) {
    SpeedDrivenGrowth filter = started();
    for (int i = 0; i < 100; ++i) filter.correct(0, 1e-6 * um * um);
    const double sure = filter.variance();
    filter.wander(100);
    EXPECT_NEAR(filter.variance() - sure, 100 * 0.1 * um * 0.1 * um, exact);
    const double start = started().variance();
    for (int days = 0; days < 100; ++days)
        for (int hours = 0; hours < 24; ++hours) filter.wander(3600);
    EXPECT_LE(filter.variance(), start + 3600 * 0.1 * um * 0.1 * um);
}

TEST(SpeedDrivenGrowth, AForgottenBiasTakesTheNextContactAsItIs) {
    SpeedDrivenGrowth filter = started();
    for (int i = 0; i < 20; ++i) filter.correct(0, um * um);
    filter.forget_bias();
    filter.correct(50 * um, um * um);
    EXPECT_NEAR(filter.growth(), 50 * um, 0.2 * um);
}

}  // namespace
}  // namespace plumb
