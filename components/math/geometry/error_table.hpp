// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace plumb {

// The error motions of a linear axis, here Y, by their names in ISO 230-1 and in this order: EXY EYY EZY in
// mm, EAY EBY ECY in rad.
using ErrorMotions = std::array<double, 6>;

// The error motions of an axis, measured at some of its positions.
//
// Between two positions they are cubic, by Hermite, with the slope at each position that of the parabola
// through it and its neighbours (at the ends, through the last three). A correction made of them has thus
// no step in its velocity, as linear interpolation would give it; and a bad reading spoils two intervals on
// either side of it, where a spline would hand it on through all. Parabolas are met exactly, however
// uneven the positions; beside a step of even ones it overshoots by 2/27 of the step.
//
// Beyond the ends each error holds its last value, and its slope is 0: the value has no step there, the slope
// has. So a table should cover the whole travel.
class ErrorTable {
public:
    struct Row {
        double position = 0;  // mm
        ErrorMotions errors{};
    };
    struct Reading {
        ErrorMotions errors{};
        ErrorMotions slopes{};  // mm/mm, rad/mm
    };

    // At least two rows, all numbers finite, the positions rising. Allocates; nothing else does.
    explicit ErrorTable(const std::vector<Row>& rows) : first_(rows.front().position) {
        const std::size_t last = rows.size() - 1;
        const std::vector<ErrorMotions> slopes = slopes_of(rows);
        ends_.reserve(last);
        intervals_.reserve(last);
        for (std::size_t i = 0; i < last; ++i) {
            ends_.push_back(rows[i + 1].position);
            intervals_.push_back(interval(rows[i], rows[i + 1], slopes[i], slopes[i + 1]));
        }
    }

    double first() const noexcept { return first_; }       // mm
    double last() const noexcept { return ends_.back(); }  // mm

    // Where a position is: the same in all tables of these positions.
    struct Place {
        std::size_t interval;
        double s;     // mm, from its start
        bool inside;  // the table reaches the position
    };

    // NaN counts as a position before the first. The search takes the logarithm of the number of rows in
    // steps, always.
    Place place(double position) const noexcept {
        const double within = position > first_ ? std::min(position, last()) : first_;
        const auto end = std::lower_bound(ends_.begin(), ends_.end(), within);
        const auto interval = static_cast<std::size_t>(end - ends_.begin());
        return {interval, within - intervals_[interval].start, within == position};
    }
    Reading at(const Place& place) const noexcept {
        const Interval& interval = intervals_[place.interval];
        const double s = place.s;
        Reading reading;
        for (std::size_t i = 0; i < reading.errors.size(); ++i) {
            const auto& [c0, c1, c2, c3] = interval.cubics[i];
            reading.errors[i] = c0 + s * (c1 + s * (c2 + s * c3));
            if (place.inside) reading.slopes[i] = c1 + s * (2 * c2 + s * 3 * c3);
        }
        return reading;
    }
    Reading at(double position) const noexcept { return at(place(position)); }

private:
    using Cubic = std::array<double, 4>;  // coefficients by rising powers of the distance from the start
    struct Interval {
        double start;
        std::array<Cubic, 6> cubics;
    };

    static double secant(const Row& a, const Row& b, std::size_t error) noexcept {
        return (b.errors[error] - a.errors[error]) / (b.position - a.position);
    }

    // At b, of the parabola through all three, in any order.
    static double slope(const Row& a, const Row& b, const Row& c, std::size_t error) noexcept {
        return secant(a, b, error) + secant(b, c, error) - secant(a, c, error);
    }

    static std::vector<ErrorMotions> slopes_of(const std::vector<Row>& rows) {
        std::vector<ErrorMotions> slopes(rows.size());
        const std::size_t last = rows.size() - 1;
        for (std::size_t i = 0; i < slopes[0].size(); ++i) {
            if (last == 1) {
                slopes[0][i] = slopes[1][i] = secant(rows[0], rows[1], i);
                continue;
            }
            slopes[0][i] = slope(rows[1], rows[0], rows[2], i);
            for (std::size_t k = 1; k < last; ++k) slopes[k][i] = slope(rows[k - 1], rows[k], rows[k + 1], i);
            slopes[last][i] = slope(rows[last - 1], rows[last], rows[last - 2], i);
        }
        return slopes;
    }

    static Interval interval(const Row& a, const Row& b, const ErrorMotions& at_a, const ErrorMotions& at_b) {
        Interval result{a.position, {}};
        const double length = b.position - a.position;
        for (std::size_t i = 0; i < at_a.size(); ++i) {
            const double mean = secant(a, b, i);
            result.cubics[i] = {a.errors[i], at_a[i], (3 * mean - 2 * at_a[i] - at_b[i]) / length,
                                (at_a[i] + at_b[i] - 2 * mean) / (length * length)};
        }
        return result;
    }

    double first_;
    std::vector<double> ends_;  // of the intervals
    std::vector<Interval> intervals_;
};

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
    // axis, its error along its own travel; `scale_directed`: by direction. `turn_from`, of a rotary axis:
    // the table holds for all turns, from this position on for one turn, and has a row more at either end.
    explicit DirectedErrorTable(ErrorTable mean, std::optional<ErrorTable> half = std::nullopt,
                                bool scale_measured = false, bool scale_directed = false,
                                std::optional<double> turn_from = std::nullopt)
        : mean_(std::move(mean)),
          half_(std::move(half)),
          scale_measured_(scale_measured),
          scale_directed_(scale_directed),
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
    bool scale_directed() const noexcept { return scale_directed_; }

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
    bool scale_measured_, scale_directed_;
    std::optional<double> turn_from_;  // deg
};

// The direction in which an axis moved last. It turns when the position has gone back from its furthest
// point by more than a distance: standstill, noise and jogs below it turn nothing, and small jogs add up.
class DirectionOfMotion {
public:
    // Defaults of squareness where an axis turns, with which plumb volume predicts circles: mm, mm/s2.
    static constexpr double usual_distance = 0.0005, usual_acceleration = 125;

    // Finite, in mu, with the distance above 0. The first position is only where it starts.
    void step(double position, double distance) noexcept {
        if (!started_) lowest_ = highest_ = position;
        started_ = true;
        lowest_ = std::min(lowest_, position);
        highest_ = std::max(highest_, position);
        if (direction_ <= 0 && position - lowest_ > distance)
            turn(1, position);
        else if (direction_ >= 0 && highest_ - position > distance)
            turn(-1, position);
    }

    // The position was set anew, without motion: the furthest point goes with it.
    void shift(double by) noexcept {
        lowest_ += by;
        highest_ += by;
    }

    int direction() const noexcept { return direction_; }  // 1 to the + end, -1 to the - end, 0 unknown

private:
    void turn(int direction, double position) noexcept {
        direction_ = direction;
        lowest_ = highest_ = position;
    }

    double lowest_ = 0, highest_ = 0;  // since it turned last
    int direction_ = 0;
    bool started_ = false;
};

}  // namespace plumb
