// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/turned_cuts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace plumb {
namespace {

// A tool outside the tolerance is said to be within it in at most one of 100 measurements.
TEST(KnownError, IsWithinByNinetyNineInAHundred) {
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0, 1);
    constexpr double tolerance = 5;
    constexpr int count = 20000;
    int said = 0;
    for (int i = 0; i < count; ++i)
        said += KnownError{std::abs(tolerance + noise(random)), 1}.within(tolerance);
    EXPECT_LT(said, 0.012 * count);
    EXPECT_GT(said, 0.008 * count);
}

TEST(KnownError, ASigmaBeyondTheToleranceIsNeverWithin) {
    EXPECT_TRUE((KnownError{0, 2.1}.within(5)));
    EXPECT_FALSE((KnownError{0, 2.2}.within(5)));
    EXPECT_FALSE((KnownError{0, std::nan("")}.within(5)));
}

TEST(KnownError, IsSignificantFromSixSigmasOn) {
    EXPECT_TRUE((KnownError{6, 1}.significant()));
    EXPECT_FALSE((KnownError{5.99, 1}.significant()));
    EXPECT_FALSE((KnownError{0, 0}.significant()));
}

// With so many more cuts the sigma is just small enough for one of both answers.
TEST(KnownError, MoreCutsMakeItKnown) {
    for (const double size : {0.0, 1.0, 3.0, 4.9, 5.0, 7.0}) {
        constexpr double tolerance = 5, sigma = 4;
        const double more = KnownError{size, sigma}.more_cuts(tolerance);
        EXPECT_GT(more, 1) << size;
        const KnownError enough{size, sigma / std::sqrt(more * 1.001)},
            few{size, sigma / std::sqrt(more * 0.99)};
        EXPECT_TRUE(enough.within(tolerance) || enough.significant()) << size;
        EXPECT_FALSE(few.within(tolerance) || few.significant()) << size;
    }
}

}  // namespace
}  // namespace plumb
