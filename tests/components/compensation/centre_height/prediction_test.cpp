// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/turned_cuts.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

constexpr double height = 0.4, x1 = 5, travel = 2;  // mm; the tip goes from x1 inward

struct Radii {
    double r1 = std::hypot(x1, height), r2 = std::hypot(x1 - travel, height), moved = travel;

    Prediction of(const FurtherCut& further, const CutSigmas& sigmas) const {
        const TwoCuts two = TwoCuts::of(r1, r2, moved, false, sigmas);
        return predict(two, {0, 0, r1}, {-moved, 0, r2}, moved, -1, two.y(), 0, further, sigmas);
    }
};

TEST(Prediction, IsTheDistanceOfTheTipFromTheAxis) {
    const Radii cuts;
    EXPECT_NEAR(cuts.of({-3, 0, 2}, {}).radius, std::hypot(x1 - 3, height), 1e-12);
    EXPECT_NEAR(cuts.of({-3, 0.2, 2}, {}).radius, std::hypot(x1 - 3, height + 0.2), 1e-12);
    EXPECT_NEAR(cuts.of({-3, 0, 2}, {}).disagreement(std::hypot(x1 - 3, height)), 0, 1e-3);
}

// Against differences: each radius and the travel is moved by a little.
TEST(Prediction, SigmaIsThatOfTheMeasuredQuantities) {
    CutSigmas sigmas;
    sigmas.repeatability = 0.001;
    sigmas.travel = 0.002;
    const FurtherCut further{-3, 0, 2};
    constexpr double h = 1e-6;
    const auto change = [&](double Radii::*quantity) {
        Radii up, down;
        up.*quantity += h;
        down.*quantity -= h;
        return (up.of(further, {}).radius - down.of(further, {}).radius) / (2 * h);
    };
    const Prediction predicted = Radii{}.of(further, sigmas);
    const double own_travel = (x1 + further.dx) / predicted.radius * sigmas.travel;
    const double expected = std::hypot(
        std::hypot(change(&Radii::r1) * sigmas.repeatability, change(&Radii::r2) * sigmas.repeatability,
                   change(&Radii::moved) * sigmas.travel),
        sigmas.repeatability, own_travel);
    EXPECT_NEAR(predicted.sigma, expected, 1e-3 * expected);
    EXPECT_NEAR(predicted.disagreement(predicted.radius + 3 * predicted.sigma), 3, 1e-9);
}

TEST(Prediction, ATipThatDoesNotMeetTheWorkPredictsNothing) {
    const TwoCuts two = TwoCuts::of(5, 3, 2, false, {});
    EXPECT_EQ(predict(two, {0, 0, 5}, {-2, 0, 3}, 2, -1, 0, 0, {-5, 0, 2}, {}).radius, 0);
}

TEST(Prediction, ByAFitCountsTheNextCutAndTheScaleOfTheGauge) {
    const SkewedAxes square(std::acos(-1.0) / 2);
    const Cut cuts[] = {
        {0, 0, std::hypot(5, 0.4)}, {0, 0.5, std::hypot(5, 0.9)}, {-1, 0, std::hypot(4, 0.4)}};
    CutSigmas sigmas;
    sigmas.repeatability = 0.001;
    const CutFit fit = CutFit::of(cuts, 3, square, sigmas);
    ASSERT_EQ(fit.refusal, CutFit::Refusal::none);
    const FurtherCut further{-2, 0, 2};
    const Prediction plain = predict(fit, cuts[0].radius, 3, further, sigmas);
    EXPECT_NEAR(plain.radius, std::hypot(3, 0.4), 1e-9);
    EXPECT_NEAR(plain.sigma, std::hypot(fit.sigma_predicted(-2, 0), 0.001), 1e-9);
    sigmas.scale = 0.01;
    EXPECT_NEAR(predict(fit, cuts[0].radius, 3, further, sigmas).sigma,
                std::hypot(plain.sigma, 0.01 * (cuts[0].radius - 3)), 1e-9);
}

}  // namespace
}  // namespace plumb
