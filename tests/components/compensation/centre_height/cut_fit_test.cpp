// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace plumb {
namespace {

constexpr double um = 1e-3;
const double square_axes = std::acos(-1.0) / 2;

struct Tip {
    double x, y;
    double angle = square_axes;

    // Where its axes stand, against the first cut, and the radius that it leaves there.
    Cut at(double to_x, double to_y) const {
        return {to_x, to_y, std::hypot(x + to_x + to_y * std::cos(angle), y + to_y * std::sin(angle))};
    }
};

CutFit fit(const std::vector<Cut>& cuts, const CutSigmas& sigmas = {}, double angle = square_axes) {
    return CutFit::of(cuts.data(), cuts.size(), SkewedAxes(angle), sigmas);
}

Tip drawn(Random& random, double skew = 0) {
    const double x = random.uniform(0.5, 30);
    return {x, random.uniform(-0.2, 0.2) * x, square_axes + random.uniform(-skew, skew)};
}

TEST(CutFit, TwoLandsAreTheFormulaOfTwoLands) {
    Random random(1);
    for (int i = 0; i < 5000; ++i) {
        const Tip tip = drawn(random);
        const double s = random.uniform(0.1, 0.3) * tip.x;
        const Cut above = tip.at(0, s), below = tip.at(0, -s);
        const CutFit found = fit({above, below});
        ASSERT_EQ(found.refusal, CutFit::Refusal::none);
        const double d1 = 2 * above.radius, d2 = 2 * below.radius;
        EXPECT_NEAR(found.y - s, (d1 * d1 - d2 * d2) / (16 * s), 1e-9 * tip.x);
        EXPECT_NEAR(found.y - s, tip.y, 1e-9 * std::abs(tip.y) + 1e-14 * tip.x);
        EXPECT_NEAR(found.x, tip.x, 1e-9 * tip.x);
    }
}

TEST(CutFit, TwoLandsAreExactOnCentreAndOnSkewAxes) {
    const CutFit centre = fit({Tip{5, 0}.at(0, 1), Tip{5, 0}.at(0, -1)});
    EXPECT_NEAR(centre.y, 1, 1e-13);
    Random random(2);
    for (int i = 0; i < 5000; ++i) {
        const Tip tip = drawn(random, 0.5);
        const double s = random.uniform(0.1, 0.3) * tip.x;
        const CutFit found = fit({tip.at(0, 0), tip.at(0, -s)}, {}, tip.angle);
        EXPECT_NEAR(found.y, tip.y, 1e-9 * tip.x);
        EXPECT_NEAR(found.x, tip.x, 1e-9 * tip.x);
    }
}

// Height y of the tip before a step of Y, from the radius before it, r and x there, and the radius r3 of a
// cut after it that went deeper by infeed.
double height_by_y_step(double r, double x, double r3, double infeed, double step) {
    return ((r3 - r) * (r3 + r) + 2 * x * infeed - infeed * infeed - step * step) / (2 * step);
}

TEST(CutFit, ThirdCutAfterAStepIsTheFormulaOfTheStep) {
    Random random(3);
    for (int i = 0; i < 5000; ++i) {
        const Tip tip = drawn(random);
        const double travel = random.uniform(0.1, 0.5) * tip.x, infeed = random.uniform(0.05, 0.3) * tip.x;
        const double s = random.uniform(0.1, 0.3) * tip.x;
        const Cut first = tip.at(0, 0), second = tip.at(-travel, 0), third = tip.at(-travel - infeed, s);
        const double by_formula = height_by_y_step(second.radius, tip.x - travel, third.radius, infeed, s);
        EXPECT_NEAR(by_formula, tip.y, 1e-9 * tip.x);
        EXPECT_NEAR(fit({first, second, third}).y, tip.y, 1e-9 * tip.x);
    }
}

TEST(CutFit, AnyNumberOfCutsIsExactOnAnyAxes) {
    Random random(4);
    for (int i = 0; i < 3000; ++i) {
        const Tip tip = drawn(random, 0.5);
        std::vector<Cut> cuts{tip.at(0, 0)};
        const int count = 3 + random.index(9);
        for (int k = 1; k < count; ++k)
            cuts.push_back(tip.at(random.uniform(-0.5, 0.5) * tip.x, random.uniform(-0.3, 0.3) * tip.x));
        cuts[1].y = 0;
        cuts[1] = tip.at(-0.4 * tip.x, 0);
        cuts[2] = tip.at(-0.2 * tip.x, 0.2 * tip.x);
        const CutFit found = fit(cuts, {}, tip.angle);
        ASSERT_EQ(found.refusal, CutFit::Refusal::none) << i;
        EXPECT_NEAR(found.y, tip.y, 1e-9 * tip.x) << i << ' ' << count;
        EXPECT_NEAR(found.x, tip.x, 1e-9 * tip.x) << i;
        EXPECT_EQ(found.redundant, count - 3);
    }
}

// From the side of -X, too: where outward is is a matter of the caller.
TEST(CutFit, OriginOfThePositionsDoesNotMatter) {
    const Tip tip{4, 0.1};
    std::vector<Cut> cuts{tip.at(0, 0), tip.at(-1, 0), tip.at(-1, 0.5), tip.at(-2, -0.5)};
    const CutFit here = fit(cuts);
    for (Cut& cut : cuts) {
        cut.x += 250;
        cut.y -= 80;
    }
    EXPECT_NEAR(fit(cuts).y, here.y, 1e-12);
}

TEST(CutFit, LandsInAbbaOrderCancelWearAndShowIt) {
    const Tip tip{0.5, 0.03};
    std::vector<Cut> cuts;
    for (const double s : {0.2, -0.2, -0.2, 0.2}) cuts.push_back(tip.at(0, s));
    for (std::size_t k = 0; k < cuts.size(); ++k) cuts[k].radius += 2 * um * (static_cast<double>(k) - 1.5);
    const CutFit found = fit(cuts, {0, 0.1 * um, 0, 0, 2 * um});
    EXPECT_NEAR(found.y - 0.2, 0.03, 0.02 * um);
    EXPECT_NEAR(found.drift, 2 * um, 0.05 * um);
    EXPECT_NEAR(found.rise, 0, 0.1 * um);
    const CutFit pair = fit({cuts[0], cuts[1]});
    EXPECT_GT(std::abs(pair.y - 0.23), 1 * um) << "one pair alone takes the wear for height";
}

struct Scatter {
    double of_y, of_x, large, spread;
    double reported;  // errors of y in the sigmas that the residuals have raised
};

// Errors in sigmas of the settings, of machines drawn around a pattern of cuts that scatter `more` than
// these.
Scatter scatter(const std::vector<Cut>& pattern, const CutSigmas& sigmas, int count, double more = 1) {
    Random random(5);
    double of_y = 0, of_x = 0, large = 0, spread = 0, reported = 0;
    for (int i = 0; i < count; ++i) {
        const Tip tip{5, random.uniform(-0.3, 0.3)};
        std::vector<Cut> cuts;
        for (const Cut& each : pattern) {
            Cut cut = tip.at(each.x + sigmas.travel / std::sqrt(2.0) * random.gaussian(),
                             each.y + sigmas.step / std::sqrt(2.0) * random.gaussian());
            cut.radius += more * sigmas.radius() * random.gaussian();
            cut.x = each.x;
            cut.y = each.y;
            cuts.push_back(cut);
        }
        const CutFit found = fit(cuts, sigmas);
        const double ey = (found.y - pattern[0].y - tip.y) / found.sigma_y * found.spread;
        const double ex = (found.x - pattern[0].x - tip.x) / found.sigma_x * found.spread;
        spread += found.spread / count;
        reported += ey * ey / (found.spread * found.spread) / count;
        of_y += ey * ey / count;
        of_x += ex * ex / count;
        large += found.excess > 3 ? 1.0 / count : 0;
    }
    return {std::sqrt(of_y), std::sqrt(of_x), large, spread, std::sqrt(reported)};
}

TEST(CutFit, ScatterIsItsSigma) {
    const CutSigmas lands{2 * um, 1.2 * um, 0, 0}, all{2 * um, 1.2 * um, 1 * um, 2 * um};
    const std::vector<Cut> pair{{0, 1, 0}, {0, -1, 0}}, abba{{0, 1, 0}, {0, -1, 0}, {0, -1, 0}, {0, 1, 0}};
    const std::vector<Cut> step{{0, 0, 0}, {-2, 0, 0}, {-2.5, 0.5, 0}};
    const std::vector<Cut> many{{0, 0, 0},     {-1, 0.5, 0}, {-2, -0.5, 0}, {-2, 0.5, 0},
                                {-1, -0.5, 0}, {-3, 0.3, 0}, {-3, -0.3, 0}};
    const int count = 8000;
    for (const auto& [pattern, sigmas] :
         {std::pair(pair, lands), std::pair(abba, lands), std::pair(step, all), std::pair(many, all)}) {
        const Scatter found = scatter(pattern, sigmas, count);
        EXPECT_NEAR(found.of_y, 1, 0.06) << pattern.size();
        EXPECT_NEAR(found.of_x, 1, 0.06) << pattern.size();
        EXPECT_LT(found.large, 0.01) << pattern.size();
        EXPECT_LT(found.spread, 1.1) << pattern.size();
    }
}

// Chatter, four times what the settings allow.
TEST(CutFit, CutsThatScatterByMoreThanTheirSigmasRaiseThem) {
    const CutSigmas lands{2 * um, 1.2 * um, 0, 0};
    const std::vector<Cut> abba{{0, 1, 0}, {0, -1, 0}, {0, -1, 0}, {0, 1, 0}};
    std::vector<Cut> twelve;
    for (int pairs = 0; pairs < 3; ++pairs) twelve.insert(twelve.end(), abba.begin(), abba.end());
    const int count = 4000;
    const Scatter four = scatter(abba, lands, count, 4), many = scatter(twelve, lands, count, 4);
    EXPECT_NEAR(four.of_y, 4, 0.4);
    EXPECT_LT(four.reported, 0.65 * four.of_y);
    EXPECT_LT(many.reported, 0.4 * many.of_y);
}

// Wear, growth and lift, drawn anew for each procedure.
TEST(CutFit, DriftIsInItsSigma) {
    const CutSigmas sigmas{0.3 * um, 0, 0, 0, 0.5 * um};
    Random random(6);
    for (const std::vector<double>& order :
         {std::vector<double>{1, -1}, {1, -1, -1, 1}, {1, -1, -1, 1, 1, -1, -1, 1}}) {
        double of_y = 0, large = 0;
        const int count = 4000;
        for (int i = 0; i < count; ++i) {
            const Tip tip{5, random.uniform(-0.3, 0.3)};
            const double drift = sigmas.drift * random.gaussian(), rise = sigmas.drift * random.gaussian();
            std::vector<Cut> cuts;
            for (std::size_t k = 0; k < order.size(); ++k) {
                const double late = static_cast<double>(k) - (static_cast<double>(order.size()) - 1) / 2;
                Cut cut = tip.at(0, order[k] + rise * late);
                cut.y = order[k];
                cut.radius += drift * late + sigmas.radius() * random.gaussian();
                cuts.push_back(cut);
            }
            const CutFit found = CutFit::of(cuts.data(), cuts.size(), SkewedAxes(square_axes), sigmas, true);
            const double error = (found.y - 1 - tip.y) / found.sigma_y;
            of_y += error * error / count;
            large += found.excess > 3 ? 1.0 / count : 0;
        }
        EXPECT_NEAR(std::sqrt(of_y), 1, 0.1) << order.size();
        EXPECT_LT(large, 0.01) << order.size();
    }
}

// The error of a gauge is the same at each land of a diameter: more lands do not lessen it.
TEST(CutFit, ScaleOfTheGaugeIsInItsSigma) {
    const CutSigmas sigmas{0.1 * um, 0, 0, 0, 0, 3e-4};
    Random random(7);
    for (const int lands : {2, 12}) {
        double of_y = 0, large = 0;
        const int count = 4000;
        for (int i = 0; i < count; ++i) {
            const Tip tip{5, random.uniform(-0.3, 0.3)};
            const double scale = sigmas.scale * random.gaussian();
            std::vector<Cut> cuts;
            for (int k = 0; k < lands; ++k) cuts.push_back(tip.at(0, k % 2 ? -1.7 : 0));
            for (Cut& cut : cuts)
                cut.radius += scale * (cut.radius - 5) + sigmas.radius() * random.gaussian();
            const CutFit found = CutFit::of(cuts.data(), cuts.size(), SkewedAxes(square_axes), sigmas, true);
            const double error = (found.y - tip.y) / found.sigma_y;
            of_y += error * error / count;
            large += found.excess > 3 ? 1.0 / count : 0;
        }
        EXPECT_NEAR(std::sqrt(of_y), 1, 0.1) << lands;
        EXPECT_LT(large, 0.01) << lands;
    }
}

TEST(CutFit, OneBadCutShows) {
    const Tip tip{5, 0.1};
    std::vector<Cut> cuts;
    for (const double s : {1, -1, -1, 1, 1, -1, -1, 1}) cuts.push_back(tip.at(0, s));
    EXPECT_LT(fit(cuts, {0.3 * um, 1.2 * um, 0, 0}).excess, 1e-6);
    cuts[3].radius += 10 * um;
    EXPECT_GT(fit(cuts, {0.3 * um, 1.2 * um, 0, 0}).excess, 3);
}

TEST(CutFit, PredictsAnotherCut) {
    const Tip tip{5, 0.1};
    const CutFit found = fit({tip.at(0, 0), tip.at(-1, 0), tip.at(-2, 0.5)}, {0, 1.2 * um, 0, 0});
    EXPECT_NEAR(found.predicted(-1.5, -0.5), tip.at(-1.5, -0.5).radius, 1e-10);
    EXPECT_GT(found.sigma_predicted(-1.5, -0.5), 0);
}

TEST(CutFit, RefusesCutsThatShowNoSign) {
    const Tip tip{5, 0.1};
    EXPECT_EQ(fit({tip.at(0, 0)}).refusal, CutFit::Refusal::too_few);
    EXPECT_EQ(fit({tip.at(0, 0), tip.at(-1, 0), tip.at(-2, 0)}).refusal, CutFit::Refusal::no_step);
    EXPECT_EQ(fit({tip.at(0, 0), tip.at(-1, 0.5)}).refusal, CutFit::Refusal::too_few);
    // X and Y always moved together.
    EXPECT_EQ(fit({tip.at(0, 0), tip.at(-1, 0.5), tip.at(-2, 1)}).refusal, CutFit::Refusal::no_solution);
}

}  // namespace
}  // namespace plumb
