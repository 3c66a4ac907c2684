// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// The mean of the last samples of a motion. It stays within the positions, speeds and accelerations of the
// motion, and its jerk is at most 2 a / T: a the largest acceleration, T the time of the samples. A reversal
// with the acceleration a ends short by a T^2 / 24.
class JerkLimit {
public:
    static constexpr std::size_t most = 128;  // samples

    // The samples that limit the jerk, 1 to `most`; more than `most` if it cannot be.
    static std::size_t samples(double acceleration, double jerk, double dt) noexcept {
        const double wanted = std::ceil(2 * acceleration / (jerk * dt) - 1e-9);
        return wanted <= 1 ? 1 : wanted <= most ? static_cast<std::size_t>(wanted) : most + 1;
    }

    // At rest at a position, with another number of samples, 1 to `most`.
    void reset(double position, std::size_t count) noexcept {
        count_ = count;
        samples_.fill(position);
        newest_ = 0;
        origin_ = position;
        sum_ = fresh_ = 0;
        settled_ = count;
        value_ = position;
    }

    double step(double position) noexcept {
        const double last = samples_[newest_];
        newest_ = (newest_ + 1) % count_;
        sum_ += position - samples_[newest_];
        fresh_ += position - origin_;
        samples_[newest_] = position;
        // The sum of all samples, without the rounding of the sums before it.
        if (newest_ == 0) {
            sum_ = fresh_;
            fresh_ = 0;
        }
        settled_ = position == last ? settled_ + (settled_ < count_) : 1;
        return value_ = settled_ >= count_ ? position : origin_ + sum_ / static_cast<double>(count_);
    }

    double value() const noexcept { return value_; }
    bool settled() const noexcept { return settled_ >= count_; }  // all samples are the same
    std::size_t count() const noexcept { return count_; }

private:
    std::array<double, most> samples_{};
    std::size_t count_ = 1, newest_ = 0, settled_ = 1;
    double origin_ = 0, sum_ = 0, fresh_ = 0;  // sums are of distances from the origin
    double value_ = 0;
};

}  // namespace plumb
