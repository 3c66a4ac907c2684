// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/tip_correction.hpp"

#include "components/math/blocks/pi.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

using Eigen::Vector3d;

constexpr double radius = 25;  // mm

Vector3d tip(const Vector3d& velocity, double its_radius = radius, int plane = 17) {
    ContourTip tip;
    tip.step(velocity, its_radius, plane);
    return tip.vector();
}

void expect_near(const Vector3d& is, const Vector3d& wanted) {
    EXPECT_LT((is - wanted).norm(), 1e-12 * radius) << is.transpose() << " for " << wanted.transpose();
}

// A bore is cut counterclockwise with G41, a boss clockwise; both with the axis beside the contour.
TEST(ContourTip, LiesOnTheCircleThatIsBoredOrTurned) {
    const double bore = 60, boss = 40;
    for (int degrees = 0; degrees < 360; degrees += 7) {
        const double angle = degrees * pi / 180;
        const Vector3d out(std::cos(angle), std::sin(angle), 0), along(-out[1], out[0], 0);
        expect_near((bore - radius) * out + tip(30 * along), bore * out);
        expect_near((boss + radius) * out + tip(-30 * along), boss * out);
        expect_near((bore - radius) * out + tip(-30 * along, -radius), bore * out);
        expect_near((boss + radius) * out + tip(30 * along, -radius), boss * out);
    }
}

// The axes of G18 are Z and X, those of G19 Y and Z.
TEST(ContourTip, TurnsWithThePlane) {
    expect_near(tip({10, 0, 0}, radius, 17), {0, -radius, 0});
    expect_near(tip({0, 10, 0}, radius, 17), {radius, 0, 0});
    expect_near(tip({0, 0, 10}, radius, 18), {-radius, 0, 0});
    expect_near(tip({10, 0, 0}, radius, 18), {0, 0, radius});
    expect_near(tip({0, 10, 0}, radius, 19), {0, 0, -radius});
    expect_near(tip({0, 0, 10}, radius, 19), {0, radius, 0});
}

TEST(ContourTip, IsSquareToThePathAndInThePlaneOnAHelix) {
    const Vector3d velocity(3, 4, -12), across = tip(velocity);
    EXPECT_EQ(across[2], 0);
    EXPECT_NEAR(across.dot(velocity), 0, 1e-12);
    EXPECT_NEAR(across.norm(), radius, 1e-12);
}

TEST(ContourTip, KeepsItsDirectionAtRestAndAcrossThePlane) {
    ContourTip tip;
    tip.step({10, 10, 0}, radius, 17);
    const Vector3d before = tip.vector();
    for (const Vector3d& velocity : {Vector3d(0, 0, 0), Vector3d(0, 0, -50), Vector3d(-1e-7, 0, 0)}) {
        tip.step(velocity, radius, 17);
        EXPECT_EQ(tip.vector(), before);
    }
    tip.step({0, 0, 0}, -radius, 17);
    EXPECT_EQ(tip.vector(), -before) << "the other side of the same path";
    tip.step({0, 0, 0}, radius / 2, 17);
    EXPECT_EQ(tip.vector(), before / 2);
}

TEST(ContourTip, HasNoDirectionBeforeTheFirstMotionOfAContour) {
    ContourTip tip;
    tip.step({0, 0, -10}, radius, 17);
    EXPECT_TRUE(tip.vector().isZero(0));
    tip.step({10, 0, 0}, radius, 17);
    tip.step({10, 0, 0}, 0, 17);
    EXPECT_TRUE(tip.vector().isZero(0));
    tip.step({0, 0, 0}, radius, 17);
    EXPECT_TRUE(tip.vector().isZero(0)) << "after G40";
    tip.step({10, 0, 0}, radius, 17);
    tip.step({0, 0, 0}, radius, 18);
    EXPECT_TRUE(tip.vector().isZero(0)) << "in another plane";
}

TEST(ContourTip, DoesNotDependOnTheSpeed) {
    for (const double speed : {1e-5, 1.0, 1e6}) expect_near(tip({0, speed, 0}), {radius, 0, 0});
}

}  // namespace
}  // namespace plumb
