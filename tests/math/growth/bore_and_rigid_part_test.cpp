// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/random.hpp"
#include "components/math/growth/bore_centre.hpp"
#include "components/math/growth/rigid_part.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>

namespace plumb {
namespace {

using Eigen::MatrixX3d;
using Eigen::Vector3d;

constexpr double um = 1e-3;

BoreTouches four(double x, double y, double radius) {
    BoreTouches touches;
    touches.add(x + radius, y);
    touches.add(x - radius, y);
    touches.add(x, y + radius);
    touches.add(x, y - radius);
    return touches;
}

TEST(BoreTouches, FourTouchesGiveTheCentreAndTheDiameterWithTheBall) {
    const auto centre = four(120.25, -33.5, 12).centre();
    ASSERT_TRUE(centre);
    EXPECT_NEAR(centre->x, 120.25, 1e-9);
    EXPECT_NEAR(centre->y, -33.5, 1e-9);
    EXPECT_NEAR(centre->bore_diameter(6), 30, 1e-9);
    EXPECT_NEAR(centre->scatter, 0, 1e-9);
}

TEST(BoreTouches, TouchesBesideTheCentreLineGiveTheCentre) {
    BoreTouches touches;
    for (const double angle : {0.2, 1.9, 3.3, 5.0, 4.1})
        touches.add(10 + 8 * std::cos(angle), 20 + 8 * std::sin(angle));
    const auto centre = touches.centre();
    ASSERT_TRUE(centre);
    EXPECT_NEAR(centre->x, 10, 1e-9);
    EXPECT_NEAR(centre->y, 20, 1e-9);
    EXPECT_NEAR(centre->radius, 8, 1e-9);
}

TEST(BoreTouches, CentreOfFourTouchesHasTheUncertaintyOfOneByRootTwo) {
    const auto exact = four(0, 0, 12).centre();
    ASSERT_TRUE(exact);
    EXPECT_NEAR(exact->x_per_unit, std::sqrt(0.5), 1e-9);
    EXPECT_NEAR(exact->y_per_unit, std::sqrt(0.5), 1e-9);
    Random random(7);
    const double s = 0.5 * um;
    double square = 0;
    constexpr int bores = 4000;
    for (int i = 0; i < bores; ++i) {
        BoreTouches touches;
        for (int side = 0; side < 4; ++side) {
            const double angle = side * std::acos(0.0), radius = 12 + s * random.gaussian();
            touches.add(radius * std::cos(angle), radius * std::sin(angle));
        }
        square += std::pow(touches.centre()->x, 2);
    }
    EXPECT_NEAR(std::sqrt(square / bores), s / std::sqrt(2), 0.05 * s);
}

TEST(BoreTouches, LineTwoTouchesAndNoNumbersGiveNothing) {
    BoreTouches touches;
    EXPECT_FALSE(touches.add(NAN, 0));
    touches.add(0, 0);
    touches.add(1, 1);
    EXPECT_FALSE(touches.centre());
    touches.add(2, 2);
    touches.add(3, 3);
    EXPECT_FALSE(touches.centre());
    touches.clear();
    EXPECT_EQ(touches.count(), 0);
    for (int i = 0; i < 5; ++i) touches.add(5, 5);
    EXPECT_FALSE(touches.centre());
}

const MatrixX3d cube = (MatrixX3d(8, 3) << -60, -40, 50, 60, -40, 50, 60, 40, 50, -60, 40, 50,  //
                        -60, -40, 150, 60, -40, 150, 60, 40, 150, -60, 40, 150)
                           .finished();

TEST(RigidPart, FindsWhatMovedTheBores) {
    RigidPart::Parameters truth;
    truth << 5 * um, -3 * um, 20 * um, 30e-6, -10e-6, 15e-6, 50e-6, -20e-6, 8e-6;
    MatrixX3d deviations(8, 3);
    for (int i = 0; i < 8; ++i) deviations.row(i) = (rigid_rows(cube.row(i).transpose()) * truth).transpose();
    deviations.row(3) += Vector3d(0, 0, 2 * um).transpose();
    const RigidPart exact = rigid_part(cube, deviations);
    EXPECT_EQ(exact.rank, 9);
    for (const bool each : exact.determined) EXPECT_TRUE(each);
    EXPECT_NEAR(exact.rest.colwise().sum().norm(), 0, 1e-9);
    Eigen::Index worst = 0;
    exact.rest.rowwise().norm().maxCoeff(&worst);
    EXPECT_EQ(worst, 3);

    for (int i = 0; i < 8; ++i) deviations.row(i) = (rigid_rows(cube.row(i).transpose()) * truth).transpose();
    const RigidPart part = rigid_part(cube, deviations);
    EXPECT_NEAR((part.value - truth).cwiseAbs().maxCoeff(), 0, 1e-12);
    EXPECT_NEAR(part.rms, 0, 1e-12);
}

TEST(RigidPart, RotationsHaveTheSignsOfTheEquation) {
    const double small = 1e-6;
    for (int rotation = 0; rotation < 3; ++rotation) {
        RigidPart::Parameters turn = RigidPart::Parameters::Zero();
        turn[6 + rotation] = small;
        const Vector3d place(3, 5, 7);
        const Vector3d moved = rigid_rows(place) * turn;
        EXPECT_NEAR((moved - (small * Vector3d::Unit(rotation)).cross(place)).norm(), 0, 1e-15);
    }
}

TEST(RigidPart, PlacesInOnePlaneLeaveTheScaleAcrossItOpen) {
    const MatrixX3d plane = cube.topRows(4);
    const RigidPart part = rigid_part(plane, MatrixX3d::Constant(4, 3, 1 * um));
    EXPECT_FALSE(part.determined[2]);  // tz and sz cannot be told apart
    EXPECT_FALSE(part.determined[5]);
    EXPECT_TRUE(part.determined[3]);
    EXPECT_TRUE(part.determined[8]);
    EXPECT_NEAR(part.rest.cwiseAbs().maxCoeff(), 0, 1e-9);
    const RigidPart one = rigid_part(cube.topRows(1), MatrixX3d::Constant(1, 3, 1 * um));
    EXPECT_EQ(one.rank, 3);
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
