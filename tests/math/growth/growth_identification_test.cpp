// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_identification.hpp"

#include <gtest/gtest.h>

#include <random>

namespace plumb {
namespace {

// Four bores in ten passes: two terms, a constant for each bore, and noise. The second term is zero without
// `second`.
GrowthVisits machine(double noise, unsigned seed, bool second = true) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    GrowthVisits visits;
    visits.terms.resize(40, 2);
    visits.growth.resize(40);
    for (int pass = 0; pass < 10; ++pass)
        for (int bore = 0; bore < 4; ++bore) {
            const int row = 4 * pass + bore;
            const double warm = pass > 0 ? 8 * (1 - std::exp(-pass / 3.0)) + gauss(random) : 0;
            visits.terms.row(row) << warm, second ? warm * (bore - 1.5) : 0;
            visits.growth[row] = 0.003 * visits.terms(row, 0) - 0.0005 * visits.terms(row, 1) + 10.0 * bore +
                                 noise * gauss(random);
            visits.groups.push_back(bore);
            visits.passes.push_back(pass);
        }
    return visits;
}

const Eigen::Vector2d large(0.005, 0.005);

TEST(IdentifiedGrowth, FindsTheLawUnderTheConstantsOfTheBores) {
    const IdentifiedGrowth found = identified_growth(machine(0, 1), large, 1e-6);
    EXPECT_NEAR(found.value[0], 0.003, 1e-7);
    EXPECT_NEAR(found.value[1], -0.0005, 1e-7);
    EXPECT_LT(found.rest, 1e-6);
    EXPECT_LT(found.predicted_rest, 1e-6);
    EXPECT_GT(found.drift, 0.005);
}

TEST(IdentifiedGrowth, PredictedRestIsTheNoiseOfADifferenceOfTwoVisits) {
    double squares = 0;
    for (unsigned seed = 1; seed <= 50; ++seed) {
        const double rest = identified_growth(machine(0.001, seed), large, 0.001).predicted_rest;
        squares += rest * rest / 50;
    }
    EXPECT_NEAR(std::sqrt(squares), 0.001 * std::sqrt(2), 0.0001);
}

TEST(IdentifiedGrowth, ALawOfNoiseDoesNotPredict) {
    GrowthVisits visits = machine(0.001, 7);
    std::mt19937 random(3);
    std::normal_distribution<double> gauss;
    for (Eigen::Index i = 0; i < visits.growth.size(); ++i) visits.growth[i] = 0.001 * gauss(random);
    const IdentifiedGrowth found = identified_growth(visits, large, 0.001);
    EXPECT_LT(found.rest, found.drift) << "it always fits";
    EXPECT_GT(found.predicted_rest, found.drift);
}

TEST(IdentifiedGrowth, ATermThatNothingDeterminesStaysZero) {
    const IdentifiedGrowth found = identified_growth(machine(0.0005, 1, false), large, 0.001);
    EXPECT_NEAR(found.value[0], 0.003, 2e-4);
    EXPECT_EQ(found.value[1], 0);
}

TEST(IdentifiedGrowth, OnePassPredictsNothing) {
    GrowthVisits visits = machine(0, 1);
    visits.passes.assign(40, 1);
    EXPECT_TRUE(std::isinf(identified_growth(visits, large, 0.001).predicted_rest));
}

}  // namespace
}  // namespace plumb
