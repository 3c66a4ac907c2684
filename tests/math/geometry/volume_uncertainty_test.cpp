// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/geometry/volume_uncertainty.hpp"

#include <gtest/gtest.h>

#include <cmath>

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
