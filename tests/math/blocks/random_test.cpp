// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/random.hpp"

#include "tests/support/spectrum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumb {
namespace {

TEST(Random, SameSeedGivesTheSameBits) {
    Random a(7, 3), b(7, 3);
    for (int i = 0; i < 1000; ++i) ASSERT_EQ(a.bits(), b.bits());
}

TEST(Random, AnotherSeedOrStreamGivesOthersAndNoneLikeIt) {
    const auto correlation = [](Random a, Random b) {
        double sum = 0;
        constexpr int n = 100000;
        for (int i = 0; i < n; ++i) sum += (a.uniform() - 0.5) * (b.uniform() - 0.5) * 12;
        return sum / n;  // of standard deviation 1/sqrt(n) if they are independent
    };
    EXPECT_NEAR(correlation(Random(1), Random(2)), 0, 0.015);
    EXPECT_NEAR(correlation(Random(1, 1), Random(1, 2)), 0, 0.015);
    EXPECT_NEAR(correlation(Random(1, 2), Random(2, 1)), 0, 0.015);
    EXPECT_NEAR(correlation(Random(0), Random(1)), 0, 0.015);
}

TEST(Random, UniformFillsItsRangeEvenly) {
    Random random(42);
    constexpr int n = 1000000, bins = 20;
    std::vector<int> hits(bins);
    for (int i = 0; i < n; ++i) {
        const double x = random.uniform(-2, 3);
        ASSERT_GE(x, -2);
        ASSERT_LT(x, 3);
        ++hits[static_cast<std::size_t>((x + 2) / 5 * bins)];
    }
    double chi_square = 0;
    for (const int hit : hits) chi_square += std::pow(hit - n / bins, 2) / (n / bins);
    EXPECT_LT(chi_square, 43.8);  // 19 degrees of freedom: exceeded once in a thousand
    EXPECT_GT(chi_square, 5.4);   // and undercut as seldom
}

TEST(Random, IndexGivesEachOfItsNumbers) {
    Random random(5);
    std::vector<int> hits(11);
    for (int i = 0; i < 11000; ++i) ++hits[static_cast<std::size_t>(random.index(11))];
    for (const int hit : hits) EXPECT_NEAR(hit, 1000, 5 * std::sqrt(1000 * 10 / 11.));
}

TEST(Random, GaussianHasTheMomentsAndTailsOfTheNormalDistribution) {
    Random random(11);
    constexpr int n = 4000000;
    double sum = 0, squares = 0, fourths = 0, largest = 0;
    int beyond[5] = {};
    for (int i = 0; i < n; ++i) {
        const double x = random.gaussian();
        sum += x;
        squares += x * x;
        fourths += x * x * x * x;
        largest = std::max(largest, std::abs(x));
        for (int s = 1; s <= 4; ++s) beyond[s] += std::abs(x) > s;
    }
    EXPECT_NEAR(sum / n, 0, 5 / std::sqrt(n));
    EXPECT_NEAR(squares / n, 1, 0.004);
    EXPECT_NEAR(fourths / n, 3, 0.03);
    for (int s = 1; s <= 4; ++s) {
        const double expected = n * std::erfc(s / std::sqrt(2.0));
        EXPECT_NEAR(beyond[s], expected, 0.02 * expected + 5 * std::sqrt(expected)) << s << " sigma";
    }
    EXPECT_LT(largest, 8.5);
}

TEST(FlickerNoise, HasRmsOneFromTheFirstSampleOn) {
    Random random(3);
    double early = 0, late = 0;
    constexpr int n = 20000;
    for (int i = 0; i < n; ++i) {
        FlickerNoise noise(random);
        early += std::pow(noise.step(random, 0.01), 2);
        for (int k = 0; k < 20; ++k) noise.step(random, 1);
        late += std::pow(noise.step(random, 0.01), 2);
    }
    EXPECT_NEAR(early / n, 1, 0.05);
    EXPECT_NEAR(late / n, 1, 0.05);
}

TEST(FlickerNoise, ItsSpectralDensityFallsAsOneOverF) {
    Random random(9);
    FlickerNoise noise(random);
    constexpr double dt = 0.005;
    std::vector<double> samples(1 << 20);
    for (double& x : samples) x = noise.step(random, dt);
    const double slope = slope_of(spectral_density(samples, dt, 1 << 15), 0.05, 20);
    EXPECT_NEAR(slope, -1, 0.1);
}

TEST(FlickerNoise, DoesNotDependOnTheSpacingOfItsSamples) {
    const auto mean_square_change_in_a_second = [](int steps) {
        Random random(17);
        FlickerNoise noise(random);
        double before = noise.step(random, 1), sum = 0;
        constexpr int n = 20000;
        for (int i = 0; i < n; ++i) {
            double now = 0;
            for (int k = 0; k < steps; ++k) now = noise.step(random, 1.0 / steps);
            sum += (now - before) * (now - before);
            before = now;
        }
        return sum / n;
    };
    EXPECT_NEAR(mean_square_change_in_a_second(100) / mean_square_change_in_a_second(20), 1, 0.05);
}

}  // namespace
}  // namespace plumb
