// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/turned_cuts.hpp"
#include "components/math/blocks/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3;
using Refusal = TwoCuts::Refusal;

// A tip on its way from cut 1 to cut 2.
struct Turned {
    double x1, y, travel;
    bool inside;

    double r1() const { return std::hypot(x1, y); }
    double r2() const { return std::hypot(inside ? x1 + travel : x1 - travel, y); }
    TwoCuts cuts(const CutSigmas& sigmas = {}) const {
        return TwoCuts::of(r1(), r2(), travel, inside, sigmas);
    }
};

Turned drawn(Random& random) {
    const double x1 = random.uniform(0.3, 30);
    return {x1, random.uniform(-0.3, 0.3) * x1, random.uniform(0.2, 0.95) * x1, random.bits() % 2 == 0};
}

TEST(TwoCuts, FindHeightAndDistanceOfTheExampleOfTheirSource) {
    const TwoCuts cuts = TwoCuts::of(5, std::sqrt(10.0), 3, false, {});
    EXPECT_NEAR(cuts.y(), 3, 1e-14);
    EXPECT_NEAR(cuts.x1, 4, 1e-14);
    EXPECT_NEAR(cuts.theta, std::asin(0.6), 1e-14);
    EXPECT_EQ(cuts.refusal, Refusal::none);
}

TEST(TwoCuts, AreExactOutsideAndInside) {
    Random random(1);
    for (int i = 0; i < 20000; ++i) {
        const Turned turned = drawn(random);
        const TwoCuts cuts = turned.cuts();
        ASSERT_EQ(cuts.refusal, Refusal::none) << i;
        // Radii have the relative error of a double: no formula finds y squared more accurately than that.
        const double rounding = 1e-15 * (std::abs(cuts.by_r1) + std::abs(cuts.by_r2)) * turned.r1();
        EXPECT_NEAR(cuts.y_squared, turned.y * turned.y, 1e-9 * turned.y * turned.y + rounding);
        EXPECT_NEAR(cuts.x1, turned.x1, 1e-9 * turned.x1);
    }
}

TEST(TwoCuts, DerivativesAreThoseOfTheResult) {
    Random random(2);
    for (int i = 0; i < 200; ++i) {
        const Turned t = drawn(random);
        const double h = 1e-6 * t.x1;
        const auto slope = [&](double r1, double r2, double travel) {
            const auto at = [&](double sign) {
                return TwoCuts::of(t.r1() + sign * r1, t.r2() + sign * r2, t.travel + sign * travel, t.inside,
                                   {1, 1, 1, 0})
                    .y_squared;
            };
            return (at(1) - at(-1)) / (2 * h);
        };
        const TwoCuts cuts = t.cuts();
        EXPECT_NEAR(cuts.by_r1, slope(h, 0, 0), 1e-4 * t.x1);
        EXPECT_NEAR(cuts.by_r2, slope(0, h, 0), 1e-4 * t.x1);
        EXPECT_NEAR(cuts.by_travel, slope(0, 0, h), 1e-4 * t.x1);
    }
}

TEST(TwoCuts, ScatterAsMuchAsTheirSigma) {
    const CutSigmas sigmas{2 * um, 1.2 * um, 1 * um, 0, 0, 1e-3};
    double squares = 0, of_squares = 0;
    Random random(3);
    const int count = 40000;
    for (int i = 0; i < count; ++i) {
        const Turned t = drawn(random);
        const double r1 = t.r1() + sigmas.radius() * random.gaussian();
        const double of_scale = (t.r2() - t.r1()) * sigmas.scale * random.gaussian();
        const double r2 = t.r2() + of_scale + sigmas.radius() * random.gaussian();
        const TwoCuts cuts =
            TwoCuts::of(r1, r2, t.travel + sigmas.travel * random.gaussian(), t.inside, sigmas);
        if (cuts.refusal != Refusal::none) continue;
        const double error = (cuts.y_squared - t.y * t.y) / cuts.sigma_y_squared;
        squares += error * error;
        if (std::abs(t.y) < 4 * cuts.floor()) continue;
        const double of_y = (cuts.y() - std::abs(t.y)) / cuts.sigma();
        of_squares += (of_y * of_y - 1) / count;
    }
    EXPECT_NEAR(std::sqrt(squares / count), 1, 0.05);
    EXPECT_NEAR(of_squares, 0, 0.1);
}

TEST(TwoCuts, OnCentreTheSigmaIsFinite) {
    const TwoCuts cuts = TwoCuts::of(5, 2.5, 2.5, false, {0, 1.2 * um, 0, 0});
    EXPECT_EQ(cuts.y(), 0);
    EXPECT_EQ(cuts.sigma(), cuts.floor());
    EXPECT_NEAR(cuts.floor(), std::sqrt(2 / 2.5 * 5 * 2.5 * 1.2 * um * std::sqrt(2.0)), 1e-9);
    EXPECT_TRUE(std::isfinite(cuts.sensitivity(cuts.by_r1)));
}

// The figures from which a tool may be moved: 41 um at D 1 to 0.2.
TEST(TwoCuts, SmallestHeightToMoveIsThatOfTheirFloor) {
    EXPECT_NEAR(2 * TwoCuts::of(0.5, 0.1, 0.4, false, {0.3 * um, 1.2 * um, 0, 0}).floor(), 41 * um, 0.5 * um);
}

TEST(TwoCuts, RefuseImpossibleCuts) {
    const auto refusal = [](double r1, double r2, double travel, bool inside = false) {
        return TwoCuts::of(r1, r2, travel, inside, {2 * um, 1.2 * um, 1 * um, 0}).refusal;
    };
    EXPECT_EQ(refusal(5, 4, 0), Refusal::travel);
    EXPECT_EQ(refusal(5, 4, -1), Refusal::travel);
    EXPECT_EQ(refusal(5, 4, std::nan("")), Refusal::travel);
    EXPECT_EQ(refusal(4, 5, 1), Refusal::order);
    EXPECT_EQ(refusal(5, 5, 1), Refusal::order);
    EXPECT_EQ(refusal(5, 4, 1, true), Refusal::order);
    EXPECT_EQ(refusal(5, 4, 0.9), Refusal::short_travel);
    EXPECT_EQ(refusal(5, 4, 9.5), Refusal::long_travel);
    EXPECT_EQ(refusal(5, 4, 3.5), Refusal::past_centre);  // 12.25 > 25 - 16
    EXPECT_EQ(refusal(4, 5, 3.5, true), Refusal::past_centre);
    EXPECT_EQ(refusal(5, 4, 1), Refusal::none);
    EXPECT_EQ(refusal(5, 4, 1 - 1 * um), Refusal::none) << "within the uncertainty";
}

// x2 > 0 exactly if travel^2 < r1^2 - r2^2.
TEST(TwoCuts, PastTheCentreIsThatOfTheSquares) {
    Random random(4);
    for (int i = 0; i < 5000; ++i) {
        const double r1 = random.uniform(1, 10), r2 = random.uniform(0.1, 1) * r1;
        const double travel = random.uniform(r1 - r2, r1 + r2);
        EXPECT_EQ(TwoCuts::of(r1, r2, travel, false, {}).refusal == Refusal::past_centre,
                  travel * travel > (r1 - r2) * (r1 + r2));
    }
}

}  // namespace
}  // namespace plumb
