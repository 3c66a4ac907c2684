// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_curve.hpp"
#include "components/compensation/thermal_growth/probed_growth.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using Eigen::VectorXd;

constexpr double um = 1e-3;
constexpr double hour = 3600;

// A machine that is tested for some hours, and the truth about it.
struct Drawn {
    VectorXd t, y;
    double steady = 0, rate = 0;
};

// Passes at even times; each part grows by b (1 - exp(-t / tau)).
Drawn drawn(Random& random, std::initializer_list<std::pair<double, double>> parts, double noise) {
    Drawn its;
    const int count = 6 + random.index(8);
    const double span = random.uniform(3, 6) * hour;
    its.t = VectorXd::LinSpaced(count, 0, span);
    its.y = VectorXd::Zero(count);
    for (const auto& [b, tau] : parts) {
        its.y -= b * ((-its.t.array() / tau).exp() - 1).matrix();
        its.steady += b;
        its.rate += b / tau * std::exp(-span / tau);
    }
    for (double& y : its.y) y += noise * random.gaussian();
    return its;
}

// The parts of a machine of so many time constants, whose slow ones may act against the quick one.
Drawn machine(Random& random, int constants, double noise) {
    const double b = random.uniform(20, 60) * um * (random.index(2) == 0 ? 1 : -1);
    if (constants == 1) return drawn(random, {{b, random.uniform(20, 120) * 60}}, noise);
    const double slow = b * random.uniform(-1.1, 1.1), last = b * random.uniform(-0.6, 0.6);
    const std::pair<double, double> first{b, random.uniform(5, 25) * 60};
    if (constants == 2) return drawn(random, {first, {slow, random.uniform(1.2, 3) * hour}}, noise);
    return drawn(random, {first, {slow, random.uniform(0.5, 1) * hour}, {last, random.uniform(2, 4) * hour}},
                 noise);
}

struct Curve : testing::TestWithParam<int> {};

TEST_P(Curve, CoversSteadyStateAndRateOfMachinesWithSeveralTimeConstants) {
    Random random(static_cast<std::uint64_t>(40 + GetParam()));
    constexpr int machines = 120;
    int steady = 0, rate = 0;
    for (int i = 0; i < machines; ++i) {
        const Drawn its = machine(random, GetParam(), 1 * um);
        const auto curve = fit_growth_curve(its.t, its.y, 1 * um);
        ASSERT_TRUE(curve);
        steady += curve->low() <= its.steady && its.steady <= curve->high();
        rate += std::abs(curve->rate - its.rate) <= 2 * curve->rate_sigma;
    }
    EXPECT_GE(steady, 0.92 * machines);
    EXPECT_GE(rate, 0.92 * machines);
}

INSTANTIATE_TEST_SUITE_P(TimeConstants, Curve, testing::Values(1, 2, 3));

TEST(GrowthCurve, FourPassesDoNotPretendToKnowTheNoise) {
    Random random(7);
    double square = 0;
    constexpr int tests = 100;
    for (int i = 0; i < tests; ++i) {
        VectorXd t = VectorXd::LinSpaced(4, 0, 1.5 * hour), y(4);
        for (int k = 0; k < 4; ++k) y[k] = -40 * um * std::expm1(-t[k] / 2400) + 1.2 * um * random.gaussian();
        const auto curve = fit_growth_curve(t, y, 1 * um);
        ASSERT_TRUE(curve);
        EXPECT_GT(curve->noise, 0.5 * um);
        EXPECT_LT(curve->freedom, 5);
        EXPECT_FALSE(curve->determined);
        square += curve->noise * curve->noise;
    }
    EXPECT_NEAR(std::sqrt(square / tests), 1.2 * um, 0.4 * um);
}

TEST(GrowthCurve, FindsTheNoiseOfManyPasses) {
    Random random(8);
    for (const double noise : {0.4, 1.0, 2.5}) {
        VectorXd t = VectorXd::LinSpaced(40, 0, 6 * hour), y(40);
        for (int k = 0; k < 40; ++k)
            y[k] = -50 * um * std::expm1(-t[k] / 2000) + 20 * um * std::expm1(-t[k] / 9000) +
                   noise * um * random.gaussian();
        const auto curve = fit_growth_curve(t, y, 1 * um);
        EXPECT_NEAR(curve->noise, noise * um, 0.3 * noise * um);
        EXPECT_GT(curve->freedom, 10);
    }
}

TEST(GrowthCurve, DriftWithoutEndIsARateAndNoSteadyState) {
    const VectorXd t = VectorXd::LinSpaced(9, 0, 4 * hour);
    const VectorXd y = -30 * um * ((-t.array() / 1500).exp() - 1) + t.array() * (2 * um / hour);
    const auto curve = fit_growth_curve(t, y, 0.5 * um);
    ASSERT_TRUE(curve);
    EXPECT_NEAR(curve->rate * hour, 2 * um, 2 * curve->rate_sigma * hour);
    EXPECT_GT(curve->rate, 2 * curve->rate_sigma);
    EXPECT_GT(curve->high(), 45 * um);  // far above the last value, 38 um
}

TEST(GrowthCurve, ExtremumThatTurnsIsNoSteadyState) {
    const VectorXd t = VectorXd::LinSpaced(11, 0, 320.0 * 60);
    const VectorXd y = 60 * um * ((-t.array() / 3000).exp() - (-t.array() / 20000).exp());
    ASSERT_LT(y.minCoeff(), -36 * um);
    const auto curve = fit_growth_curve(t, y, 0.5 * um);
    ASSERT_TRUE(curve);
    EXPECT_GT(curve->rate, 2 * curve->rate_sigma);  // back, while y is negative
    EXPECT_LT(curve->low(), 0);
    EXPECT_GT(curve->high(), -6 * um);
}

// A record of gauges: two or three exponentials, a shop that swings over the day, a noise whose readings
// repeat a part of the one before, and a display of few digits. Without `shop`: one to three exponentials,
// and no swing.
Drawn record(Random& random, int number, bool shop) {
    Drawn its;
    const double span = random.uniform(2.5, 8) * hour;
    const auto count = static_cast<Eigen::Index>(std::min(150.0, span / 60));
    its.t = VectorXd::LinSpaced(count, 0, span);
    its.y = VectorXd::Zero(count);
    double tau = random.uniform(4, 25) * 60;
    for (int j = shop ? 0 : number % 2; j < 2 + number % 2; ++j) {
        const double b = random.uniform(5, 40) * um * (random.index(4) == 0 ? -1 : 1);
        its.y -= b * ((-its.t.array() / tau).exp() - 1).matrix();
        its.steady += b;
        tau = std::min(tau * random.uniform(2.5, 8), 4 * hour);
    }
    const double repeats = std::vector<double>{0, 0.5, 0.8, 0.95}[static_cast<std::size_t>(random.index(4))];
    const double size = random.uniform(0.1, 0.8) * um * std::sqrt(1 - repeats * repeats);
    const double swing = shop ? random.uniform(0, 2) * um : 0, phase = random.uniform(0, 6.28);
    const double digit = std::vector<double>{1e-3, 0.1, 1}[static_cast<std::size_t>(random.index(3))] * um;
    double noise = 0;
    for (Eigen::Index k = 0; k < count; ++k) {
        noise = repeats * noise + size * random.gaussian();
        const double y = its.y[k] + noise + swing * std::sin(6.2831853 * its.t[k] / 86400 + phase);
        its.y[k] = digit * std::round(y / digit);
    }
    return its;
}

// For a table of many, as in the README: GROWTH_CURVES=200 GROWTH_SEED=9001 build/tests/math_tests
// --gtest_filter='GrowthCurve.Records*'
double number(const char* name, double otherwise) {
    const char* text = std::getenv(name);
    return text ? std::stod(text) : otherwise;
}

TEST(GrowthCurve, RecordsOfGaugesCoverTheSteadyStateWithoutMuchToSpare) {
    const auto records = static_cast<int>(number("GROWTH_CURVES", 40));
    for (const bool shop : {false, true}) {
        Random random(static_cast<std::uint64_t>(number("GROWTH_SEED", 1)), shop ? 1 : 0);
        int covered = 0, shorter = 0, reached = 0;
        double square = 0;
        std::vector<double> halves;
        for (int i = 0; i < records; ++i) {
            const Drawn its = record(random, i, shop);
            const auto curve = fit_growth_curve(its.t, its.y);
            ASSERT_TRUE(curve);
            covered += curve->low() <= its.steady && its.steady <= curve->high();
            square += std::pow(curve->steady - its.steady, 2);
            halves.push_back(2 * curve->steady_sigma);
            if (!curve->shorter) continue;
            const double last = its.y[its.y.size() - 1], rises = curve->steady > last ? 1 : -1;
            ++shorter;
            reached +=
                rises * its.steady >=
                std::max(rises * last, rises * curve->steady - 2 * curve->steady_sigma) - 2 * curve->noise;
        }
        std::sort(halves.begin(), halves.end());
        const double half = halves[halves.size() / 2], error = std::sqrt(square / records);
        std::printf(
            "%s: covered %.1f %%, median half width %.2f um, rms error %.2f um; 'at least' %d, true %d\n",
            shop ? "with the swing of a shop" : "without it", 100.0 * covered / records, half / um,
            error / um, shorter, reached);
        EXPECT_GE(covered, 0.87 * records);  // 90 in the mean of many
        EXPECT_LE(half, 2 * error);
        EXPECT_GE(reached, 0.8 * shorter);
    }
}

TEST(GrowthCurve, AnExactExponentialIsFound) {
    const VectorXd t = VectorXd::LinSpaced(241, 0, 4 * hour);
    const auto curve = fit_growth_curve(t, (-48 * um * ((-t.array() / 2400).exp() - 1)).matrix());
    EXPECT_NEAR(curve->steady, 48 * um, 0.3 * um);
    EXPECT_LT(2 * curve->steady_sigma, 2 * um);
    EXPECT_TRUE(curve->determined);
}

TEST(GrowthCurve, ARecordShorterThanTwoTimeConstantsIsNotDetermined) {
    Random random(5);
    VectorXd t = VectorXd::LinSpaced(91, 0, 1.5 * hour), y(91);
    for (int k = 0; k < 91; ++k)
        y[k] = -60 * um * std::expm1(-t[k] / (1.5 * hour)) + 0.2 * um * random.gaussian();
    const auto curve = fit_growth_curve(t, y);
    EXPECT_TRUE(curve->shorter);
    EXPECT_FALSE(curve->determined);
    EXPECT_GT(curve->high(), 55 * um);
}

TEST(GrowthCurve, ShiftAndScaleOfTheValuesShiftAndScaleTheResult) {
    const VectorXd t = VectorXd::LinSpaced(9, 0, 4 * hour);
    const VectorXd y = -30 * um * ((-t.array() / 3000).exp() - 1);
    const auto one = fit_growth_curve(t, y), other = fit_growth_curve(t.array() + 500, 1000 * y.array() + 7);
    ASSERT_TRUE(one && other);
    EXPECT_NEAR(other->steady, 1000 * one->steady + 7, 1e-6);
    EXPECT_NEAR(other->steady_sigma, 1000 * one->steady_sigma, 1e-6);
    EXPECT_NEAR(one->steady, 30 * um, 1 * um);
}

TEST(GrowthCurve, TooFewValuesOneTimeOrNoNumbersGiveNothing) {
    EXPECT_FALSE(fit_growth_curve(VectorXd::LinSpaced(4, 0, 1), VectorXd::Ones(4)));
    EXPECT_FALSE(fit_growth_curve(VectorXd::Ones(1), VectorXd::Ones(1), 1 * um));
    EXPECT_FALSE(fit_growth_curve(VectorXd::Ones(8), VectorXd::Ones(8)));
    EXPECT_FALSE(fit_growth_curve(VectorXd::LinSpaced(8, 0, 1), VectorXd::Constant(8, NAN)));
}

// A test of a machine: temperatures each minute, a pass each half hour.
struct Stop : testing::Test {
    StopRule rule;
    StopRule::Settings settings;

    Stop() {
        settings.sensors = 3;
        settings.threshold = 0.5;
        settings.interval = hour;
        settings.range_floor = 2 * um;
        settings.uncertainty = 0.7 * um;
        settings.minimum_time = 2 * hour;
        settings.maximum_time = 20 * hour;
    }

    template <class Temperature, class Drift>
    double stopped(Temperature temperature, Drift drift, double pass = hour / 2) {
        double next = 0;
        for (double t = 0; t <= 21 * hour; t += 60) {
            rule.sample(t, 0, temperature(t));
            rule.sample(t, 1, 20);
            if (t >= next) {
                next += pass;
                rule.deviation(t, 2, drift(t));
                rule.cycle_ends(t);
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
        for (const std::size_t sensor : {0, 1}) rule.sample(t, sensor, 20);
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
