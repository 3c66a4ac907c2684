// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

namespace plumb {

// Samples a signal every T seconds and holds the sample. A sample instant may lie within a period of the
// thread; the signal is linear there.
class SampleAndHold {
public:
    // The first sample is due after `delay` seconds, 0 <= delay.
    explicit SampleAndHold(double delay = 0) noexcept : due_(delay) {}

    // Advances by dt > 0 seconds, at whose end the signal is u. Calls `taken` with each new sample (the
    // last one of the period, if there are several) and with the time since the sample before, and holds
    // its result. Without a T (0 or less) every period is a sample.
    template <class Taken>
    double step(double u, double T, double dt, const Taken& taken) noexcept {
        since_ += dt;
        due_ = std::min(due_, T) - dt;  // T may have become shorter
        if (!(T > 0)) {
            take(u, 0, taken);
            due_ = 0;
        } else if (due_ <= 0) {
            const double age = std::fmod(-due_, T);  // of the last sample instant, now
            take(u + (before_ - u) * std::fmin(age / dt, 1), age, taken);
            due_ = T - age;
        }
        before_ = u;
        return held_;
    }

    double value() const noexcept { return held_; }

private:
    template <class Taken>
    void take(double sample, double age, const Taken& taken) noexcept {
        held_ = taken(sample, since_ - age);
        since_ = age;
    }

    double due_;
    double since_ = 0;
    double before_ = 0;
    double held_ = 0;
};

}  // namespace plumb
