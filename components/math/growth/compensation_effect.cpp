// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/compensation_effect.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace plumb {

CompensationGain compensation_gain(const Eigen::VectorXd& off, const Eigen::VectorXd& on,
                                   double uncertainty) {
    CompensationGain result;
    const double square = off.squaredNorm();
    const auto count = static_cast<double>(off.size());
    const double largest = off.size() > 0 ? off.cwiseAbs().maxCoeff() : 0;
    if (off.size() < 2 || off.size() != on.size() || !(largest > 4 * uncertainty) || !(square > 0))
        return result;
    result.gain = (off - on).dot(off) / square;
    // on = h off + rest, h = 1 - gain: both sides are uncertain, and the reference is common to all passes.
    const double h = 1 - result.gain;
    const double rest = (on - h * off).squaredNorm() / (count - 1);
    const double single = std::max(rest, (1 + h * h) * uncertainty * uncertainty);
    const double common = (1 + h * h) * uncertainty * uncertainty * off.sum() * off.sum() / square;
    result.uncertainty = std::sqrt((single + common) / square);
    result.effectiveness = 1 - on.cwiseAbs().maxCoeff() / largest;
    result.determined = true;
    return result;
}

const char* sentence(CompensationFault fault) {
    switch (fault) {
        case CompensationFault::none: return "The compensation removes the drift.";
        case CompensationFault::undetermined:
            return "The drift is too small, or the passes are too few, to judge the compensation.";
        case CompensationFault::absent:
            return "The compensation does nothing. If a sensor that is not logged were frozen, this would "
                   "look the same.";
        case CompensationFault::wrong_sign: return "The compensation has the wrong sign.";
        case CompensationFault::too_weak: return "The compensation is too weak.";
        case CompensationFault::too_strong: return "The compensation is too strong.";
        case CompensationFault::swapped_axes: return "The compensation of two axes is swapped.";
        case CompensationFault::frozen_sensor:
            return "A temperature sensor is frozen, and the compensation does not follow the machine.";
        case CompensationFault::sensor_offset:
            return "A temperature sensor has an offset, and the compensation is wrong on the cold machine.";
        case CompensationFault::swapped_sensors:
            return "Two temperature sensors are swapped, and the compensation follows the wrong one.";
        case CompensationFault::other:
            return "The compensation does not remove the drift, and none of the known faults explains it.";
    }
    return "";
}

namespace compensation_fault {
namespace {

constexpr double weak = 0.9, strong = 1.15;  // gains between these are good
constexpr double still = 0.02;               // K, less than the noise of a sensor that works
constexpr double warmed = 1;                 // K, a machine that has warmed
constexpr double apart = 1.5;                // K, between sensors of a machine that is cold throughout

double range(const Eigen::VectorXd& values) {
    return values.maxCoeff() - values.minCoeff();
}

// The sensor that stands still while another one warms; -1 for none.
int frozen_sensor(const Eigen::MatrixXd& temperatures) {
    int found = -1;
    double most = 0;
    for (int i = 0; i < temperatures.cols(); ++i) {
        most = std::max(most, range(temperatures.col(i)));
        if (range(temperatures.col(i)) < still && found < 0) found = i;
    }
    return most > warmed ? found : -1;
}

// The sensor that differs from the median of all on the cold machine; -1 for none.
int displaced_sensor(const Eigen::MatrixXd& temperatures) {
    if (temperatures.cols() < 3) return -1;
    std::vector<double> cold(temperatures.row(0).begin(), temperatures.row(0).end());
    std::nth_element(cold.begin(), cold.begin() + static_cast<std::ptrdiff_t>(cold.size() / 2), cold.end());
    const double median = cold[cold.size() / 2];
    int found = -1;
    double most = apart;
    for (int i = 0; i < temperatures.cols(); ++i)
        if (std::abs(temperatures(0, i) - median) > most) {
            most = std::abs(temperatures(0, i) - median);
            found = i;
        }
    return found;
}

}  // namespace
}  // namespace compensation_fault

CompensationFinding judged_compensation(const CompensationRecord& record) {
    using namespace compensation_fault;
    CompensationFinding finding;
    const Eigen::Index passes = record.drift.rows();
    if (passes < 4) return finding;
    const Eigen::MatrixX3d& d = record.drift;
    const Eigen::MatrixX3d c = record.compensation.rowwise() - record.compensation.row(0);
    const double least = std::max(6 * record.uncertainty, 0.003 / record.millimetres);
    double dd = 0, cd = 0, cc = 0, square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        finding.drifts[static_cast<std::size_t>(axis)] = range(d.col(axis)) > least;
        square += (d.col(axis) - c.col(axis)).squaredNorm();
        cc += c.col(axis).squaredNorm();
        if (!finding.drifts[static_cast<std::size_t>(axis)]) continue;
        dd += d.col(axis).squaredNorm();
        cd += c.col(axis).dot(d.col(axis));
    }
    if (!(dd > 0)) return finding;
    finding.gain = cd / dd;
    finding.cross = cross_gains(record, finding.drifts);
    const double noise = 8 * record.uncertainty * record.uncertainty * static_cast<double>(passes);
    const auto explains = [&](double rest) { return rest < 0.25 * square && rest < 0.12 * dd + noise; };

    const double own = square;
    const int frozen = frozen_sensor(record.temperatures);
    // Of a compensation that has one wrong factor.
    const double gain_rest = (c - finding.gain * d).squaredNorm();

    // A compensation is a law of temperatures. If the law with two sensors exchanged removes the drift, they
    // are swapped; unless a plain factor does, too.
    const double factor_rest = cc > 0 ? gain_rest / (finding.gain * finding.gain) : own;
    if (own > 0.05 * dd + noise) {
        const SwappedSensors swapped = swapped_sensors(record, c);
        if (explains(swapped.rest) && swapped.rest < 0.5 * std::min(own, factor_rest)) {
            finding.fault = CompensationFault::swapped_sensors;
            finding.sensor = swapped.sensor;
            finding.other_sensor = swapped.other_sensor;
            return finding;
        }
    }
    if (std::sqrt(cc) < 0.1 * std::sqrt(dd)) {
        finding.fault = frozen >= 0 ? CompensationFault::frozen_sensor : CompensationFault::absent;
        finding.sensor = frozen;
        return finding;
    }
    if (finding.gain < -0.3 && gain_rest < 0.2 * dd * finding.gain * finding.gain + noise) {
        finding.fault = CompensationFault::wrong_sign;
        return finding;
    }
    double best = 0.6 * std::min(own, gain_rest);  // a swap has to be better than a plain factor
    for (int a = 0; a < 3; ++a)
        for (int b = a + 1; b < 3; ++b) {
            Eigen::MatrixX3d swapped = d;
            swapped.col(a).swap(swapped.col(b));
            const double rest = (swapped - c).squaredNorm();
            if (!explains(rest) || rest >= best) continue;
            best = rest;
            finding.fault = CompensationFault::swapped_axes;
            finding.axis = a;
            finding.other_axis = b;
        }
    for (int a = 0; a < 3 && finding.fault != CompensationFault::swapped_axes; ++a)
        for (int b = a + 1; b < 3; ++b) {
            std::array<bool, 3> both{};
            both[static_cast<std::size_t>(a)] = finding.drifts[static_cast<std::size_t>(a)];
            both[static_cast<std::size_t>(b)] = finding.drifts[static_cast<std::size_t>(b)];
            if (!cross_gains(record, both).swapped(a, b)) continue;
            finding.fault = CompensationFault::swapped_axes;
            finding.axis = a;
            finding.other_axis = b;
        }
    if (finding.fault == CompensationFault::swapped_axes) return finding;

    const int displaced = displaced_sensor(record.temperatures);
    const double cold = record.compensation.row(0).norm();
    const double usual = std::sqrt(dd / static_cast<double>(passes));  // of a pass
    const bool shifted = displaced >= 0 ? cold > std::max(record.uncertainty, 0.03 * usual)
                                        : record.temperatures.cols() < 3 &&
                                              cold > std::max(4 * record.uncertainty, 0.15 * usual);
    if (shifted) {
        finding.fault = CompensationFault::sensor_offset;
        finding.sensor = displaced;
        return finding;
    }
    if (frozen >= 0 && finding.gain < weak) {
        finding.fault = CompensationFault::frozen_sensor;
        finding.sensor = frozen;
        return finding;
    }
    if (gain_rest > 0.12 * dd + noise)
        finding.fault = CompensationFault::other;
    else if (finding.gain < weak)
        finding.fault = CompensationFault::too_weak;
    else if (finding.gain > strong)
        finding.fault = CompensationFault::too_strong;
    else
        finding.fault = own > 0.03 * dd + noise ? CompensationFault::other : CompensationFault::none;
    return finding;
}

}  // namespace plumb
