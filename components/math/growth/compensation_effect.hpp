// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/growth/cross_gains.hpp"
#include "components/math/growth/swapped_sensors.hpp"

#include <Eigen/Core>

#include <array>

namespace plumb {

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
    // What would determine a compensation that is not determined: more passes of the machine as warm as in the
    // last one (0: no number of them), or a larger drift along an axis (mu; 0: the drift is large enough).
    int more_passes = 0;
    double larger_drift = 0;
    CrossGains cross;
};

// Names the fault that explains the record best. Swapped axes are named by their residual, or by the cross
// gains where the drifts of the axes differ enough. A compensation that is absent and one whose sensor is
// frozen differ only where that sensor is logged. Sensors that nobody uses have no effect, and are not named
// unless the compensation fails.
CompensationFinding judged_compensation(const CompensationRecord& record);

// Between these gains, surely, a compensation is good.
constexpr double weakest_good_gain = 0.8, strongest_good_gain = 1.25;

}  // namespace plumb
