// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/sensor/sensor_fault.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {

// A value is valid within these.
struct ReadingLimits {
    double max_age = 1;  // s
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    double max_rate = std::numeric_limits<double>::infinity();  // unit of the value per s
};

// A channel as others see it at some time.
struct Reading {
    double value = 0;  // the last one that was accepted
    bool any = false;  // one was accepted
    bool valid = false;
    double age = 0;  // s, since the value was asked for; of the first value, since the start
    std::int32_t errors = 0;
    SensorFault fault = SensorFault::waiting;
};

// Judges the values of one channel. Times are in s, of a clock that never goes back.
//
// A rejected value makes the channel invalid at once, and the last accepted one stays. A failed request does
// not: the last value stays valid up to max_age. A value is compared with the last accepted one over the time
// between the two, so a true step is accepted once max_rate allows it.
class Judge {
public:
    explicit Judge(const ReadingLimits& limits, double start = 0) : limits_(limits), time_(start) {}

    // A value, and the earliest time at which it was true.
    void take(double time, double value) noexcept {
        if (!std::isfinite(value) || value < limits_.min || value > limits_.max)
            return reject(SensorFault::range);
        const double passed = std::max(time - time_, shortest);
        if (has_value_ && std::abs(value - value_) > limits_.max_rate * passed)
            return reject(SensorFault::rate);
        has_value_ = good_ = true;
        value_ = value;
        time_ = time;
        fault_ = SensorFault::none;
    }

    // A request that has failed, or a frame that could not be read.
    void fail(SensorFault fault) noexcept {
        count();
        fault_ = fault;
    }

    // The same where the last value itself can no longer be trusted.
    void reject(SensorFault fault) noexcept {
        fail(fault);
        good_ = false;
    }

    Reading at(double now) const noexcept {
        Reading reading;
        reading.value = value_;
        reading.any = has_value_;
        reading.age = std::max(now - time_, 0.0);
        const bool fresh = reading.age <= limits_.max_age;
        reading.valid = good_ && fresh;
        reading.errors = errors_;
        reading.fault = fault_ == SensorFault::none && !fresh ? SensorFault::old : fault_;
        return reading;
    }

private:
    static constexpr double shortest = 1e-3;  // s, between two values that come at once

    void count() noexcept {
        if (errors_ < std::numeric_limits<std::int32_t>::max()) ++errors_;
    }

    ReadingLimits limits_;
    double value_ = 0;
    double time_;
    bool has_value_ = false;
    bool good_ = false;  // the last value was accepted
    std::int32_t errors_ = 0;
    SensorFault fault_ = SensorFault::waiting;
};

}  // namespace plumb
