// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
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

// How much of a drift a compensation removes along one axis.
struct CompensationGain {
    double gain = 0;           // 0 not applied, 1 perfect, -1 wrong sign, above 1 too much
    double uncertainty = 0;    // standard
    double effectiveness = 0;  // 1 - max|on| / max|off|
    bool determined = false;   // false: there was no drift to compensate
};

// From the deviations of each pass without and with compensation (mu), each with the same uncertainty, which
// is that of the reference pass, too. g = sum((off - on) off) / sum(off^2).
CompensationGain compensation_gain(const Eigen::VectorXd& off, const Eigen::VectorXd& on, double uncertainty);

enum class CompensationFault {
    none,          // the compensation does as it should
    undetermined,  // no drift large enough, or too few passes: see CompensationFinding
    absent,        // the compensation does nothing
    wrong_sign,
    too_weak,
    too_strong,
    swapped_axes,
    frozen_sensor,
    sensor_offset,
    swapped_sensors,
    other,  // it does not remove the drift, in no way that has a name here
};

const char* sentence(CompensationFault fault);

struct CompensationFinding {
    CompensationFault fault = CompensationFault::undetermined;
    int axis = -1, other_axis = -1;      // that it concerns, 0 X, 1 Y, 2 Z; -1 for none
    int sensor = -1, other_sensor = -1;  // columns of the temperatures; -1 for none
    double gain = 0;                     // over all axes that drift
    double gain_low = 0, gain_high = 0;  // 95 of 100 between; both 0 if it is no matter of the gain
    std::array<bool, 3> drifts{};        // axes with enough drift to judge
    // What would determine a compensation that is not determined: more passes of the machine as warm as in
    // the last one (0: no number of them), or a larger drift along an axis (mu; 0: the drift is large
    // enough).
    int more_passes = 0;
    double larger_drift = 0;
    // mu rms over the passes, of the compensation in the row's axis minus the drift in the column's: a good
    // compensation has its smallest on the diagonal.
    Eigen::Matrix3d difference = Eigen::Matrix3d::Zero();
};

// Names the fault that explains the record best. A compensation that is absent and one whose sensor is
// frozen differ only where that sensor is logged. Sensors that nobody uses have no effect, and are not named
// unless the compensation fails.
CompensationFinding judged_compensation(const CompensationRecord& record);

// Between these gains, surely, a compensation is good.
constexpr double weakest_good_gain = 0.8, strongest_good_gain = 1.25;

}  // namespace plumb
