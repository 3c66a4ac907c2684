// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/volume_uncertainty.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

namespace plumb {
namespace {

MeasuredVolume column() {
    MeasuredVolume m;
    m.chain.axes = AxisChainReader::read("w-X.b-Y-Z-t");
    return m;
}

constexpr int draws = 4000;

// e_X = -EC0Y (y + T_y) + EB0Z (z + T_z), and so on, in closed form.
TEST(VolumeUncertainty, IsThatOfTheClosedFormForTilts) {
    MeasuredVolume m = column();
    m.chain.tilts[1].angles.z() = -80e-6;
    m.sources.push_back({"EC0Y", {{1, 2, 4e-6}}, {}});
    m.sources.push_back({"EB0Z", {{2, 1, 6e-6}}, {}});
    const VolumePlace reference{{0, 0, 0, 0}, {0, 0, -200}, ""}, place{{0, 600, -500, 0}, {0, 0, -200}, ""};
    const VolumeUncertainty r = uncertainty_of(m, reference, {place}, draws, 1);
    const double expected = 2 * std::hypot(4e-6 * 600, 6e-6 * 500);
    EXPECT_NEAR(r.places[0].by_axis.x(), expected, 0.05 * expected);
    EXPECT_NEAR(r.places[0].by_axis.y(), 0, 1e-6);
    EXPECT_NEAR(r.places[0].U, expected, 0.05 * expected);
    EXPECT_NEAR(r.places[0].rest.norm(), 0, 1e-9);
    EXPECT_NEAR(r.places[0].distance, std::hypot(600, 500), 1e-9);
    EXPECT_EQ(r.shares[0].name, "EB0Z");
    EXPECT_NEAR(r.shares[0].part, 9.0 / (9 + 5.76), 0.01);
}

// e(q) - e(q0) = w_Y x (dy + dz) + w_Z x dz + scale: all axes, by the covariance of the causes in closed
// form.
TEST(VolumeUncertainty, IsWithinFivePerCentOfTheClosedFormInAllDirections) {
    using Eigen::Vector3d;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u_angle(1e-6, 9e-6), place(100, 800), u_scale(0.5e-6, 4e-6),
        u_length(1e-4, 1e-3);
    double worst = 0;
    for (int n = 0; n < 12; ++n) {
        MeasuredVolume m = column();
        const VolumePlace reference{{0, 0, 0, 0}, {30, -20, -200}, ""};
        VolumePlace there = reference;
        there.position << place(random), place(random), -place(random), 0;
        const Vector3d y(0, there.position.y(), 0), z(0, 0, there.position.z());
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        const auto add = [&](const Vector3d& effect) { covariance += effect * effect.transpose(); };
        for (int rotation = 0; rotation < 3; ++rotation) {
            const double of_y = u_angle(random), of_z = u_angle(random);
            m.sources.push_back({"Y", {{1, rotation, of_y}}, {}});
            m.sources.push_back({"Z", {{2, rotation, of_z}}, {}});
            add(of_y * Vector3d::Unit(rotation).cross(y + z));
            add(of_z * Vector3d::Unit(rotation).cross(z));
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double scale = u_scale(random);
            UncertaintySource common{"scale", {}, {}};
            for (std::size_t row = 0; row < 3; ++row) {
                const double at = -1000 + 1000 * static_cast<double>(row);
                m.means[axis].push_back({at, {}});
                common.rows.push_back({axis, row, axis, scale * at});
            }
            m.sources.push_back(common);
            const auto k = static_cast<Eigen::Index>(axis);
            add(scale * there.position[k] * Vector3d::Unit(k));
        }
        UncertaintySource repeat{"repeatability", {}, {}};
        repeat.tip.y() = u_length(random);
        m.sources.push_back(repeat);
        add(std::sqrt(2) * repeat.tip);
        const PlaceUncertainty r =
            uncertainty_of(m, reference, {there}, draws, static_cast<std::uint64_t>(n)).places[0];
        const Vector3d expected = 2 * covariance.diagonal().cwiseSqrt();
        for (int i = 0; i < 3; ++i) worst = std::max(worst, std::abs(r.by_axis[i] / expected[i] - 1));
        const double U =
            2 * std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues()[2]);
        worst = std::max(worst, std::abs(r.U / U - 1));
    }
    EXPECT_LT(worst, 0.05);
    std::printf("U differs from its closed form by at most %.1f %%\n", 100 * worst);
}

// The mean of both columns is half of the lost motion off, in each axis.
TEST(VolumeUncertainty, AnUnknownDirectionAddsHalfOfTheLostMotion) {
    MeasuredVolume m = column();
    const VolumePlace place{{400, 300, 0, 0}, Eigen::Vector3d::Zero(), ""};
    EXPECT_EQ(uncertainty_of(m, {}, {place}, 100, 1).places[0].unknown, 0);
    for (const double at : {0.0, 1000.0})
        for (std::size_t axis = 0; axis < 2; ++axis) {
            m.means[axis].push_back({at, {}});
            m.halves[axis].push_back({at, {}});
            m.halves[axis].back().errors[axis] = axis == 0 ? -0.003 : -0.004;
        }
    EXPECT_NEAR(uncertainty_of(m, {}, {place}, 100, 1).places[0].unknown, 0.005, 1e-6);
    EXPECT_NEAR(uncertainty_of(m, {}, {place}, 100, 1).places[0].rest.norm(), 0, 1e-9);
}

// The common part is drawn once for all rows: drawn for each, it would shrink.
TEST(VolumeUncertainty, CommonPartsOfATableMoveAllRowsTogether) {
    MeasuredVolume m = column();
    for (int i = 0; i <= 10; ++i) m.means[1].push_back({60.0 * i, {}});
    UncertaintySource together{"EYY, all rows together", {}, {}};
    for (std::size_t row = 0; row <= 10; ++row)
        together.rows.push_back({1, row, 1, 1e-6 * 60 * static_cast<double>(row)});
    m.sources.push_back(together);
    const VolumePlace reference{}, place{{0, 570, 0, 0}, Eigen::Vector3d::Zero(), ""};
    const double U = uncertainty_of(m, reference, {place}, draws, 1).places[0].U;
    EXPECT_NEAR(U, 2 * 570e-6, 0.05 * 2 * 570e-6);
}

TEST(VolumeUncertainty, OneCauseOfTwoAnglesIsNotTwoCauses) {
    MeasuredVolume apart = column(), together = column();
    apart.sources.push_back({"a", {{1, 2, 5e-6}}, {}});
    apart.sources.push_back({"b", {{2, 1, 5e-6}}, {}});
    together.sources.push_back({"both", {{1, 2, 5e-6}, {2, 1, 5e-6}}, {}});
    const VolumePlace reference{}, place{{0, 500, -500, 0}, Eigen::Vector3d::Zero(), ""};
    // -500 EC0Y - 500 EB0Z: both of one cause add up.
    EXPECT_NEAR(uncertainty_of(together, reference, {place}, draws, 1).places[0].U, 0.010, 0.0005);
    EXPECT_NEAR(uncertainty_of(apart, reference, {place}, draws, 1).places[0].U, 0.010 / std::sqrt(2),
                0.0004);
}

TEST(VolumeUncertainty, RepeatabilityCountsAtBothPlacesAndTheToolsLengthAtNone) {
    MeasuredVolume m = column();
    UncertaintySource repeat{"repeatability", {}, {}}, length{"tool length", {}, {}};
    repeat.tip.x() = 0.001;
    length.tool.z() = 0.005;
    m.sources = {repeat, length};
    const VolumePlace reference{}, place{{100, 0, 0, 0}, Eigen::Vector3d::Zero(), ""};
    const PlaceUncertainty r = uncertainty_of(m, reference, {place}, draws, 1).places[0];
    EXPECT_NEAR(r.by_axis.x(), 0.002 * std::sqrt(2), 0.00015);
    EXPECT_NEAR(r.by_axis.z(), 0, 1e-9);
}

// U is of the distance, so it is 0 at the reference place; with another tool the lever counts.
TEST(VolumeUncertainty, TheLeverOfTheToolCountsAndTheReferencePlaceIsCertain) {
    MeasuredVolume m = column();
    m.sources.push_back({"EB0Z", {{2, 1, 5e-6}}, {}});
    const VolumePlace reference{{300, 200, -100, 0}, {0, 0, -100}, ""};
    VolumePlace longer = reference;
    longer.tool.z() = -300;
    const VolumeUncertainty r = uncertainty_of(m, reference, {reference, longer}, draws, 1);
    EXPECT_NEAR(r.places[0].U, 0, 1e-9);
    EXPECT_NEAR(r.places[1].U, 2 * 5e-6 * 200, 1e-4);
}

TEST(VolumeUncertainty, HalvesByDirectionCountInEitherDirection) {
    MeasuredVolume m = column();
    for (const double x : {0.0, 1000.0}) {
        m.means[0].push_back({x, {}});
        m.halves[0].push_back({x, {-0.005, 0, 0, 0, 0, 0}});
    }
    m.sources.push_back({"EXX", {}, {{0, 0, 0, 0.001, true}, {0, 1, 0, 0.001, true}}});
    const VolumePlace reference{}, place{{400, 0, 0, 0}, Eigen::Vector3d::Zero(), ""};
    const PlaceUncertainty r = uncertainty_of(m, reference, {place}, draws, 1).places[0];
    EXPECT_NEAR(r.rest.norm(), 0, 1e-9);
    // +-a at the place and +-a at the reference place, in either direction.
    EXPECT_NEAR(r.by_axis.x(), 0.002 * std::sqrt(2), 0.0002);
}

TEST(VolumeUncertainty, WhatTheBoundKeepsBackIsTheRest) {
    MeasuredVolume m = column();
    m.chain.tilts[1].angles.z() = -100e-6;
    m.max_correction = 0.04;
    const VolumePlace reference{}, place{{0, 600, 0, 0}, Eigen::Vector3d::Zero(), ""};
    EXPECT_NEAR(uncertainty_of(m, reference, {place}, 100, 1).places[0].rest.x(), 0.02, 1e-6);
}

TEST(VolumeUncertainty, ASeedGivesTheSameBits) {
    MeasuredVolume m = column();
    m.sources.push_back({"EC0Y", {{1, 2, 4e-6}}, {}});
    const VolumePlace reference{}, place{{0, 600, 0, 0}, Eigen::Vector3d::Zero(), ""};
    EXPECT_EQ(uncertainty_of(m, reference, {place}, 500, 7).places[0].U,
              uncertainty_of(m, reference, {place}, 500, 7).places[0].U);
    EXPECT_NE(uncertainty_of(m, reference, {place}, 500, 8).places[0].U,
              uncertainty_of(m, reference, {place}, 500, 7).places[0].U);
}

}  // namespace
}  // namespace plumb
