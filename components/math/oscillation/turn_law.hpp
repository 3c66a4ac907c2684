// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// How far an axis turns beyond the commanded end of a stroke, by the turns that it has made there. A linear
// axis with the response H turns E / 2 (|H(w)| - 1) beyond, w^2 = 2 a / E, a series in w^2. Friction and
// backlash add a constant, a stroke that leaves the end with another acceleration a' a part of the
// difference, and what the series lacks is a slope by the mean length E of the strokes before and after:
//
//     beyond = c0 + c1 a + c2 a^2 / E + c3 (a' - a) + c4 (E - E1)
//
// 1. add() takes a measured turn, and keeps the last 24 that differ.
// 2. predict() solves for the coefficients by least squares, for one wanted turn. They are normal variables
//    with a wide prior, so few turns give a wide prediction. A turn has a larger sigma, the less it is like
//    the wanted one.
// 3. Turns of an even stroke hold for one with sections only until that has turned itself.
// 4. A turn that the turns before do not explain is a surprise. The difference is a doubt until a turn
//    agrees. The axis is odd then, a position loop with an integral as a rule: until another stroke is
//    selected, unlike turns explain little, and the slope is as doubtful as beside a section.
//
// The doubt is three sigma, a part of the turn where no other turn is like it, and the surprise.
class TurnLaw {
public:
    static constexpr std::size_t most = 24;

    struct Turn {
        double acceleration = 0;  // mu/s2, of the command that brakes
        double leaving = 0;       // mu/s2, of the command that leaves
        double length = 0;        // mu, mean of the strokes before and after it
        int shape = 0;            // of the stroke: 0 even, another number for each set of sections
        bool starts = false;      // the start is still in it
        bool remembered = false;  // from before a restart: until a turn of this axis is a surprise
    };

    struct Prediction {
        double beyond = 0, doubt = 0;  // mu; the doubt is three sigma
    };

    // Another stroke.
    void begin() noexcept {
        surprise_ = 0;
        odd_ = false;
    }
    void forget() noexcept {
        count_ = oldest_ = 0;
        begin();
    }
    bool empty() const noexcept { return count_ == 0; }
    double surprise() const noexcept { return surprise_; }  // mu, of the last turn
    const Turn& last() const noexcept { return last_; }

    // Whether there is a turn of its frequency, w^2 = 2 a / E, or of a higher one, and of its sections. The
    // response of an axis to a stroke that is quicker than all others is unknown.
    bool covers(const Turn& wanted) const noexcept {
        bool quick = false;
        for (std::size_t i = 0; i < count_; ++i) {
            const Turn& its = turns_[i].turn;
            quick |= wanted.acceleration * its.length <= quicker * its.acceleration * wanted.length;
        }
        return quick && (wanted.shape == 0 || knows(wanted.shape));
    }
    // Whether a stroke with these sections has turned.
    bool knows(int shape) const noexcept {
        const auto its = [&](const Measured& each) { return each.turn.shape == shape; };
        return std::any_of(turns_.begin(), turns_.begin() + static_cast<std::ptrdiff_t>(count_), its);
    }

    // Whether there are remembered turns, and without them: the axis is another one.
    bool remembers() const noexcept {
        const auto its = [](const Measured& each) { return each.turn.remembered; };
        return std::any_of(turns_.begin(), turns_.begin() + static_cast<std::ptrdiff_t>(count_), its);
    }
    void drop_remembered() noexcept {
        const auto end = turns_.begin() + static_cast<std::ptrdiff_t>(count_);
        const auto its = [](const Measured& each) { return each.turn.remembered; };
        count_ = static_cast<std::size_t>(std::remove_if(turns_.begin(), end, its) - turns_.begin());
        oldest_ = 0;
    }

    // A measured turn. It takes the place of a like one, or else of the oldest. `unit` is the smallest length
    // that counts, mu.
    void add(const Turn& turn, double beyond, double unit) noexcept {
        if (!(turn.acceleration > 0 && turn.length > 0 && std::abs(beyond) < farthest)) return;
        if (!turn.remembered && knows(turn.shape)) {
            const Prediction its = predict(turn, unit);
            const double apart = std::abs(beyond - its.beyond);
            surprise_ = apart > its.doubt - surprise_ ? apart : 0;
            const bool other = surprise_ > unit + (remembers() ? retained * std::abs(beyond) : 0);
            odd_ |= other;
            if (other) drop_remembered();
        }
        std::size_t place = 0;
        while (place < count_ &&
               (turns_[place].turn.shape != turn.shape || !(distance(turns_[place].turn, turn) < alike)))
            ++place;
        if (place == most) {
            place = oldest_;
            oldest_ = (oldest_ + 1) % most;
        }
        count_ = std::max(count_, place + 1);
        turns_[place] = {turn, beyond};
        last_ = turn;
    }

    // Of a turn with a length and accelerations above 0.
    Prediction predict(const Turn& wanted, double unit) const noexcept {
        const bool known = knows(wanted.shape);
        double largest = unit, nearest = count_ > 0 ? far : 0, its_beyond = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const Measured& each = turns_[i];
            const double apart = distance(each.turn, wanted);
            largest = std::max(largest, std::abs(each.beyond) * wanted.acceleration / each.turn.acceleration);
            if (apart <= nearest) its_beyond = each.beyond;
            nearest = std::min(nearest, apart);
        }
        const bool odd = odd_ || !covers(wanted) || wanted.shape != 0;
        const double longer = odd ? (its_beyond > 0 ? odd_slope : odd_lag_slope) * wanted.length
                                  : least * unit + usual_power * std::abs(its_beyond);
        // Each coefficient is its part of the prediction; the last one for a length of twice as much.
        const std::array<double, size> prior{3 * unit + 0.3 * largest, 10 * largest, 0.5 * largest, largest,
                                             longer};
        Matrix square = Matrix::Zero();
        Vector product = Vector::Zero();
        for (std::size_t i = 0; i < size; ++i) square(i, i) = 1 / (prior[i] * prior[i]);
        for (std::size_t i = 0; i < count_; ++i) {
            const Measured& each = turns_[i];
            if (known && each.turn.shape != wanted.shape) continue;
            const Vector its = row(each.turn, wanted);
            const double apart = distance(each.turn, wanted);
            const double unlike = apart * (odd_ ? 10 : 1) * relative * std::abs(each.beyond);
            const double sigma = unit * ((each.turn.starts ? starting : least) + apart) + unlike;
            square += its * its.transpose() / (sigma * sigma);
            product += its * each.beyond / (sigma * sigma);
        }
        const Eigen::LDLT<Matrix> solver(square);
        const Vector its = row(wanted, wanted);
        const double variance = std::max(its.dot(solver.solve(its)), 0.0);
        const double beyond = its.dot(solver.solve(product));
        return {beyond, 3 * std::sqrt(variance) + strange * nearest * std::abs(beyond) + surprise_};
    }

private:
    static constexpr std::size_t size = 5;
    using Matrix = Eigen::Matrix<double, size, size>;
    using Vector = Eigen::Matrix<double, size, 1>;

    struct Measured {
        Turn turn;
        double beyond = 0;
    };

    static Vector row(const Turn& turn, const Turn& wanted) noexcept {
        const double part = turn.acceleration / wanted.acceleration, longer = turn.length / wanted.length;
        Vector its;
        its << 1, part, part * part / longer, (turn.leaving - turn.acceleration) / wanted.acceleration,
            turn.shape == wanted.shape ? longer - 1 : 0;
        return its;
    }

    static double distance(const Turn& a, const Turn& b) noexcept {
        const auto apart = [](double x, double y) { return std::abs(std::log(x / y)); };
        return apart(a.acceleration, b.acceleration) + apart(a.length, b.length);
    }

    static constexpr double farthest = 1e6;  // mu
    static constexpr double far = 1e9;
    static constexpr double alike = 0.003;
    static constexpr double quicker = 1.1;                 // w^2, than all turns
    static constexpr double strange = 0.1;                 // of a turn, at a distance of 1 from all others
    static constexpr double relative = 0.03;               // sigma of a turn at this distance
    static constexpr double retained = 0.02;               // of a turn: the error of a remembered one
    static constexpr double least = 0.02, starting = 0.3;  // sigma, in units, of a turn; of the first one
    // Sigma of the slope: of the power of the length with which a turn goes, and mu for each mu.
    static constexpr double usual_power = 0.2, odd_slope = 0.08, odd_lag_slope = 0.02;

    std::array<Measured, most> turns_{};
    std::size_t count_ = 0, oldest_ = 0;
    Turn last_;
    double surprise_ = 0;  // mu, of the last turn
    bool odd_ = false;
};

}  // namespace plumb
