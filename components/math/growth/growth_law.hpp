// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/first_order_lag.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace plumb {

// How the axes of a machine grow, by the temperatures T of its parts and by its spindle. For each axis, at
// its position P:
//
//     d = K0(T) + tan(beta)(T) (P - P0)        K0 = sum of k_i D_i + s x
//     tan(beta) = sum of b_i D_i               tau x' = (n / n0)^p - x
//
// D_i is the rise T_i - R_i.
//
// d is the distance by which the axis must be displaced so that the tip is where it was on the cold machine.
struct GrowthLaw {
    static constexpr int sensors = 4;
    using PerSensor = Eigen::Matrix<double, 3, sensors>;
    using Temperatures = Eigen::Matrix<double, sensors, 1>;

    PerSensor growth = PerSensor::Zero();                // k, mu/K
    PerSensor slope = PerSensor::Zero();                 // b, 1/K
    Eigen::Vector3d by_speed = Eigen::Vector3d::Zero();  // s, mu
    Temperatures reference = Temperatures::Zero();       // R, degC
    Eigen::Vector3d pivot = Eigen::Vector3d::Zero();     // P0, mu

    static constexpr double steepest = 1e-3;  // of tan(beta), either way

    // What the law comes to at these temperatures, for the position to follow.
    struct Line {
        Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // K0, mu
        Eigen::Vector3d slope = Eigen::Vector3d::Zero();   // tan(beta)

        Eigen::Vector3d at(const Eigen::Vector3d& position, const Eigen::Vector3d& pivot) const noexcept {
            return offset + slope.cwiseProduct(position - pivot);
        }
    };

    // D of these temperatures.
    Temperatures rises(const Temperatures& temperatures) const noexcept { return temperatures - reference; }

    // `rise` is D, `driven` x. tan(beta) stays within ±steepest.
    Line at(const Temperatures& rise, double driven) const noexcept {
        return {growth * rise + by_speed * driven, (slope * rise).cwiseMax(-steepest).cwiseMin(steepest)};
    }

    bool uses(int sensor) const noexcept {
        return !growth.col(sensor).isZero(0) || !slope.col(sensor).isZero(0);
    }
    bool uses_speed() const noexcept { return !by_speed.isZero(0); }
    bool operator==(const GrowthLaw& other) const noexcept {
        return growth == other.growth && slope == other.slope && by_speed == other.by_speed &&
               reference == other.reference && pivot == other.pivot;
    }
    bool is_empty() const noexcept { return growth.isZero(0) && slope.isZero(0) && !uses_speed(); }
};

// x of the law above: what the spindle has been driven to.
class SpindleDrive {
public:
    struct Settings {
        double reference_speed = 5000;                   // n0, rpm
        double exponent = 1.7;                           // p
        double turning_time = 600, stopped_time = 2400;  // tau, s
    };

    // Speed in rpm, finite; dt > 0 in s.
    double step(double speed, const Settings& settings, double dt) noexcept {
        if (speed != speed_ || settings.exponent != exponent_ || settings.reference_speed != reference_) {
            speed_ = speed;
            exponent_ = settings.exponent;
            reference_ = settings.reference_speed;
            drive_ = std::min(std::pow(std::abs(speed) / reference_, exponent_), 1e3);
        }
        return lag_.step(drive_, std::abs(speed) < 1 ? settings.stopped_time : settings.turning_time, dt);
    }
    double value() const noexcept { return lag_.value(); }

private:
    double speed_ = 0, exponent_ = 0, reference_ = 0, drive_ = 0;
    FirstOrderLag lag_;
};

}  // namespace plumb
