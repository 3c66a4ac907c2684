// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/tilt.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumb {
namespace {

constexpr double urad = 1e-6;  // rad

// As set: how an axis leans, and which quantity of ISO 230-1 that is.
const struct {
    Axis axis, towards;
    int sign;
    const char* quantity;
    int quantity_sign;
} table[] = {
    {Axis::Y, Axis::X, 1, "EC0Y", -1}, {Axis::Y, Axis::X, -1, "EC0Y", 1},
    {Axis::Y, Axis::Z, 1, "EA0Y", 1},  {Axis::Y, Axis::Z, -1, "EA0Y", -1},
    {Axis::Z, Axis::X, 1, "EB0Z", 1},  {Axis::Z, Axis::X, -1, "EB0Z", -1},
    {Axis::Z, Axis::Y, 1, "EA0Z", -1}, {Axis::Z, Axis::Y, -1, "EA0Z", 1},
    {Axis::W, Axis::X, 1, "EB0W", 1},  {Axis::W, Axis::X, -1, "EB0W", -1},
    {Axis::W, Axis::Y, 1, "EA0W", -1}, {Axis::W, Axis::Y, -1, "EA0W", 1},
    {Axis::X, Axis::Y, 1, "EC0X", 1},  {Axis::X, Axis::Y, -1, "EC0X", -1},
    {Axis::X, Axis::Z, 1, "EB0X", -1}, {Axis::X, Axis::Z, -1, "EB0X", 1},
};

TEST(Tilt, IsTheQuantityAndSignOfItsDirection) {
    for (const auto& row : table) {
        const Eigen::Vector3d angles = squareness(row.axis, {{row.towards, row.sign, 50 * urad}});
        for (int i = 0; i < 3; ++i) {
            const bool named = squareness_name(row.axis, i) == row.quantity;
            EXPECT_EQ(angles[i], named ? row.quantity_sign * 50 * urad : 0) << row.quantity;
        }
    }
}

TEST(Tilt, LeansToTheSideOfItsQuantity) {
    for (const auto& row : table) {
        const auto back = leans(row.axis, squareness(row.axis, {{row.towards, row.sign, 50 * urad}}));
        ASSERT_EQ(back.size(), 1u);
        EXPECT_EQ(back[0].towards, row.towards);
        EXPECT_EQ(back[0].sign, row.sign);
        EXPECT_EQ(back[0].angle, 50 * urad);
    }
}

TEST(Tilt, MayLeanTwoWaysAtOnce) {
    const Eigen::Vector3d angles = squareness(Axis::Y, {{Axis::X, 1, 80 * urad}, {Axis::Z, 1, 60 * urad}});
    EXPECT_EQ(angles, Eigen::Vector3d(60 * urad, 0, -80 * urad));
    EXPECT_EQ(leans(Axis::Y, angles).size(), 2u);
    EXPECT_TRUE(leans(Axis::Y, Eigen::Vector3d(0, 10 * urad, 0)).empty());
}

TEST(Tilt, RefusalNamesAxisDirectionAndValue) {
    const auto refusal = [](Axis axis, const std::vector<Lean>& directions) -> std::string {
        try {
            squareness(axis, directions);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_EQ(refusal(Axis::Z, {{Axis::X, 1, 1e-5}, {Axis::Y, 1, 1e-5}, {Axis::X, -1, 1e-5}}),
              "axis Z cannot lean towards +X and -X at once: choose one");
    EXPECT_EQ(refusal(Axis::Y, {{Axis::Z, -1, 1e-5}, {Axis::Z, -1, 2e-5}}),
              "axis Y leans towards -Z twice: choose one");
    EXPECT_EQ(refusal(Axis::W, {{Axis::Z, 1, 1e-5}}), "axis W cannot lean towards +Z: it moves along it");
    EXPECT_EQ(refusal(Axis::X, {{Axis::Y, 1, 45}}),
              "axis X cannot lean towards +Y by 45.000000 rad: 0 to 0.1 is possible");
    EXPECT_EQ(refusal(Axis::X, {{Axis::Y, 1, -0.5}}),
              "axis X cannot lean towards +Y by -0.500000 rad: 0 to 0.1 is possible");
    EXPECT_NE(refusal(Axis::X, {{Axis::Y, 1, std::numeric_limits<double>::quiet_NaN()}}), "accepted");
}

TEST(Tilt, AnglesConvertBothWays) {
    EXPECT_NEAR(angle_from_arcsec(3600), std::acos(-1) / 180, 1e-15);
    EXPECT_NEAR(angle_from_arcsec(1), 4.8481 * urad, 1e-4 * urad);
    EXPECT_NEAR(arcsec_from_angle(angle_from_arcsec(-45)), -45, 1e-12);
    EXPECT_NEAR(angle_from_slope(0.02 / 300), 66.6667 * urad, 1e-4 * urad);
    EXPECT_NEAR(slope_from_angle(angle_from_slope(50e-6)), 50e-6, 1e-18);
}

}  // namespace
}  // namespace plumb
