// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/growth_identification.hpp"

#include <gtest/gtest.h>

#include <random>

namespace plumb {
namespace {

// Four bores in ten passes, two a block: two terms, a constant for each bore, and noise. The second term is
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
            visits.blocks.push_back(pass / 2);
            visits.days.push_back(0);
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

TEST(IdentifiedGrowth, PredictedRestIsTheNoiseOfAVisitOfTheFirstOneAndOfTheLaw) {
    double squares = 0;
    for (unsigned seed = 1; seed <= 50; ++seed) {
        const double rest = identified_growth(machine(0.001, seed), usual, 1e-6).predicted_rest;
        squares += rest * rest / 50;
    }
    EXPECT_GT(std::sqrt(squares), 0.001 * std::sqrt(2 - 0.3));
    EXPECT_LT(std::sqrt(squares), 0.001 * std::sqrt(2 + 0.7));
}

TEST(IdentifiedGrowth, ALawOfNoisePredictsWorseThanNone) {
    GrowthVisits visits = machine(0.001, 7);
    std::mt19937 random(3);
    std::normal_distribution<double> gauss;
    for (Eigen::Index i = 0; i < visits.growth.size(); ++i) visits.growth[i] = 0.001 * gauss(random);
    const IdentifiedGrowth found = identified_growth(visits, usual, 0.001);
    EXPECT_LT(found.rest, found.drift) << "it always fits";
    visits.terms.resize(40, 0);
    EXPECT_GT(found.predicted_rest, identified_growth(visits, Eigen::VectorXd(), 0.001).predicted_rest);
}

TEST(IdentifiedGrowth, ATermThatNothingDeterminesStaysZeroAndAsUncertainAsBefore) {
    const IdentifiedGrowth found = identified_growth(machine(0.0005, 1, false), usual, 0.001);
    EXPECT_NEAR(found.value[0], 0.003, 2e-4);
    EXPECT_EQ(found.value[1], 0);
    EXPECT_NEAR(std::sqrt(found.covariance(1, 1)), usual[1], 1e-9);
}

// The first coefficient of the visits that `chosen` names is larger by this part of it.
template <class Chosen>
GrowthVisits varying(double part, Chosen chosen) {
    GrowthVisits visits = machine(0, 1);
    for (Eigen::Index i = 0; i < visits.growth.size(); ++i)
        if (chosen(static_cast<std::size_t>(i))) visits.growth[i] += part * 0.003 * visits.terms(i, 0);
    return visits;
}

TEST(IdentifiedGrowth, TheLaterBlocksShowHowWrongTheSizeOfTheLawIs) {
    GrowthVisits visits = varying(0, [](std::size_t) { return false; });
    EXPECT_EQ(identified_growth(visits, usual, 1e-6).scale, 0.5) << "one day does not show another one";
    visits = varying(1.2, [&](std::size_t i) { return visits.blocks[i] >= 2; });
    EXPECT_GT(identified_growth(visits, usual, 1e-6).scale, 0.6);
}

TEST(IdentifiedGrowth, DaysPredictDaysAndAFewOfThemAreLessSure) {
    const GrowthVisits plain = machine(0, 1);
    const auto of = [&](int days) {
        GrowthVisits visits = varying(-0.1, [&](std::size_t i) { return plain.blocks[i] >= 5 - days / 2; });
        for (std::size_t i = 0; i < visits.days.size(); ++i) {
            visits.days[i] = std::max(0, visits.blocks[i] - (5 - days));
            visits.groups[i] += 4 * visits.days[i];
        }
        return identified_growth(visits, usual, 1e-6);
    };
    EXPECT_EQ(of(2).block_rests.size(), 1U);
    EXPECT_EQ(of(5).block_rests.size(), 4U);
    EXPECT_NEAR(of(2).scale, 0.1 * 13.968 / 2, 0.08) << "of one day, by Student's t";
}

TEST(IdentifiedGrowth, VisitsThatFollowCloselyCountForLess) {
    GrowthVisits visits = machine(0.001, 5);
    const double whole = identified_growth(visits, usual, 1e-6).covariance(0, 0);
    visits.weight.setConstant(0.25);
    EXPECT_NEAR(std::sqrt(identified_growth(visits, usual, 1e-6).covariance(0, 0) / whole), 2, 0.3);
}

TEST(IdentifiedGrowth, TwoBlocksPredictNothing) {
    GrowthVisits visits = machine(0, 1);
    for (int& block : visits.blocks) block = std::min(block, 1);
    EXPECT_TRUE(std::isinf(identified_growth(visits, usual, 0.001).predicted_rest));
}

}  // namespace
}  // namespace plumb
