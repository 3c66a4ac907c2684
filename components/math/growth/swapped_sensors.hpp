// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <cmath>

namespace plumb {

// The passes of a test, of which the first one is cold.
struct CompensationRecord {
    Eigen::MatrixX3d drift;         // mu, of each pass, without compensation; 0 in the first
    Eigen::MatrixX3d compensation;  // mu, as applied in each pass, and not relative to the first
    Eigen::MatrixXd temperatures;   // degC, a column for each logged sensor; no columns if none is logged
    // The same at each visit of a bore, by which the law of the compensation is found; the above if there are
    // no rows.
    Eigen::MatrixXd visit_temperatures;
    Eigen::MatrixX3d visit_compensation;
    double uncertainty = 0.001;  // mu, of a drift
    double millimetres = 1;      // in a machine unit
};

// The exchange of two sensors with which the compensation would leave least of the drift.
struct SwappedSensors {
    int sensor = -1, other_sensor = -1;
    double rest = HUGE_VAL;  // mu², of all passes; infinite if there is no law to exchange them in
};

// The law is taken in as few sensors as follow the compensation about as well as all of them: others that
// happen to warm like them would share their part. `c` is the compensation relative to the first
// pass.
SwappedSensors swapped_sensors(const CompensationRecord& record, const Eigen::MatrixX3d& c);

}  // namespace plumb
