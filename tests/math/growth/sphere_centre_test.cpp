// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/random.hpp"
#include "components/math/growth/bore_centre.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

using Eigen::Vector3d;

constexpr double um = 1e-3;
constexpr double size = 13;  // mm, of the sphere and the ball

// Where a ball that comes along an axis, beside the centre by `off` in the other two, meets the sphere.
Vector3d met(const Vector3d& centre, int axis, double side, double off, double other) {
    Vector3d from = Vector3d::Zero();
    from[(axis + 1) % 3] = off;
    from[(axis + 2) % 3] = other;
    from[axis] = side * std::sqrt(size * size - from.squaredNorm());
    return centre + from;
}

SphereTouches five(const Vector3d& centre, const Vector3d& missed) {
    SphereTouches touches;
    for (int axis = 0; axis < 2; ++axis)
        for (const double side : {-1.0, 1.0})
            touches.add(met(centre, axis, side, missed[(axis + 1) % 3], missed[(axis + 2) % 3]));
    touches.add(met(centre, 2, 1, missed.x(), missed.y()));
    return touches;
}

TEST(SphereTouches, FiveTouchesGiveTheCentreAlsoWhenTheyMissIt) {
    const Vector3d centre(120.25, -33.5, -140);
    for (const double miss : {0.0, 0.05, 1.5}) {
        const auto found = five(centre, Vector3d(miss, -0.7 * miss, 0.4 * miss)).centre();
        ASSERT_TRUE(found);
        EXPECT_LT((found->place - centre).norm(), 1e-8);
        EXPECT_NEAR(2 * found->radius - 6, 20, 1e-8);
        EXPECT_NEAR(found->scatter, 0, 1e-8);
    }
}

TEST(SphereTouches, UncertaintyIsThatOfDrawnTouches) {
    Random random(7);
    const double s = 0.5 * um;
    const auto exact = five(Vector3d::Zero(), Vector3d::Zero()).centre();
    ASSERT_TRUE(exact);
    EXPECT_NEAR(exact->per_unit.x(), std::sqrt(0.5), 1e-9);
    EXPECT_NEAR(exact->per_unit.z(), std::sqrt(1.25), 1e-9);  // one touch, and the radius by four
    Vector3d squares = Vector3d::Zero();
    constexpr int spheres = 2000;
    for (int i = 0; i < spheres; ++i) {
        SphereTouches touches;
        for (int axis = 0; axis < 2; ++axis)
            for (const double side : {-1.0, 1.0})
                touches.add(met(Vector3d::Zero(), axis, side, 0, 0) +
                            side * s * random.gaussian() * Vector3d::Unit(axis));
        touches.add(met(Vector3d::Zero(), 2, 1, 0, 0) + s * random.gaussian() * Vector3d::UnitZ());
        const auto found = touches.centre();
        ASSERT_TRUE(found);
        squares += found->place.cwiseAbs2();
    }
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(std::sqrt(squares[axis] / spheres), s * exact->per_unit[axis], 0.06 * s);
}

TEST(SphereTouches, TouchesInOnePlaneAndTooFewGiveNone) {
    SphereTouches plane;
    for (int i = 0; i < 6; ++i) plane.add(Vector3d(size * std::cos(i), size * std::sin(i), 4));
    EXPECT_FALSE(plane.centre());
    SphereTouches three;
    for (int axis = 0; axis < 3; ++axis) three.add(size * Vector3d::Unit(axis));
    EXPECT_FALSE(three.centre());
    EXPECT_FALSE(three.add(Vector3d(NAN, 0, 0)));
    EXPECT_EQ(three.count(), 3);
}

}  // namespace
}  // namespace plumb
