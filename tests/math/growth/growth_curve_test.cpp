// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/random.hpp"
#include "components/math/growth/exponential_fit.hpp"
#include "components/math/growth/stop_rule.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

using Eigen::VectorXd;

constexpr double um = 1e-3;
constexpr double hour = 3600;

TEST(ExponentialFit, FindsACurveWithoutNoise) {
    const VectorXd t = VectorXd::LinSpaced(13, 0, 4 * hour);
    const VectorXd y = (2 - 45 * ((-t.array() / 4000).exp() - 1)) * um;
    const auto fit = fit_exponential(t, y);
    ASSERT_TRUE(fit);
    EXPECT_TRUE(fit->determined);
    EXPECT_NEAR(fit->steady, 47 * um, 0.1 * um);
    EXPECT_NEAR(fit->tau, 4000, 40);
    EXPECT_NEAR(fit->a, 2 * um, 0.1 * um);
    EXPECT_NEAR(fit->time_to_95, 4000 * std::log(20), 150);
    EXPECT_NEAR(fit->rate, 45 * um / 4000 * std::exp(-4 * hour / 4000), 0.02 * um / 4000);
}

TEST(ExponentialFit, TwoUncertaintiesCoverTheSteadyState) {
    Random random(3);
    int covered = 0, determined = 0;
    constexpr int curves = 400;
    for (int i = 0; i < curves; ++i) {
        const int count = 8 + random.index(12);
        const double span = random.uniform(2, 6) * hour, tau = span * random.uniform(0.1, 1.2);
        const double a = random.uniform(-3, 3) * um, b = random.uniform(-70, 70) * um;
        VectorXd t(count), y(count);
        for (int k = 0; k < count; ++k) {
            t[k] = span * k / (count - 1);
            y[k] = a - b * std::expm1(-t[k] / tau) + 0.7 * um * random.gaussian();
        }
        const auto fit = fit_exponential(t, y);
        ASSERT_TRUE(fit);
        if (!fit->determined) continue;
        ++determined;
        if (std::abs(fit->steady - (a + b)) <= 2 * fit->steady_uncertainty()) ++covered;
        EXPECT_LE(fit->steady_low, fit->steady);
        EXPECT_GE(fit->steady_high, fit->steady);
    }
    EXPECT_GE(determined, curves / 2);
    EXPECT_GE(covered, 0.9 * determined);
}

TEST(ExponentialFit, StraightLineHasNoSteadyState) {
    const VectorXd t = VectorXd::LinSpaced(12, 0, 4 * hour);
    const auto fit = fit_exponential(t, t * (10 * um / hour), 0.7 * um);
    ASSERT_TRUE(fit);
    EXPECT_FALSE(fit->determined);
    EXPECT_TRUE(std::isinf(fit->steady_uncertainty()));
}

TEST(ExponentialFit, TooFewValuesOneTimeOrNoNumbersGiveNothing) {
    EXPECT_FALSE(fit_exponential(VectorXd::LinSpaced(4, 0, 1), VectorXd::Ones(4)));
    EXPECT_FALSE(fit_exponential(VectorXd::Ones(8), VectorXd::Ones(8)));
    EXPECT_FALSE(fit_exponential(VectorXd::LinSpaced(8, 0, 1), VectorXd::Constant(8, NAN)));
}

// A test of a machine: temperatures each minute, a pass each half hour.
struct Stop : testing::Test {
    StopRule rule;
    StopRule::Settings settings;

    Stop() {
        settings.sensors = 3;
        settings.minimum_time = 2 * hour;
        settings.maximum_time = 20 * hour;
    }

    template <class Temperature, class Drift>
    double stopped(Temperature temperature, Drift drift, double pass = hour / 2) {
        double next = 0;
        for (double t = 0; t <= 21 * hour; t += 60) {
            StopRule::Temperatures now;
            now.fill(NAN);
            now[0] = temperature(t);
            now[1] = 20;
            rule.sample(t, now, settings);
            if (t >= next) {
                next += pass;
                rule.deviation(t, 2, drift(t));
                rule.cycle_ends(t, settings);
                if (rule.reason(t, settings) != StopReason::none) return t;
            }
        }
        return HUGE_VAL;
    }
};

const auto warming = [](double t) { return 20 - 12 * std::expm1(-t / 3000); };
const auto growing = [](double t) { return -60 * um * std::expm1(-t / 7200); };
const auto still = [](double) { return 0.0; };

TEST_F(Stop, ComesWhenTheTemperaturesStand) {
    settings.by_displacement = false;
    const double stop = stopped(warming, growing);
    // 12 K exp(-(t - interval) / τ) (1 - exp(-interval / τ)) = 0.5 K
    const double exact = hour + 3000 * std::log(12 * -std::expm1(-hour / 3000) / 0.5);
    EXPECT_GE(stop, exact);
    EXPECT_LE(stop, exact + hour / 2 + 60);
}

TEST_F(Stop, NeverComesBeforeTheMinimumTime) {
    settings.minimum_time = 9 * hour;
    EXPECT_GE(stopped([](double) { return 20.0; }, still), 9 * hour);
}

TEST_F(Stop, WaitsForTheDisplacementWhileTheTemperaturesStand) {
    settings.sensors = 2;  // of the air
    const double stop = stopped(warming, growing);
    const double range_first = 60 * um * -std::expm1(-hour / 7200.0);
    const double range_last = growing(stop) - growing(stop - hour);
    EXPECT_LE(range_last, 0.15 * range_first + 1e-9);
    EXPECT_GT(stop, 3 * hour);
    EXPECT_LT(stop, 7 * hour);
}

TEST_F(Stop, OfTheSourceComesAfterTwoCyclesAtItsCoarsestThreshold) {
    settings.by_displacement = false;
    settings.interval = 0;
    settings.minimum_time = 0;
    settings.threshold = 5;
    EXPECT_EQ(stopped([](double t) { return 20 - 12 * std::expm1(-t / 7200); }, growing), hour / 2);
    EXPECT_EQ(rule.cycles(), 2);
}

TEST_F(Stop, TakesAnyThresholdAboveZeroAndCallsUnusualOnesSo) {
    for (const double threshold : {0.01, 0.5, 5.0, 40.0}) {
        settings.threshold = threshold;
        EXPECT_TRUE(settings.valid());
        EXPECT_EQ(settings.usual(), threshold >= 0.5 && threshold <= 5);
    }
    for (const double threshold : {0.0, -1.0, static_cast<double>(NAN)}) {
        settings.threshold = threshold;
        EXPECT_FALSE(settings.valid());
    }
}

TEST_F(Stop, NeedsTwoHoursOfDisplacements) {
    settings.minimum_time = 0;
    settings.interval = 600;
    EXPECT_GE(stopped([](double) { return 20.0; }, still, 600), 2 * hour);
}

TEST_F(Stop, ComparesCyclesAtTheirEndsNotWithinThem) {
    settings.by_displacement = false;
    const auto sawtooth = [](double t) { return warming(t) + 4 * std::sin(t * 3.14159265358979 / 1500); };
    const double stop = stopped(sawtooth, growing, 3000);  // cycles of 50 min, an interval of 60
    EXPECT_LT(stop, 6 * hour);
}

TEST_F(Stop, LostSensorDecidesNothing) {
    settings.by_displacement = false;
    EXPECT_EQ(stopped([](double t) { return t > hour ? NAN : 20.0; }, still), settings.maximum_time);
    EXPECT_EQ(rule.reason(settings.maximum_time, settings), StopReason::maximum_time);
}

TEST_F(Stop, WithoutADeviationTheSecondRuleNeverHolds) {
    for (double t = 0; t <= 10 * hour; t += 60) {
        StopRule::Temperatures now;
        now.fill(20);
        rule.sample(t, now, settings);
    }
    EXPECT_EQ(rule.reason(10 * hour, settings), StopReason::none);
    settings.by_displacement = false;
    EXPECT_EQ(rule.reason(10 * hour, settings), StopReason::stable);
}

TEST_F(Stop, ClearForgetsTheTestBefore) {
    const double first = stopped(warming, growing);
    rule.clear();
    EXPECT_EQ(stopped(warming, growing), first);
}

}  // namespace
}  // namespace plumb
