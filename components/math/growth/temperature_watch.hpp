// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>

namespace plumb {

// Whether a temperature contradicts the others and the spindle. Of the judged sensors i
//
//     c_i = D_i - mean of the other D        r_i = c_i - a_i x - b_i y - o_i exp(-t / tau)
//
// with D the rise of a temperature, x what the spindle has been driven to, and y the same with the slow time
// constant tau. A change that all sensors share, as of a warmer shop, cancels in c. o is r at the start,
// where nobody knows how warm the spindle is; it is 0 if a c is far outside of its span, as no warm machine
// is. A sensor that is wrong by e adds e to its own r, and -e / (n - 1) to each of the others: of the sensors
// that may be wrong the one is named that leaves the least.
class TemperatureWatch {
public:
    static constexpr int sensors = 4;
    using PerSensor = Eigen::Matrix<double, sensors, 1>;

    struct Settings {
        PerSensor fast = PerSensor::Zero(), slow = fast;  // a, b, K
        PerSensor low = fast, high = fast;                // K, span of c
        PerSensor limit = fast;                           // K, of r; 0: the sensor is not judged
        double slow_time = 7200;                          // tau, s

        int judged() const noexcept { return static_cast<int>((limit.array() > 0).count()); }
    };

    // c of each judged sensor; 0 of the others.
    static PerSensor contrasts(const PerSensor& rises, const Settings& settings) noexcept {
        const int n = settings.judged();
        PerSensor result = PerSensor::Zero();
        if (n < 2) return result;
        const double sum = (settings.limit.array() > 0).select(rises.array(), 0.0).sum();
        for (int i = 0; i < sensors; ++i)
            if (settings.limit[i] > 0) result[i] = rises[i] - (sum - rises[i]) / (n - 1);
        return result;
    }

    // `known`: each judged sensor has a value now; otherwise nothing is judged, and the last judgement holds.
    void step(const PerSensor& rises, bool known, double x, double y, const Settings& settings,
              double dt) noexcept {
        if (settings.judged() < 2) {
            named_ = -1;
            return;
        }
        fade_ *= std::exp(-dt / settings.slow_time);
        if (!known) return;
        const PerSensor contrast = contrasts(rises, settings);
        PerSensor rest = contrast - settings.fast * x - settings.slow * y;
        if (!begun_) {
            begun_ = true;
            const PerSensor margin = beyond * (settings.high - settings.low) + settings.limit;
            const bool warm = ((contrast - settings.high - margin).array() <= 0).all() &&
                              ((settings.low - margin - contrast).array() <= 0).all();
            if (warm) start_ = rest;
        }
        rest -= fade_ * start_;
        double worst = 0;
        for (int i = 0; i < sensors; ++i)
            if (settings.limit[i] > 0) worst = std::max(worst, std::abs(rest[i]) / settings.limit[i]);
        if (worst > 1)
            named_ = wrong(rest, settings);
        else if (worst < release)
            named_ = -1;
    }

    int named() const noexcept { return named_; }  // the sensor that contradicts the others, or -1
    // Of two sensors that contradict each other either may be wrong.
    bool doubts(int sensor, const Settings& settings) const noexcept {
        return named_ >= 0 && (sensor == named_ || (settings.judged() == 2 && settings.limit[sensor] > 0));
    }

private:
    static constexpr double beyond = 0.2;   // of a span
    static constexpr double release = 0.9;  // of a limit

    static int wrong(const PerSensor& rest, const Settings& settings) noexcept {
        const int n = settings.judged();
        int best = -1;
        double least = 0;
        for (int j = 0; j < sensors; ++j) {
            if (!(settings.limit[j] > 0)) continue;
            double by = 0, square = 0;
            const auto pattern = [&](int i) { return i == j ? 1.0 : -1.0 / (n - 1); };
            for (int i = 0; i < sensors; ++i) {
                if (!(settings.limit[i] > 0)) continue;
                const double weight = 1 / (settings.limit[i] * settings.limit[i]);
                by += weight * pattern(i) * rest[i];
                square += weight * pattern(i) * pattern(i);
            }
            double left = 0;
            for (int i = 0; i < sensors; ++i)
                if (settings.limit[i] > 0)
                    left += std::pow((rest[i] - by / square * pattern(i)) / settings.limit[i], 2);
            if (best >= 0 && left >= least) continue;
            least = left;
            best = j;
        }
        return best;
    }

    PerSensor start_ = PerSensor::Zero();
    double fade_ = 1;
    bool begun_ = false;
    int named_ = -1;
};

}  // namespace plumb
