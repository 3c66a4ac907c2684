// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_identification.hpp"

#include <gtest/gtest.h>

#include <random>

namespace plumb {
namespace {

// Four bores in ten passes, two a duty: two terms, a constant for each bore, and noise. The second term is
// zero without `second`.
GrowthVisits machine(double noise, unsigned seed, bool second = true) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    GrowthVisits visits;
    visits.terms.resize(40, 2);
    visits.growth.resize(40);
    visits.weight.setOnes(40);
    for (int pass = 0; pass < 10; ++pass)
        for (int bore = 0; bore < 4; ++bore) {
            const int row = 4 * pass + bore;
            const double warm = pass > 0 ? 8 * (1 - std::exp(-pass / 3.0)) + gauss(random) : 0;
            visits.terms.row(row) << warm, second ? warm * (bore - 1.5) : 0;
            visits.growth[row] = 0.003 * visits.terms(row, 0) - 0.0005 * visits.terms(row, 1) + 10.0 * bore +
                                 noise * gauss(random);
            visits.groups.push_back(bore);
            visits.duties.push_back(pass / 2);
        }
    return visits;
}

const Eigen::Vector2d usual(0.005, 0.005);

TEST(IdentifiedGrowth, FindsTheLawUnderTheConstantsOfTheBores) {
    const IdentifiedGrowth found = identified_growth(machine(0, 1), usual, 1e-6);
    EXPECT_NEAR(found.value[0], 0.003, 1e-7);
    EXPECT_NEAR(found.value[1], -0.0005, 1e-7);
    EXPECT_LT(found.rest, 1e-6);
    EXPECT_LT(found.predicted_rest, 1e-6);
    EXPECT_GT(found.drift, 0.005);
}

TEST(IdentifiedGrowth, TheCovarianceIsThatOfTheScatterOfTheCoefficients) {
    double squares = 0, stated = 0;
    constexpr int count = 200;
    for (unsigned seed = 1; seed <= count; ++seed) {
        const IdentifiedGrowth found = identified_growth(machine(0.001, seed), usual, 1e-6);
        squares += std::pow(found.value[0] - 0.003, 2) / count;
        stated += found.covariance(0, 0) / count;
    }
    EXPECT_NEAR(std::sqrt(stated / squares), 1, 0.15);
}

TEST(IdentifiedGrowth, PredictedRestIsTheNoiseOfAVisitOfTheMeanOfTheOthersAndOfTheLaw) {
    double squares = 0;
    for (unsigned seed = 1; seed <= 50; ++seed) {
        const double rest = identified_growth(machine(0.001, seed), usual, 1e-6).predicted_rest;
        squares += rest * rest / 50;
    }
    EXPECT_GT(std::sqrt(squares), 0.001 * std::sqrt(1 + 1.0 / 8));
    EXPECT_LT(std::sqrt(squares), 0.001 * std::sqrt(1 + 1.0 / 8 + 0.5));
}

TEST(IdentifiedGrowth, ALawOfNoiseDoesNotPredict) {
    GrowthVisits visits = machine(0.001, 7);
    std::mt19937 random(3);
    std::normal_distribution<double> gauss;
    for (Eigen::Index i = 0; i < visits.growth.size(); ++i) visits.growth[i] = 0.001 * gauss(random);
    const IdentifiedGrowth found = identified_growth(visits, usual, 0.001);
    EXPECT_LT(found.rest, found.drift) << "it always fits";
    EXPECT_GT(found.predicted_rest, found.drift);
}

TEST(IdentifiedGrowth, ATermThatNothingDeterminesStaysZeroAndAsUncertainAsBefore) {
    const IdentifiedGrowth found = identified_growth(machine(0.0005, 1, false), usual, 0.001);
    EXPECT_NEAR(found.value[0], 0.003, 2e-4);
    EXPECT_EQ(found.value[1], 0);
    EXPECT_NEAR(std::sqrt(found.covariance(1, 1)), usual[1], 1e-9);
}

TEST(IdentifiedGrowth, AnErrorThatGrowsWithTheTermsIsAShareOfThem) {
    GrowthVisits visits = machine(0, 1);
    for (Eigen::Index i = 0; i < visits.growth.size(); ++i)  // the coefficient differs by duty
        visits.growth[i] +=
            (visits.duties[static_cast<std::size_t>(i)] % 2 == 0 ? 1 : -1) * 0.0009 * visits.terms(i, 0);
    const IdentifiedGrowth varying = identified_growth(visits, usual, 1e-6);
    EXPECT_GT(varying.covariance(0, 0), 1e-10);
    EXPECT_GT(std::hypot(varying.floor, varying.share * 0.008 * 3), varying.predicted_rest)
        << "five duties are few";
}

TEST(IdentifiedGrowth, VisitsThatFollowCloselyCountForLess) {
    GrowthVisits visits = machine(0.001, 5);
    const double whole = identified_growth(visits, usual, 1e-6).covariance(0, 0);
    visits.weight.setConstant(0.25);
    EXPECT_NEAR(std::sqrt(identified_growth(visits, usual, 1e-6).covariance(0, 0) / whole), 2, 0.3);
}

TEST(IdentifiedGrowth, OneDutyPredictsNothing) {
    GrowthVisits visits = machine(0, 1);
    visits.duties.assign(40, 1);
    EXPECT_TRUE(std::isinf(identified_growth(visits, usual, 0.001).predicted_rest));
}

}  // namespace
}  // namespace plumb
