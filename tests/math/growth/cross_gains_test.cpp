// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/random.hpp"
#include "components/math/growth/compensation_effect.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>

namespace plumb {
namespace {

constexpr double um = 1e-3;
constexpr std::array<bool, 3> all{true, true, true};

// Axes that warm with time constants of their own; a pass every half an hour.
CompensationRecord record_of(const Eigen::Matrix3d& gain, int passes = 10) {
    CompensationRecord record;
    record.uncertainty = 0.3 * um;
    record.drift.resize(passes, 3);
    record.compensation.resize(passes, 3);
    for (int k = 0; k < passes; ++k) {
        const double t = 0.5 * k;
        record.drift.row(k) = -Eigen::RowVector3d(20 * std::expm1(-t / 0.4), -25 * std::expm1(-t / 3),
                                                  60 * std::expm1(-t) + 20 * t * std::exp(-t)) *
                              um;
        record.compensation.row(k) = (gain * record.drift.row(k).transpose()).transpose();
    }
    return record;
}

TEST(CrossGains, AreThoseOfTheCompensationWhateverItsOrigin) {
    Eigen::Matrix3d gain;
    gain << 0.9, 0.1, 0, -0.2, 1, 0.3, 0, 0.4, -1;
    CompensationRecord record = record_of(gain);
    record.compensation.rowwise() += Eigen::RowVector3d(3, -2, 7) * um;
    const CrossGains found = cross_gains(record, all);
    EXPECT_LT((found.gain - gain).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_EQ(found.determined, all);
}

TEST(CrossGains, TwoUncertaintiesCoverThem) {
    Random random(3);
    int covered = 0, gains = 0;
    for (int i = 0; i < 300; ++i) {
        const Eigen::Matrix3d gain = Eigen::Matrix3d::NullaryExpr([&] { return random.uniform(-1, 1.2); });
        CompensationRecord record = record_of(gain);
        for (int k = 0; k < record.drift.rows(); ++k)
            for (int axis = 0; axis < 3; ++axis)
                record.drift(k, axis) += record.uncertainty * random.gaussian();
        record.drift.rowwise() -= record.drift.row(0).eval();
        const CrossGains found = cross_gains(record, all);
        covered += static_cast<int>(
            ((found.gain - gain).cwiseAbs().array() <= 2 * found.uncertainty.array()).count());
        gains += 9;
    }
    EXPECT_GE(covered, 0.9 * gains);
}

TEST(CrossGains, AxesThatDriftAlikeAreNotDetermined) {
    CompensationRecord record = record_of(Eigen::Matrix3d::Identity());
    Random random(4);
    for (int k = 1; k < record.drift.rows(); ++k)
        record.drift(k, 1) = 0.5 * record.drift(k, 2) + 0.1 * um * random.gaussian();
    const CrossGains found = cross_gains(record, all);
    EXPECT_TRUE(found.determined[0]);
    EXPECT_FALSE(found.determined[1]);
    EXPECT_FALSE(found.swapped(1, 2));
}

TEST(CrossGains, AnAxisThatDoesNotDriftHasNone) {
    const CrossGains found = cross_gains(record_of(Eigen::Matrix3d::Identity()), {true, false, true});
    EXPECT_FALSE(found.determined[1]);
    EXPECT_EQ(found.gain.col(1).norm(), 0);
    EXPECT_NEAR(found.gain(2, 2), 1, 1e-9);
    EXPECT_EQ(cross_gains(record_of(Eigen::Matrix3d::Identity(), 3), all).determined,
              (std::array<bool, 3>{}));
}

TEST(CrossGains, ShowAxesThatAreSwapped) {
    Eigen::Matrix3d gain = Eigen::Matrix3d::Zero();
    gain(0, 0) = 1;
    gain(1, 2) = gain(2, 1) = 0.6;
    const CrossGains found = cross_gains(record_of(gain), all);
    EXPECT_TRUE(found.swapped(1, 2));
    EXPECT_FALSE(found.swapped(0, 1));
    EXPECT_LT(found.difference(0, 0), 1e-9);
    EXPECT_LT(found.difference(2, 1), found.difference(2, 2));
    const Eigen::MatrixX3d drift = record_of(gain).drift;
    EXPECT_NEAR(found.difference(0, 1), (drift.col(0) - drift.col(1)).norm() / 3, 1e-9);
    EXPECT_FALSE(cross_gains(record_of(Eigen::Matrix3d::Identity()), all).swapped(1, 2));
}

}  // namespace
}  // namespace plumb
