// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/lost_motion.hpp"

#include "components/commissioning/volume/volume_readings.hpp"
#include "components/math/blocks/random.hpp"
#include "tests/support/refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace plumb {
namespace {

TEST(LostMotion, IsTheDifferenceOfBothDirections) {
    const ReversalResult r =
        reversal_of({{300, {0, 0.001}, {0.008, 0.009}}, {100, {0.002, 0.003}, {0.014, 0.015}}});
    EXPECT_EQ(r.rows[0].position, 100);
    EXPECT_NEAR(r.rows[0].half, -0.006, 1e-12);
    EXPECT_NEAR(r.rows[0].mean, 0.0085, 1e-12);
    EXPECT_NEAR(r.rows[1].half, -0.004, 1e-12);
    EXPECT_NEAR(r.lost_motion, 0.010, 1e-12);
    EXPECT_EQ(r.freedom, 4);
    EXPECT_NEAR(r.repeatability, 0.001 / std::sqrt(2), 1e-12);
}

// 5 readings at 3 positions, 2,000 times: 95.45 of 100 within twice the standard uncertainty.
TEST(LostMotion, ItsUncertaintyCoversTheTruthAsStated) {
    Random random(3);
    int inside = 0, inside_row = 0;
    constexpr int tries = 2000;
    for (int n = 0; n < tries; ++n) {
        std::vector<BothWays> places;
        for (const double p : {0.0, 200.0, 400.0}) {
            BothWays place{p, {}, {}};
            for (int i = 0; i < 5; ++i) {
                place.up.push_back(-0.005 + 0.0005 * random.gaussian());
                place.down.push_back(0.005 + 0.0005 * random.gaussian());
            }
            places.push_back(place);
        }
        const ReversalResult r = reversal_of(places);
        inside += std::abs(r.lost_motion - 0.01) <= 2 * r.uncertainty;
        inside_row += std::abs(-2 * r.rows[1].half - 0.01) <= 4 * r.rows[1].uncertainty;
    }
    EXPECT_NEAR(inside, 0.9545 * tries, 0.02 * tries);
    EXPECT_NEAR(inside_row, 0.9545 * tries, 0.02 * tries);
}

TEST(LostMotion, RepeatingDoesNotReduceTheIndicatorsOwnHysteresis) {
    const ReversalResult r =
        reversal_of({{0, std::vector<double>(100, 0), std::vector<double>(100, 0.01)}}, 0.0001, 0.0004);
    EXPECT_GT(r.uncertainty, 0.0004);
    EXPECT_LT(r.uncertainty, 0.00041);
}

TEST(LostMotion, RefusesReadingsThatShowTooLittle) {
    const auto refusal = [](const std::vector<BothWays>& places, double u = 0) {
        return plumb::refusal<std::invalid_argument>([&] { reversal_of(places, u); });
    };
    EXPECT_EQ(refusal({}), "there are no readings");
    EXPECT_EQ(refusal({{12.5, {}, {1}}}), "position 12.5 was not reached from the - side");
    EXPECT_EQ(refusal({{12, {1}, {}}}), "position 12 was not reached from the + side");
    EXPECT_EQ(refusal({{1, {0}, {0}}, {1, {0}, {0}}}, 1), "position 1 is there twice");
    EXPECT_EQ(refusal({{1, {0}, {0}}}).substr(0, 50), "each position was read once in each direction, so ");
    EXPECT_EQ(refusal({{1, {0}, {0}}}, 0.001), "accepted");
    EXPECT_EQ(refusal({{1, {0, 0}, {0, 0}}}).substr(0, 34), "the readings do not scatter at all");
}

TEST(BoxDiagonals, GiveTheCornersOfABoxThatLeans) {
    constexpr double gxy = 20e-6, gxz = -35e-6, gyz = 11e-6, kx = 10e-6, ky = -4e-6, kz = 7e-6;
    const auto corner = [&](double x, double y, double z, double* to) {
        to[0] = x * (1 + kx) - gxy * y - gxz * z, to[1] = y * (1 + ky) - gyz * z, to[2] = z * (1 + kz);
    };
    BoxDiagonals box{800, 600, 500, {}, 0.001};
    const double length = std::sqrt(800 * 800 + 600 * 600 + 500 * 500);
    constexpr int signs[][2] = {{1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
    for (std::size_t i = 0; i < 4; ++i) {
        double to[3];
        corner(signs[i][0] * 800, signs[i][1] * 600, 500, to);
        box.deviations[i] = std::sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]) - length;
    }
    const BoxResult r = box_from_diagonals(box);
    EXPECT_NEAR(r.xy, gxy, 2e-9);
    EXPECT_NEAR(r.xz, gxz, 2e-9);
    EXPECT_NEAR(r.yz, gyz, 2e-9);
    EXPECT_NEAR(r.scale * length * length, kx * 640000 + ky * 360000 + kz * 250000, 0.01);
    EXPECT_NEAR(r.u_xy, length * 0.001 / (2 * 800 * 600), 1e-12);
    EXPECT_NEAR(box_from_diagonals({1000, 1000, 1000, {}, 0.001}).u_xy, 0.87e-6, 0.01e-6);
}

TEST(BoxDiagonals, RefuseLengthsOfNoSuchBox) {
    const auto refusal = [](const BoxDiagonals& box) {
        return plumb::refusal<std::invalid_argument>([&] { box_from_diagonals(box); });
    };
    EXPECT_EQ(refusal({800, 600, 500, {0, 12, 0, 0}, 0.001}).substr(0, 57),
              "a deviation of 12.000000 mm is above 1 % of the diagonal ");
    EXPECT_NE(refusal({8, 600, 500, {}, 0.001}), "accepted");
    EXPECT_NE(refusal({800, 600, 500, {}, 0}), "accepted");
    EXPECT_NE(refusal({800, 600, 500, {0, 0, 0, std::nan("")}, 0.001}), "accepted");
}

TEST(Straightedge, TurnedOverDropsItsOwnError) {
    std::vector<double> x, before, turned, axis, edge;
    for (int i = 0; i <= 20; ++i) {
        x.push_back(50 * i);
        axis.push_back(0.005 * std::sin(0.3 * i));
        edge.push_back(0.03 * std::cos(0.5 * i));
        before.push_back(axis.back() + edge.back() + 0.001 * i + 0.4);
        turned.push_back(-axis.back() + edge.back() - 0.002 * i);
    }
    const Straightness r = straightness_of(x, before, turned);
    const std::vector<double> wanted = without_slope(x, axis);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(r.errors[i], wanted[i], 1e-12);
    EXPECT_GT(r.range_of_edge, 0.05);
}

}  // namespace
}  // namespace plumb
