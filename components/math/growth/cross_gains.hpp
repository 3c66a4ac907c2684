// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/growth/swapped_sensors.hpp"

#include <Eigen/Core>

#include <array>

namespace plumb {

// Which axis a compensation displaces for the drift of which axis: c = G d + noise, over all passes.
struct CrossGains {
    Eigen::Matrix3d gain = Eigen::Matrix3d::Zero();  // row: axis of the compensation; column: of the drift
    Eigen::Matrix3d uncertainty = Eigen::Matrix3d::Zero();  // standard
    // mu rms over the passes, of c in the row's axis minus d in the column's: a good compensation has its
    // smallest on the diagonal, also where the gains are not determined.
    Eigen::Matrix3d difference = Eigen::Matrix3d::Zero();
    std::array<bool, 3> drifts{};      // columns with a drift; the others are 0
    std::array<bool, 3> determined{};  // columns that the drifts of the other axes do not imitate

    // The compensation of axis a follows the drift of axis b, and that of b the drift of a.
    bool swapped(int a, int b) const;
};

// By least squares, for the axes that drift (`drifts`). Both sides are uncertain; the first pass is the
// reference of all. A column is determined if each of its gains has an uncertainty below 0.25. Three axes
// that two sources of heat displace are not; two of them alone may be.
CrossGains cross_gains(const CompensationRecord& record, const std::array<bool, 3>& drifts);

}  // namespace plumb
