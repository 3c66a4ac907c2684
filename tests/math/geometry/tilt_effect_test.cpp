// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/squareness_of_chain.hpp"

#include <gtest/gtest.h>

namespace plumb {
namespace {

TiltEffect effect(const char* chain, Axis axis, int rotation, TiltReading reading = TiltReading::component,
                  TiltDatum datum = TiltDatum::rail) {
    return effect_of_tilt(AxisChainReader::read(chain), reading, datum, axis, rotation);
}

constexpr int about_x = 0, about_z = 2;

// e_X = -EC0Y (y + T_y), e_Y = EC0Y T_x - EA0Y T_z, e_Z = EA0Y (y + T_y)
TEST(TiltEffect, IsThatOfTheEquationsOfAColumn) {
    const TiltEffect ec0y = effect("w-Z.b-X-Y-C-t", Axis::Y, about_z);
    PositionSlopes travel = PositionSlopes::Zero();
    travel(0, 1) = -1;
    EXPECT_EQ(ec0y.travel, travel);
    Eigen::Matrix3d tool;
    tool << 0, -1, 0, 1, 0, 0, 0, 0, 0;
    EXPECT_EQ(ec0y.tool, tool);
    EXPECT_EQ(ec0y.opening(Axis::X, Axis::Y), 1);
    EXPECT_EQ(ec0y.opening(Axis::Y, Axis::X), 1);
    EXPECT_EQ(ec0y.opening(Axis::Y, Axis::Z), 0);

    const TiltEffect ea0y = effect("w-Z.b-X-Y-C-t", Axis::Y, about_x);
    travel.setZero();
    travel(2, 1) = 1;
    EXPECT_EQ(ea0y.travel, travel);
    tool << 0, 0, 0, 0, 0, -1, 0, 1, 0;
    EXPECT_EQ(ea0y.tool, tool);
}

TEST(TiltEffect, OfATableThatTurnsWithTheOtherAxisIsNoneInTravel) {
    const TiltEffect lower = effect("w-X-Y.b-Z-C-t", Axis::Y, about_z);
    EXPECT_FALSE(lower.shows_in_travel());
    EXPECT_TRUE(lower.shows_in_tool());
    EXPECT_TRUE(effect("w-X-Y.b-Z-C-t", Axis::X, about_z).shows_in_travel());
    EXPECT_TRUE(effect("w-X-Y.b-Z-C-t", Axis::Y, about_x).shows_in_travel()) << "against Z";
    EXPECT_TRUE(effect("w-X-Y.b-Z-C-t", Axis::Y, about_z, TiltReading::axis_direction).shows_in_travel())
        << "where X keeps its direction";
}

TEST(TiltEffect, OfARailDependsOnReadingAndDatum) {
    const char* const portal = "w-X.b-W-Y-Z-C-t";
    const auto z_by_w = [&](TiltReading reading, TiltDatum datum) {
        return effect(portal, Axis::W, about_x, reading, datum).travel(1, coordinate(Axis::Z));
    };
    EXPECT_EQ(z_by_w(TiltReading::component, TiltDatum::rail), -1);
    EXPECT_EQ(z_by_w(TiltReading::axis_direction, TiltDatum::rail), -1);
    EXPECT_EQ(z_by_w(TiltReading::component, TiltDatum::bed), 0);
    EXPECT_EQ(effect(portal, Axis::W, about_x).travel(1, coordinate(Axis::W)), -1);
    EXPECT_EQ(effect(portal, Axis::W, about_x).travel(2, coordinate(Axis::Y)), 1) << "Y turns with the rail";
    EXPECT_EQ(effect(portal, Axis::W, about_x, TiltReading::axis_direction).travel(2, coordinate(Axis::Y)),
              0);
}

}  // namespace
}  // namespace plumb
