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
        case CompensationFault::undetermined: return "The compensation is not determined.";
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
constexpr Eigen::Index fewest_passes = 4;
constexpr int most_passes = 50;  // that are worth a wait
constexpr double still = 0.02;   // K, less than the noise of a sensor that works
constexpr double warmed = 1;     // K, a machine that has warmed
constexpr double apart = 1.5;    // K, between sensors of a machine that is cold throughout

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

// Looks for one fault after the other, from the most particular one to the most general one.
class Judge {
public:
    explicit Judge(const CompensationRecord& record)
        : record_(record),
          drift_(record.drift),
          compensation_(record.compensation.rowwise() - record.compensation.row(0)),
          passes_(static_cast<double>(record.drift.rows())),
          noise_(8 * record.uncertainty * record.uncertainty * passes_),
          frozen_(frozen_sensor(record.temperatures)) {
        add_up();
    }

    CompensationFinding judged() {
        if (!(drifts_ > 0)) {
            finding_.larger_drift = least_drift();
            return finding_;
        }
        finding_.gain = common_ / drifts_;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                finding_.difference(row, column) =
                    (compensation_.col(row) - drift_.col(column)).norm() / std::sqrt(passes_ - 1);
        gain_rest_ = (compensation_ - finding_.gain * drift_).squaredNorm();
        const bool particular = swaps_sensors() || does_nothing() || has_wrong_sign() || swaps_axes() ||
                                has_sensor_offset() || has_frozen_sensor();
        if (!particular) finding_.fault = by_factor();
        return finding_;
    }

private:
    void add_up() {
        for (int axis = 0; axis < 3; ++axis) {
            const auto d = drift_.col(axis), c = compensation_.col(axis);
            bool& drifts = finding_.drifts[static_cast<std::size_t>(axis)];
            drifts = range(d) > least_drift();
            rest_ += (d - c).squaredNorm();
            compensations_ += c.squaredNorm();
            if (!drifts) continue;
            drifts_ += d.squaredNorm();
            common_ += c.dot(d);
            wanted_ += c.squaredNorm();
            largest_ = std::max(largest_, d.cwiseAbs().maxCoeff());
        }
    }

    double least_drift() const { return std::max(6 * record_.uncertainty, 0.003 / record_.millimetres); }

    // Of 1 / gain, if the machine were probed so many times more as warm as in the last pass. The
    // compensation is known; the drift of each pass has its own error, and all passes of an axis share the
    // error of the reference.
    double inverse_sigma(int more) const {
        double squares = 0, shared = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (!finding_.drifts[static_cast<std::size_t>(axis)]) continue;
            const auto c = compensation_.col(axis);
            const double last = c[c.size() - 1];
            squares += c.squaredNorm() + more * last * last;
            shared += std::pow(c.sum() + more * last, 2);
        }
        return record_.uncertainty / std::sqrt(2.0) * std::sqrt(squares + shared) / squares;
    }

    // 1 / gain lies `away` from the nearest limit that decides.
    CompensationFault needs(double away) {
        for (int more = 1; more <= most_passes && finding_.more_passes == 0; ++more)
            if (2 * inverse_sigma(more) < away) finding_.more_passes = more;
        finding_.larger_drift = largest_ * 2 * inverse_sigma(0) / away;
        return CompensationFault::undetermined;
    }

    bool explains(double rest) const { return rest < 0.25 * rest_ && rest < 0.12 * drifts_ + noise_; }

    bool found(CompensationFault fault, int sensor = -1, int other_sensor = -1) {
        finding_.fault = fault;
        finding_.sensor = sensor;
        finding_.other_sensor = other_sensor;
        return true;
    }
    bool found_axes(int axis, int other_axis) {
        finding_.axis = axis;
        finding_.other_axis = other_axis;
        return found(CompensationFault::swapped_axes);
    }

    // A compensation is a law of temperatures. If the law with two sensors exchanged removes the drift, they
    // are swapped; unless a plain factor does, too.
    bool swaps_sensors() {
        if (!(rest_ > 0.05 * drifts_ + noise_)) return false;
        const double factor_rest = compensations_ > 0 ? gain_rest_ / (finding_.gain * finding_.gain) : rest_;
        const SwappedSensors swapped = swapped_sensors(record_, compensation_);
        return explains(swapped.rest) && swapped.rest < 0.5 * std::min(rest_, factor_rest) &&
               found(CompensationFault::swapped_sensors, swapped.sensor, swapped.other_sensor);
    }

    bool does_nothing() {
        if (!(std::sqrt(compensations_) < 0.1 * std::sqrt(drifts_))) return false;
        return found(frozen_ >= 0 ? CompensationFault::frozen_sensor : CompensationFault::absent, frozen_);
    }

    bool has_wrong_sign() {
        return finding_.gain < -0.3 && gain_rest_ < 0.2 * drifts_ * finding_.gain * finding_.gain + noise_ &&
               found(CompensationFault::wrong_sign);
    }

    // The swapped axes may be too weak or too strong, too.
    bool swaps_axes() {
        bool any = false;
        double best = 0.6 * std::min(rest_, gain_rest_);  // a swap has to be better than a plain factor
        for (int a = 0; a < 3; ++a)
            for (int b = a + 1; b < 3; ++b) {
                Eigen::MatrixX3d swapped = drift_;
                swapped.col(a).swap(swapped.col(b));
                const double gain =
                    (swapped.col(a).dot(compensation_.col(a)) + swapped.col(b).dot(compensation_.col(b))) /
                    (swapped.col(a).squaredNorm() + swapped.col(b).squaredNorm());
                if (!(gain > 0.3 && gain < 1.7)) continue;
                swapped.col(a) *= gain;
                swapped.col(b) *= gain;
                const double rest = (swapped - compensation_).squaredNorm();
                if (!explains(rest) || rest >= best) continue;
                best = rest;
                any = found_axes(a, b);
            }
        return any;
    }

    bool has_sensor_offset() {
        const int displaced = displaced_sensor(record_.temperatures);
        const double cold = record_.compensation.row(0).norm();
        const double usual = std::sqrt(drifts_ / passes_);  // of a pass
        const bool shifted = displaced >= 0 ? cold > std::max(record_.uncertainty, 0.03 * usual)
                                            : record_.temperatures.cols() < 3 &&
                                                  cold > std::max(4 * record_.uncertainty, 0.15 * usual);
        return shifted && found(CompensationFault::sensor_offset, displaced);
    }

    bool has_frozen_sensor() {
        return frozen_ >= 0 && finding_.gain < weak && found(CompensationFault::frozen_sensor, frozen_);
    }

    // The fault of a compensation by its gain. 1 / gain has a normal error, so the limits are computed for
    // it.
    CompensationFault by_factor() {
        if (gain_rest_ > 0.12 * drifts_ + noise_) return CompensationFault::other;
        const double inverse = common_ / wanted_, room = 2 * inverse_sigma(0);
        // A small compensation of the wrong sign, which has_wrong_sign() leaves: its limits have no meaning.
        if (inverse <= 0) return CompensationFault::too_weak;
        finding_.gain = 1 / inverse;
        finding_.gain_low = 1 / (inverse + room);
        finding_.gain_high = inverse > room ? 1 / (inverse - room) : HUGE_VAL;
        if (finding_.gain < weak)
            return inverse - room > 1 ? CompensationFault::too_weak : needs(inverse - 1);
        if (finding_.gain > strong)
            return inverse + room < 1 ? CompensationFault::too_strong : needs(1 - inverse);
        const double away = std::min(inverse - 1 / strongest_good_gain, 1 / weakest_good_gain - inverse);
        if (room > away) return needs(away);
        return rest_ > 0.03 * drifts_ + noise_ ? CompensationFault::other : CompensationFault::none;
    }

    const CompensationRecord& record_;
    const Eigen::MatrixX3d& drift_;
    const Eigen::MatrixX3d compensation_;  // without the one of the first pass
    const double passes_, noise_;
    const int frozen_;  // sensor, or -1
    CompensationFinding finding_;
    // Sums of squares and products over all passes: of the axes that drift, of the compensation, of the drift
    // that the compensation leaves, and of the drift that it leaves with the factor that fits best.
    double drifts_ = 0, common_ = 0, compensations_ = 0, rest_ = 0, gain_rest_ = 0;
    double wanted_ = 0;   // the same of the compensation of the axes that drift
    double largest_ = 0;  // drift of an axis in a pass, mu
};

}  // namespace
}  // namespace compensation_fault

CompensationFinding judged_compensation(const CompensationRecord& record) {
    using namespace compensation_fault;
    if (record.drift.rows() >= fewest_passes) return Judge(record).judged();
    CompensationFinding few;
    few.more_passes = static_cast<int>(fewest_passes - record.drift.rows());
    return few;
}

}  // namespace plumb
