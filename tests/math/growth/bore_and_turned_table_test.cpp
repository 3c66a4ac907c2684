// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/random.hpp"
#include "components/math/growth/bore_centre.hpp"
#include "components/math/growth/turned_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

using Eigen::Vector3d;

constexpr double um = 1e-3;

BoreTouches four(double x, double y, double radius) {
    BoreTouches touches;
    touches.add({x + radius, y});
    touches.add({x - radius, y});
    touches.add({x, y + radius});
    touches.add({x, y - radius});
    return touches;
}

TEST(BoreTouches, FourTouchesGiveTheCentreAndTheDiameterWithTheBall) {
    const auto centre = four(120.25, -33.5, 12).centre();
    ASSERT_TRUE(centre);
    EXPECT_NEAR(centre->place.x(), 120.25, 1e-9);
    EXPECT_NEAR(centre->place.y(), -33.5, 1e-9);
    EXPECT_NEAR(2 * centre->radius + 6, 30, 1e-9);
    EXPECT_NEAR(centre->scatter, 0, 1e-9);
}

TEST(BoreTouches, TouchesBesideTheCentreLineGiveTheCentre) {
    BoreTouches touches;
    for (const double angle : {0.2, 1.9, 3.3, 5.0, 4.1})
        touches.add({10 + 8 * std::cos(angle), 20 + 8 * std::sin(angle)});
    const auto centre = touches.centre();
    ASSERT_TRUE(centre);
    EXPECT_NEAR(centre->place.x(), 10, 1e-9);
    EXPECT_NEAR(centre->place.y(), 20, 1e-9);
    EXPECT_NEAR(centre->radius, 8, 1e-9);
}

TEST(BoreTouches, CentreOfFourTouchesHasTheUncertaintyOfOneByRootTwo) {
    const auto exact = four(0, 0, 12).centre();
    ASSERT_TRUE(exact);
    EXPECT_NEAR(exact->per_unit.x(), std::sqrt(0.5), 1e-9);
    EXPECT_NEAR(exact->per_unit.y(), std::sqrt(0.5), 1e-9);
    Random random(7);
    const double s = 0.5 * um;
    double square = 0;
    constexpr int bores = 4000;
    for (int i = 0; i < bores; ++i) {
        BoreTouches touches;
        for (int side = 0; side < 4; ++side) {
            const double angle = side * std::acos(0.0), radius = 12 + s * random.gaussian();
            touches.add({radius * std::cos(angle), radius * std::sin(angle)});
        }
        square += std::pow(touches.centre()->place.x(), 2);
    }
    EXPECT_NEAR(std::sqrt(square / bores), s / std::sqrt(2), 0.05 * s);
}

TEST(BoreTouches, LineTwoTouchesAndNoNumbersGiveNothing) {
    BoreTouches touches;
    EXPECT_FALSE(touches.add({NAN, 0}));
    touches.add({0, 0});
    touches.add({1, 1});
    EXPECT_FALSE(touches.centre());
    touches.add({2, 2});
    touches.add({3, 3});
    EXPECT_FALSE(touches.centre());
    touches.clear();
    EXPECT_EQ(touches.count(), 0);
    for (int i = 0; i < 5; ++i) touches.add({5, 5});
    EXPECT_FALSE(touches.centre());
}

TEST(TurnedTable, SeparatesTheCentreOfTheTableFromTheBore) {
    // The centre of the table moves by (4, 1, -6) um; the bore by (3, 0, 2) um against it, which turns with
    // the table; a tilt of 20 urad about X lowers or raises the bore at z = 100.
    const double z = 100, tilt = 20e-6;
    const Vector3d at_0 = Vector3d(4 + 3, 1, -6 + 2) * um + Vector3d(0, -tilt * z, 0);
    const Vector3d at_180 = Vector3d(4 - 3, 1, -6 - 2) * um + Vector3d(0, tilt * z, 0);
    const TurnedTable table(at_0, at_180);
    EXPECT_NEAR(table.half_sum.x(), 4 * um, 1e-12);
    EXPECT_NEAR(table.half_sum.z(), -6 * um, 1e-12);
    EXPECT_NEAR(table.half_difference.x(), 3 * um, 1e-12);
    EXPECT_NEAR(table.half_difference.z(), 2 * um, 1e-12);
    ASSERT_TRUE(table.tilt_about_x(z));
    EXPECT_NEAR(*table.tilt_about_x(z), tilt, 1e-12);
    EXPECT_FALSE(table.tilt_about_x(0));
}

}  // namespace
}  // namespace plumb
