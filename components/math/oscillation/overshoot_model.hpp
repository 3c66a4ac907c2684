// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// How far an axis turns beyond the commanded end of a stroke, by the strokes that it has made. A linear axis
// with the response H turns S / 2 (|H(w)| - 1) beyond, w^2 = 2 a / S, a series in w^2. Friction and backlash
// add a constant, and a stroke that leaves the end with another acceleration a' a part of the difference:
//
//     beyond = c0 + c1 a + c2 a^2 / S + c3 (a' - a)
//
// The coefficients are normal variables with a wide prior, so that few strokes give a wide prediction.
// Strokes that are like the predicted one weigh more.
class OvershootModel {
public:
    static constexpr std::size_t most = 24;

    struct Turn {
        double acceleration = 0;  // mu/s2, of the command that brakes
        double leaving = 0;       // mu/s2, of the command that leaves
        double length = 0;        // mu, of the stroke
        double crank = 1;         // the acceleration, to that of a crank of the same speed
    };

    struct Prediction {
        double beyond = 0, doubt = 0;  // mu; the doubt is above three sigma
    };

    void forget() noexcept { count_ = oldest_ = 0; }
    bool empty() const noexcept { return count_ == 0; }
    // Whether a stroke of this frequency, w^2 = 2 a / S, is among the turns, or a slower one: the response of
    // an axis above its known frequencies is unknown.
    bool covers(double acceleration, double length) const noexcept {
        const auto its = [&](const Measured& each) {
            return acceleration * each.turn.length <= quicker * each.turn.acceleration * length;
        };
        return std::any_of(turns_.begin(), turns_.begin() + static_cast<std::ptrdiff_t>(count_), its);
    }

    // A measured turn. It takes the place of a like one, or else of the oldest.
    void add(const Turn& turn, double beyond) noexcept {
        if (!(turn.acceleration > 0 && turn.length > 0 && turn.crank > 0 && std::abs(beyond) < farthest))
            return;
        std::size_t place = 0;
        while (place < count_ && !(distance(turns_[place].turn, turn) < alike)) ++place;
        if (place == most) {
            place = oldest_;
            oldest_ = (oldest_ + 1) % most;
        }
        count_ = std::max(count_, place + 1);
        turns_[place] = {turn, beyond};
    }

    // Of a turn with a length and accelerations above 0. `unit` is the smallest length that counts, mu.
    Prediction predict(const Turn& wanted, double unit) const noexcept {
        double largest = unit, nearest = count_ > 0 ? distance(turns_[0].turn, wanted) : 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const Measured& each = turns_[i];
            const double part = wanted.acceleration / each.turn.acceleration;
            largest = std::max(largest, std::abs(each.beyond) * part);
            nearest = std::min(nearest, distance(each.turn, wanted));
        }
        // Each coefficient is its part of the prediction.
        const std::array<double, size> prior{3 * unit, 10 * largest, 0.5 * largest, largest};
        Eigen::Matrix4d square = Eigen::Matrix4d::Zero();
        Eigen::Vector4d product = Eigen::Vector4d::Zero();
        for (std::size_t i = 0; i < size; ++i) square(i, i) = 1 / (prior[i] * prior[i]);
        for (std::size_t i = 0; i < count_; ++i) {
            const Measured& each = turns_[i];
            const Eigen::Vector4d its = row(each.turn, wanted);
            const double sigma =
                (unit / 3 + relative * std::abs(each.beyond)) * (1 + 3 * distance(each.turn, wanted));
            square += its * its.transpose() / (sigma * sigma);
            product += its * each.beyond / (sigma * sigma);
        }
        const Eigen::LDLT<Eigen::Matrix4d> solver(square);
        const Eigen::Vector4d its = row(wanted, wanted);
        const double variance = std::max(its.dot(solver.solve(its)), 0.0);
        const double beyond = its.dot(solver.solve(product));
        return {beyond, 3 * std::sqrt(variance) + strange * nearest * std::abs(beyond)};
    }

private:
    static constexpr std::size_t size = 4;

    struct Measured {
        Turn turn;
        double beyond = 0;
    };

    static Eigen::Vector4d row(const Turn& turn, const Turn& wanted) noexcept {
        const double part = turn.acceleration / wanted.acceleration;
        return {1, part, part * part * wanted.length / turn.length,
                (turn.leaving - turn.acceleration) / wanted.acceleration};
    }

    static double distance(const Turn& a, const Turn& b) noexcept {
        const auto apart = [](double x, double y) { return std::abs(std::log(x / y)); };
        return apart(a.acceleration, b.acceleration) + apart(a.length, b.length) +
               3 * apart(a.crank, b.crank);
    }

    static constexpr double farthest = 1e6;  // mu
    static constexpr double alike = 0.02;
    static constexpr double quicker = 1.1;  // w^2, than all turns
    static constexpr double strange = 0.2;    // of a turn, at a distance of 1 from all others
    static constexpr double relative = 0.01;  // of a turn, that the model does not explain

    std::array<Measured, most> turns_{};
    std::size_t count_ = 0, oldest_ = 0;
};

}  // namespace plumb
