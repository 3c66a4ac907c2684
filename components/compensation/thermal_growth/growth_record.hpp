// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/records.hpp"

#include <cmath>
#include <cstdint>

namespace plumb::growth_test {

enum class Kind : std::int32_t { touch = 1, temperature = 2, event = 3, speed = 4 };

// The item of a record of an event.
enum class Event : std::int32_t {
    begin = 1,  // of the test
    pass_begin = 2,
    pass_end = 3,
    cycle_end = 4,
    stop = 5,  // x is the reason
    resumed = 6,
    rejected = 7,   // the touches of this visit do not count
    fault = 8,      // x is its code
    end = 9,        // the program of the test ended
    measured = 10,  // the touches of this visit count
};

// One thing that happened. A test is the row of its records: restored, they give the same test.
struct Record {
    std::int32_t kind = 0;
    double time = 0;         // s since the test began
    std::int32_t pass = 0;   // from 1
    std::int32_t visit = 0;  // of a bore; counts up through the test
    std::int32_t bore = 0;
    std::int32_t item = 0;  // direction of a touch, number of a sensor, or an event
    bool turned = false, compensated = false, cooled = false;
    double x = 0, y = 0, z = 0;  // a temperature: value, valid, age; a speed: mean since the last one
    double x_offset = 0, y_offset = 0, z_offset = 0;

    bool usable() const noexcept {
        for (const double value : {time, x, y, z, x_offset, y_offset, z_offset})
            if (!(std::abs(value) <= 1e9)) return false;
        return kind >= 1 && kind <= 4 && time >= 0 && pass >= 0 && visit >= 0 && bore >= 0 && bore <= 16 &&
               item >= -3 && item <= 10;
    }
};

struct GrowthRow final : hal::RecordRow<Record> {
    using RecordRow::RecordRow;

    Field<std::int32_t> kind{this, record.kind, "kind", "",
                             "Kind of the record: 1 touch, 2 temperature, 3 event, 4 speed."};
    Field<double> time{this, record.time, "time", "s", "Time since the test began."};
    Field<std::int32_t> pass{this, record.pass, "pass", "", "Number of the pass."};
    Field<std::int32_t> visit{this, record.visit, "visit", "", "Number of the visit of a bore."};
    Field<std::int32_t> bore{this, record.bore, "bore", "", "Number of the bore."};
    Field<std::int32_t> item{this, record.item, "item", "",
                             "Direction of the touch, number of the sensor, or event."};
    Field<bool> turned{this, record.turned, "turned", "", "The table was at 180 deg."};
    Field<bool> compensated{this, record.compensated, "compensated", "", "The compensation was on."};
    Field<bool> cooled{this, record.cooled, "cooled", "", "The temperature control was on."};
    Field<double> x{this, record.x, "x", "1",
                    "X of a touch in mu, a temperature in degC, a speed in rpm, or a code."};
    Field<double> y{this, record.y, "y", "1", "Y of a touch in mu, or 1 for a valid temperature."};
    Field<double> z{this, record.z, "z", "1", "Z of a touch in mu, or the age of a temperature in s."};
    Field<double> x_offset{this, record.x_offset, "x-offset", "mu", "Compensation in X."};
    Field<double> y_offset{this, record.y_offset, "y-offset", "mu", "Compensation in Y."};
    Field<double> z_offset{this, record.z_offset, "z-offset", "mu", "Compensation in Z."};
};

}  // namespace plumb::growth_test
