// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/plants/sample_and_hold.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace plumb {
namespace {

struct Sample {
    double value, since;
};

std::vector<Sample> samples_of_a_ramp(double delay, double T, double dt, double until) {
    SampleAndHold hold(delay);
    std::vector<Sample> samples;
    for (int i = 1; i * dt <= until + 1e-9; ++i)
        hold.step(i * dt, T, dt, [&](double u, double since) {
            samples.push_back({u, since});
            return u;
        });
    return samples;
}

TEST(SampleAndHold, SamplesByItsOwnClockBetweenThePeriods) {
    // The signal is the time, so each sample shows when it was taken.
    const std::vector<Sample> samples = samples_of_a_ramp(0.0033, 0.0081, 0.001, 1);
    ASSERT_EQ(samples.size(), 124u);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        EXPECT_NEAR(samples[i].value, 0.0033 + 0.0081 * static_cast<double>(i), 1e-12);
        EXPECT_NEAR(samples[i].since, i > 0 ? 0.0081 : 0.0033, 1e-12);
    }
}

TEST(SampleAndHold, SamplesAreTheSameForAnyThreadPeriod) {
    const std::vector<Sample> fine = samples_of_a_ramp(0.001, 0.01, 0.0005, 1);
    const std::vector<Sample> coarse = samples_of_a_ramp(0.001, 0.01, 0.004, 1);
    ASSERT_EQ(fine.size(), coarse.size());
    for (std::size_t i = 0; i < fine.size(); ++i) EXPECT_NEAR(fine[i].value, coarse[i].value, 1e-12);
}

TEST(SampleAndHold, HoldsBetweenSamples) {
    SampleAndHold hold(0.125);
    const auto same = [](double u, double) { return u; };
    EXPECT_EQ(hold.step(5, 1, 0.125, same), 5);
    for (int i = 0; i < 7; ++i) EXPECT_EQ(hold.step(100, 1, 0.125, same), 5);
    EXPECT_EQ(hold.step(200, 1, 0.125, same), 200);
}

TEST(SampleAndHold, WithoutATimeEveryPeriodIsASample) {
    SampleAndHold hold(3);
    for (int i = 0; i < 5; ++i)
        EXPECT_EQ(hold.step(i, 0, 0.1,
                            [](double u, double since) {
                                EXPECT_NEAR(since, 0.1, 1e-12);
                                return u;
                            }),
                  i);
}

TEST(SampleAndHold, GoesOnAtOnceWhenItsTimeIsShortenedAgain) {
    SampleAndHold hold(0);
    const auto same = [](double u, double) { return u; };
    hold.step(1, 1e9, 0.001, same);
    hold.step(1, 1e9, 0.001, same);
    for (int i = 0; i < 20; ++i) hold.step(2, 0.008, 0.001, same);
    EXPECT_EQ(hold.value(), 2);
}

}  // namespace
}  // namespace plumb
