// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <gtest/gtest.h>
#include <Eigen/Core>

namespace plumb {

// The distance between two points is below the tolerance.
inline void expect_near(const Eigen::Vector3d& actual, const Eigen::Vector3d& expected, double tolerance) {
    EXPECT_LT((actual - expected).norm(), tolerance)
        << actual.transpose() << " is not " << expected.transpose();
}

}  // namespace plumb
