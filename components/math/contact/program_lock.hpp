// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// Whether the contacts of one gauge are contacts at all. The place of the work in the machine does not move
// when the offset moves. A load event of the program, as coolant that comes on late, moves with the offset
// one to one. So the displacement d of each contact is regressed on the offset a that was in force,
//
//     d = c + alpha g + gamma d' + beta a        g: growth that was predicted, d': the last displacement
//
// where beta is 0 for a contact and 1 for an event of the program. g and d' take away all by which an offset
// follows a growth; while the offset stands, nothing can be known. beta is decided by three of its standard
// deviations, which the residuals give.
class ProgramLock {
public:
    // A contact, in mu. `noise`: its standard deviation as far as known.
    void add(double displacement, double predicted, double offset, double noise) noexcept {
        if (known_) take({predicted, last_, offset, displacement});
        known_ = true;
        last_ = displacement;
        judge(noise);
    }

    bool locked() const noexcept { return locked_; }  // an event of the program

    // While the offset was displaced on purpose: by this contact alone, compared with those before.
    bool follows(double displacement, double predicted, double step) const noexcept {
        return std::abs(step) > 0 && std::abs((displacement - predicted) / step - 1) < 0.5;
    }

private:
    static constexpr std::size_t g = 0, h = 1, a = 2, d = 3, values = 4;
    static constexpr double memory = 200;  // contacts
    static constexpr double fewest = 7;    // contacts

    void take(const std::array<double, values>& x) noexcept {
        n_ = std::min(n_ + 1, memory);
        const double part = 1 / n_;
        std::array<double, values> away;
        for (std::size_t i = 0; i < values; ++i) {
            away[i] = x[i] - mean_[i];
            mean_[i] += part * away[i];
        }
        for (std::size_t i = 0; i < values; ++i)
            for (std::size_t j = 0; j < values; ++j)
                sum_[i][j] = (1 - part) * (sum_[i][j] + part * away[i] * away[j]);
    }

    // Takes g and d' out of the covariances, one after the other.
    void judge(double noise) noexcept {
        if (n_ < fewest) return;
        const double least = 0.01 * noise * noise;
        auto left = sum_;
        for (const std::size_t k : {g, h}) {
            if (!(left[k][k] > least)) continue;
            const auto row = left[k];
            for (std::size_t i = 0; i < values; ++i)
                for (std::size_t j = 0; j < values; ++j) left[i][j] -= row[i] * row[j] / row[k];
        }
        if (!(left[a][a] > least)) return;
        const double beta = left[a][d] / left[a][a];
        const double rest = std::max(left[d][d] - beta * left[a][d], 0.0) * n_ / (n_ - 4);
        const double sigma = std::sqrt(std::max(rest, 0.1 * noise * noise) / (n_ * left[a][a]));
        locked_ = beta - 3 * sigma > 0.5 && beta + 3 * sigma < 2;
    }

    bool known_ = false, locked_ = false;
    double last_ = 0, n_ = 0;
    std::array<double, values> mean_{};
    std::array<std::array<double, values>, values> sum_{};
};

}  // namespace plumb
