// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace plumb {

// The lag of an axis behind its command, as it was in its last strokes:
//
//     lag = a velocity + b acceleration + c sign(velocity)
//
// by least squares, in which each stroke counts half as much as the next one. A sample is compared with the
// strokes before its own, so that a jam does not explain itself. Nor does the stroke in which a force drops
// explain the next one: once an axis has learned, a stroke counts only if its dead point is right.
class LagModel {
public:
    void begin() noexcept {
        past_ = {};
        coefficients_ = {};
        band_ = peak_ = speed_ = length_ = 0;
        strokes_ = 0;
        now_ = last_ = {};
    }

    // A stroke with this peak speed and length begins. The last one is left out if it was not whole, and
    // waits for judge() if `waits`.
    void stroke(bool whole, bool waits, double speed, double length) noexcept {
        last_ = whole && now_.count > 20 ? now_ : Sums{};
        if (!waits) learn();
        now_ = {};
        now_.speed = speed;
        now_.length = length;
    }

    // Whether the dead point at the end of the stroke that waits is right.
    void judge(bool right) noexcept {
        if (right)
            learn();
        else
            last_ = {};
    }

    // Returns by how much the lag differs from that of the last strokes, mu.
    double step(double command, double velocity, double acceleration, double measured) noexcept {
        const double lag = command - measured, sign = velocity / (std::abs(velocity) + 1e-3 * speed_ + 1e-9);
        const std::array<double, 3> row{velocity, acceleration, sign};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) now_.square[i][k] += row[i] * row[k];
            now_.product[i] += row[i] * lag;
        }
        ++now_.count;
        now_.peak = std::max(now_.peak, std::abs(lag));
        const double rest =
            lag - coefficients_[0] * velocity - coefficients_[1] * acceleration - coefficients_[2] * sign;
        now_.band = std::max(now_.band, std::abs(rest));
        return known() ? rest : 0;
    }

    // Three strokes have been learned.
    bool known() const noexcept { return strokes_ >= 3; }
    int strokes() const noexcept { return strokes_; }
    double band() const noexcept { return band_; }      // mu, the largest difference in the last strokes
    double peak() const noexcept { return peak_; }      // mu, the largest lag in the last stroke
    double speed() const noexcept { return speed_; }    // mu/s, the peak of the last stroke
    double length() const noexcept { return length_; }  // mu, of the last stroke

private:
    struct Sums {
        std::array<std::array<double, 3>, 3> square{};
        std::array<double, 3> product{};
        double speed = 0, length = 0, peak = 0, band = 0;
        int count = 0;
    };

    // From the last stroke.
    void learn() noexcept {
        const Sums its = std::exchange(last_, {});
        if (its.count == 0) return;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k)
                past_.square[i][k] = past_.square[i][k] / 2 + its.square[i][k] / its.count;
            past_.product[i] = past_.product[i] / 2 + its.product[i] / its.count;
        }
        const double faster = speed_ > 0 ? its.speed / speed_ : 1;
        band_ = strokes_ >= 2 ? std::max(its.band, 0.7 * band_ * faster * faster) : 0;
        peak_ = its.peak;
        speed_ = its.speed;
        length_ = its.length;
        if (strokes_ < 1000) ++strokes_;
        solve();
    }

    // Gauss, with a little on the diagonal.
    void solve() noexcept {
        auto a = past_.square;
        auto b = past_.product;
        for (std::size_t i = 0; i < 3; ++i) a[i][i] *= 1 + 1e-9;
        for (std::size_t i = 0; i < 3; ++i) {
            if (!(std::abs(a[i][i]) > 1e-300)) return;
            for (std::size_t k = i + 1; k < 3; ++k) {
                const double part = a[k][i] / a[i][i];
                for (std::size_t j = i; j < 3; ++j) a[k][j] -= part * a[i][j];
                b[k] -= part * b[i];
            }
        }
        for (std::size_t i = 3; i-- > 0;) {
            for (std::size_t k = i + 1; k < 3; ++k) b[i] -= a[i][k] * b[k];
            b[i] /= a[i][i];
        }
        coefficients_ = b;
    }

    Sums now_, last_, past_;  // of this stroke, of the last one, of those before
    std::array<double, 3> coefficients_{};
    double band_ = 0, peak_ = 0, speed_ = 0, length_ = 0;
    int strokes_ = 0;
};

}  // namespace plumb
