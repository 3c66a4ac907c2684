// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/error_table.hpp"
#include "components/math/geometry/kinematic_chain.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

// A cause of uncertainty: by `u` it changes angles, rows of tables, and the tip itself, all together.
struct UncertaintySource {
    struct Angle {
        std::size_t axis;  // coordinate
        int rotation;      // 0 A, 1 B, 2 C
        double factor;     // rad
    };
    struct Row {
        std::size_t axis, row, error;
        double factor;      // mm or rad
        bool half = false;  // of the half difference by direction, not of the mean
    };
    std::string name;  // causes of one name are summed in the list of shares
    std::vector<Angle> angles;
    std::vector<Row> rows;
    Eigen::Vector3d tool = Eigen::Vector3d::Zero();  // mm
    Eigen::Vector3d tip = Eigen::Vector3d::Zero();   // mm; drawn anew at each place: repeatability
};

// A machine as it was measured, in mm and rad, and how well.
struct MeasuredVolume {
    KinematicChain::Settings chain;
    AxisPosition pivot = AxisPosition::Zero();
    PerAxis<std::vector<ErrorTable::Row>> means, halves;  // of the tables; no rows for no table
    double max_correction = 1;                            // mm
    std::vector<UncertaintySource> sources;
};

struct VolumePlace {
    AxisPosition position = AxisPosition::Zero();
    Eigen::Vector3d tool = Eigen::Vector3d::Zero();  // from the gauge point to the tip
    std::string name;                                // of the tool
};

// Of the distance from the reference place, after correction, k = 2.
struct PlaceUncertainty {
    double U = 0;                                       // mm, in the worst direction
    Eigen::Vector3d by_axis = Eigen::Vector3d::Zero();  // mm
    Eigen::Vector3d rest = Eigen::Vector3d::Zero();     // mm, known and not corrected
    Eigen::Vector3d without = Eigen::Vector3d::Zero();  // mm, known, if nothing were corrected
    double unknown = 0;                                 // mm, more, if no direction of motion is known there
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double distance = 0;  // mm, to the reference place
};

struct Share {
    std::string name;
    double part = 0;  // of the variance in the worst direction, 0 to 1
};

struct VolumeUncertainty {
    std::vector<PlaceUncertainty> places;
    std::size_t worst = 0;
    std::vector<Share> shares;  // at the worst place, the largest first
};

// Each draw makes a machine from the measured one and its sources: true = measured + u. It is corrected by
// the measured values. Reproducible by its seed.
VolumeUncertainty uncertainty_of(const MeasuredVolume& measured, const VolumePlace& reference,
                                 const std::vector<VolumePlace>& places, int draws, std::uint64_t seed);

}  // namespace plumb
