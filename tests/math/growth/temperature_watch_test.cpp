// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/temperature_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

using PerSensor = TemperatureWatch::PerSensor;

// Spindle, bed and air: the spindle rises by 9 K and the bed by 3 K at the reference speed.
TemperatureWatch::Settings three() {
    TemperatureWatch::Settings its;
    its.limit = {1, 1, 1, 0};
    its.fast = {9 - 1.5, 3 - 4.5, -6, 0};
    its.low = {0, -1.5, -6, 0};
    its.high = {7.5, 0, 0, 0};
    its.slow_time = 100;
    return its;
}

PerSensor warm(double x, double shop = 0) {
    return {9 * x + shop, 3 * x + shop, shop, 0};
}

int named(PerSensor rises, double x, const TemperatureWatch::Settings& settings = three()) {
    TemperatureWatch watch;
    watch.step(PerSensor::Zero(), true, 0, 0, settings, 1);
    watch.step(rises, true, x, 0, settings, 1);
    return watch.named();
}

TEST(TemperatureWatch, AWarmMachineInAWarmShopIsNoFault) {
    EXPECT_EQ(named(warm(1), 1), -1);
    EXPECT_EQ(named(warm(1, 8), 1), -1) << "all sensors together";
    EXPECT_EQ(named(warm(1), 0.95), -1) << "within the limits";
}

TEST(TemperatureWatch, NamesTheSensorThatIsWrong) {
    for (int sensor = 0; sensor < 3; ++sensor)
        for (const double error : {-3.0, 1.5, 20.0, 80.0}) {
            PerSensor rises = warm(0.7, 2);
            rises[sensor] += error;
            EXPECT_EQ(named(rises, 0.7), sensor) << error;
        }
}

TEST(TemperatureWatch, SwappedSensorsShowWarm) {
    const auto swapped = [](double x) {
        PerSensor rises = warm(x);
        std::swap(rises[0], rises[1]);
        return rises;
    };
    EXPECT_EQ(named(swapped(0), 0), -1) << "cold they agree";
    EXPECT_GE(named(swapped(0.5), 0.5), 0);
}

TEST(TemperatureWatch, TwoSensorsThatContradictEachOtherAreBothInDoubt) {
    TemperatureWatch::Settings settings = three();
    settings.limit[2] = 0;
    settings.fast = {6, -6, 0, 0};
    TemperatureWatch watch;
    watch.step(PerSensor::Zero(), true, 0, 0, settings, 1);
    watch.step({20, 3, 0, 0}, true, 1, 0, settings, 1);
    EXPECT_TRUE(watch.doubts(0, settings));
    EXPECT_TRUE(watch.doubts(1, settings));
    EXPECT_FALSE(watch.doubts(2, settings));
}

TEST(TemperatureWatch, AMachineThatIsWarmAtTheStartIsNoFaultUntilItsWarmthMustHaveGone) {
    TemperatureWatch watch;
    const TemperatureWatch::Settings settings = three();
    double left = 1;
    for (int second = 0; second < 400; ++second) {
        watch.step(warm(0.8 * left), true, 0, 0, settings, 1);
        EXPECT_EQ(watch.named(), -1) << second;
        left *= std::exp(-1 / settings.slow_time);
    }
    watch = {};
    for (int second = 0; second < 400; ++second) watch.step(warm(0.8), true, 0, 0, settings, 1);
    EXPECT_GE(watch.named(), 0) << "it does not cool";
}

TEST(TemperatureWatch, ASensorThatIsFarOffAtTheStartIsNoWarmMachine) {
    TemperatureWatch watch;
    PerSensor rises = warm(0.5);
    rises[1] += 20;
    watch.step(rises, true, 0, 0, three(), 1);
    EXPECT_EQ(watch.named(), 1);
}

TEST(TemperatureWatch, HoldsItsJudgementWhileASensorIsLostAndTakesItBackInsideOfTheLimits) {
    TemperatureWatch watch;
    const TemperatureWatch::Settings settings = three();
    watch.step(PerSensor::Zero(), true, 0, 0, settings, 1);
    watch.step({4, 0, 0, 0}, true, 0, 0, settings, 1);
    ASSERT_EQ(watch.named(), 0);
    watch.step(PerSensor::Zero(), false, 0, 0, settings, 1);
    EXPECT_EQ(watch.named(), 0);
    watch.step({0.95, 0, 0, 0}, true, 0, 0, settings, 1);
    EXPECT_EQ(watch.named(), 0) << "no flutter at the limit";
    watch.step({0.85, 0, 0, 0}, true, 0, 0, settings, 1);
    EXPECT_EQ(watch.named(), -1);
}

TEST(TemperatureWatch, JudgesNothingWithoutLimits) {
    EXPECT_EQ(named({80, 0, 0, 0}, 0, {}), -1);
    TemperatureWatch::Settings one;
    one.limit[0] = 1;
    EXPECT_EQ(named({80, 0, 0, 0}, 0, one), -1);
}

}  // namespace
}  // namespace plumb
