// SPDX-License-Identifier: GPL-2.0-or-later
// The errors of both axes from circular paths; the paths are made by moving a point, not by the model's
// terms.
#include "components/math/geometry/circle_test.hpp"

#include "components/math/blocks/pi.hpp"
#include "components/math/blocks/random.hpp"
#include "tests/support/refusal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plumb {
namespace {

struct Drawn {
    double opening = 0, ka = 0, kb = 0, ba = 0, bb = 0, across = 0, lag_a = 0, lag_b = 0;
    double centre_a = 0.02, centre_b = -0.03;

    // R 100 mm at 50 mm/s: each axis lags behind by its own time, and play holds it back.
    CircularPath path(bool clockwise, double degrees = 360) const {
        CircularPath result;
        result.clockwise = clockwise;
        const double turn = clockwise ? -1 : 1, rate = 0.5;  // rad/s
        for (double t = 0; t < degrees / 360 * 2 * pi - 1e-9; t += 2 * pi / 1440) {
            const auto a_of = [&](double lag) { return 100 * std::cos(turn * (t - rate * lag)); };
            const auto b_of = [&](double lag) { return 100 * std::sin(turn * (t - rate * lag)); };
            const double va = -turn * std::sin(turn * t), vb = turn * std::cos(turn * t);
            double a = a_of(lag_a) * (1 + ka) - std::copysign(ba / 2, va);
            double b = b_of(lag_b) * (1 + kb) - std::copysign(bb / 2, vb) + std::copysign(across, va);
            a -= opening * b;
            a += centre_a, b += centre_b;
            result.angles.push_back(std::atan2(b - centre_b, a - centre_a));
            result.radii.push_back(std::hypot(a, b));
        }
        return result;
    }
};

constexpr CircleSetup setup{100, 50};

TEST(CircleTest, SeparatesTheErrorsOfBothAxesAndTheirSigns) {
    Drawn its;
    its.opening = 40e-6, its.ka = 30e-6, its.kb = -10e-6, its.ba = 0.012, its.bb = 0.004, its.across = 0.003;
    its.lag_a = 0.0301, its.lag_b = 0.0299;
    const CircleResult r = circle_result(setup, {its.path(false), its.path(true)});
    EXPECT_NEAR(r.opening.value, 40e-6, 0.5e-6);
    EXPECT_NEAR(r.scale_difference.value, 40e-6, 1e-6);
    EXPECT_NEAR(r.lost_motion_a.value, 0.012, 1e-4);
    EXPECT_NEAR(r.lost_motion_b.value, 0.004, 1e-4);
    EXPECT_NEAR(r.across_a.value, 0.003, 1e-4);
    EXPECT_NEAR(r.lag.value, 0.0002, 0.5e-5);
    EXPECT_TRUE(r.both_directions);
}

TEST(CircleTest, OneDirectionTakesTheLagForAnOpening) {
    Drawn its;
    its.lag_a = 0.0004;
    const CircleResult r = circle_result(
        {150, 2000.0 / 60}, {[&] {
            CircularPath path;
            for (double t = 0; t < 2 * pi; t += 2 * pi / 720) {
                const double w = 2000.0 / 60 / 150;
                path.angles.push_back(t);
                path.radii.push_back(std::hypot(150 * std::cos(t - w * 0.0004), 150 * std::sin(t)));
            }
            return path;
        }()});
    EXPECT_NEAR(std::abs(r.opening.value), 89e-6, 1e-6);
    EXPECT_FALSE(r.both_directions);
}

TEST(CircleTest, ItsUncertaintyCoversTheTruth) {
    Drawn its;
    its.opening = 1.5e-6, its.ba = 0.0005;
    its.ka = 4e-6, its.lag_a = 0.0302, its.lag_b = 0.0301;
    int inside = 0;
    double worst = 0, of_play = 0, of_scale = 0, of_lag = 0;
    for (int i = 0; i < 40; ++i) {
        its.opening += 1e-7;
        Random random(static_cast<std::uint64_t>(i));
        CircularPath ccw = its.path(false), cw = its.path(true);
        for (double& r : ccw.radii) r += 0.0003 * random.gaussian();
        for (double& r : cw.radii) r += 0.0003 * random.gaussian();
        const CircleResult r = circle_result(setup, {ccw, cw});
        inside += std::abs(r.opening.value - its.opening) <= 2 * r.opening.uncertainty;
        worst = std::max(worst, 2 * r.opening.uncertainty);
        of_play =
            std::max({of_play, std::abs(r.lost_motion_a.value - its.ba), std::abs(r.lost_motion_b.value)});
        of_scale = std::max(of_scale, std::abs(r.scale_difference.value - its.ka));
        of_lag = std::max(of_lag, std::abs(r.lag.value - (its.lag_a - its.lag_b)));
    }
    EXPECT_LT(of_play, 0.0005) << "mm";
    EXPECT_LT(of_scale, 2e-6);
    EXPECT_LT(of_lag, 0.03e-3) << "s";
    EXPECT_GE(inside, 34);
    EXPECT_LT(worst, 1.5e-6);
}

std::string refusal(const CircleSetup& its, const std::vector<CircularPath>& paths) {
    return plumb::refusal<std::invalid_argument>([&] { circle_result(its, paths); });
}

TEST(CircleTest, RefusesPathsThatShowTooLittle) {
    const Drawn its;
    EXPECT_EQ(refusal(setup, {its.path(false, 300)}),
              "the counter-clockwise path covers 300 deg, and needs 330 deg");
    EXPECT_EQ(refusal(setup, {its.path(false, 340)}), "accepted");
    CircularPath gap = its.path(true);
    gap.angles.erase(gap.angles.begin() + 100, gap.angles.begin() + 130);
    gap.radii.erase(gap.radii.begin() + 100, gap.radii.begin() + 130);
    gap.angles.erase(gap.angles.begin() + 500, gap.angles.begin() + 530);
    gap.radii.erase(gap.radii.begin() + 500, gap.radii.begin() + 530);
    EXPECT_EQ(refusal(setup, {gap}), "the clockwise path has gaps of 8 deg, and needs 5 deg or less");
    EXPECT_EQ(refusal(setup, {its.path(true), its.path(true)}), "both paths go in the same direction");
    EXPECT_EQ(refusal({102, 50}, {its.path(false)}).substr(0, 43),
              "the counter-clockwise path has a radius of ");
    EXPECT_EQ(refusal({100, 0}, {its.path(false)}), "the feed is not above 0");
}

}  // namespace
}  // namespace plumb
