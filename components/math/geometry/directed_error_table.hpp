// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/error_table.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace plumb {

// The error motions of an axis in both directions of motion:
//
//     E(q, d) = M(q) + d H(q)      M = (E+ + E-)/2    H = (E+ - E-)/2
//
// d is 1 after motion to the + end, -1 to the - end, and between them while it turns.
class DirectedErrorTable {
public:
    struct Reading {
        ErrorTable::Reading at;  // with d
        ErrorMotions halves{};   // H
    };

    // `half` has the positions of `mean`. `scale_measured`: the table has the scale of the
    // axis, its error along its own travel. `turn_from`, of a rotary axis: the table holds for
    // all turns, from this position on for one turn, and has a row more at either end.
    explicit DirectedErrorTable(ErrorTable mean, std::optional<ErrorTable> half = std::nullopt,
                                bool scale_measured = false, std::optional<double> turn_from = std::nullopt)
        : mean_(std::move(mean)),
          half_(std::move(half)),
          scale_measured_(scale_measured),
          turn_from_(turn_from) {}

    static constexpr double turn = 360;  // deg

    double first() const noexcept { return turn_from_ ? *turn_from_ : mean_.first(); }       // mm or deg
    double last() const noexcept { return turn_from_ ? *turn_from_ + turn : mean_.last(); }  // mm or deg
    // Whether there is a row on either side of the position; NaN has none.
    bool covers(double position) const noexcept {
        return turn_from_ ? std::isfinite(position) : position >= first() && position <= last();
    }
    bool directed() const noexcept { return half_.has_value(); }
    bool scale_measured() const noexcept { return scale_measured_; }

    // The mean of both directions.
    ErrorTable::Reading at(double position) const noexcept {
        return mean_.at(turn_from_ ? position - turn * std::floor((position - *turn_from_) / turn)
                                   : position);
    }

    Reading at(double position, double d) const noexcept {
        const ErrorTable::Place place = mean_.place(position);
        Reading reading{mean_.at(place)};
        if (!half_) return reading;
        const ErrorTable::Reading half = half_->at(place);
        reading.halves = half.errors;
        for (std::size_t i = 0; i < half.errors.size(); ++i) {
            reading.at.errors[i] += d * half.errors[i];
            reading.at.slopes[i] += d * half.slopes[i];
        }
        return reading;
    }

private:
    ErrorTable mean_;
    std::optional<ErrorTable> half_;
    bool scale_measured_;
    std::optional<double> turn_from_;  // deg
};

}  // namespace plumb
