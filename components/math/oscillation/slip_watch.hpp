// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace plumb {

// Whether a scale slips on an axis that strokes. A slip is a way of one period alone, d: larger than the ways
// d1 and d2 of the periods before and after it, or smaller than both.
//
//     spike = min(|d - d1|, |d - d2|)        if both differences have one sign, else 0
//
// A slip s gives s. An acceleration a changes the way by a T^2 in the same direction in each period, and a
// scale that stops changes it once: both give none. Steps q of the scale give 2 q at most. The largest spike
// of the strokes before, times a reserve, is the smallest slip that it finds. It finds one also where the
// position loop closes on this scale: that takes the jump away, and moves the load by it.
//
// With the encoder of the motor, the mean difference of both readings over two strokes finds a slower one:
// friction and backlash change it by as much upward as downward.
class SlipWatch {
public:
    // Of a period; mu, mu/s2.
    struct Sample {
        double measured = 0, motor = 0;
        double acceleration = 0;  // the largest of the stroke
    };

    void forget() noexcept { *this = {}; }

    // The readings before say nothing about the next one.
    void pause() noexcept {
        count_ = 0;
        suspects_ = false;
    }
    // The scale has another origin.
    void accept() noexcept {
        pause();
        means_ = {};
        last_ = difference_ = none;
    }

    // A stroke begins. True if the scale has slipped against the motor by more than `least`.
    bool stroke(double least) noexcept {
        strokes_ = std::min(strokes_ + 1, 1000);
        seen_ *= 0.9;
        const Means now = std::exchange(means_, {});
        const bool netted = now.samples > 20 && now.motor() > 0.5 * now.scale();
        const double before = std::exchange(last_, netted ? now.sum / now.samples : none);
        if (!netted || before == none) {
            difference_ = none;
            return false;
        }
        const double difference = (before + last_) / 2;
        if (difference_ == none) difference_ = difference;
        const double change = difference - difference_;
        difference_ += std::clamp(change, -least / 20, least / 20);  // heat
        return std::abs(change) > least;
    }

    // One period of a stroke. True if the scale has slipped by more than least().
    bool step(const Sample& now, double floor) noexcept {
        means_.add(now.measured, now.motor);
        const auto [x1, x2, x3] = past_;
        const double way = x1 - x2, up = way - (x2 - x3), down = way - (now.measured - x1);
        const double spike = up * down > 0 ? std::min(std::abs(up), std::abs(down)) : 0;
        past_ = {now.measured, x1, x2};
        suspects_ = count_ >= 2 && strokes_ >= first && std::abs(down) > least_;
        if (count_ < past_.size()) {
            ++count_;
            return false;
        }
        least_ = reserve * seen_ * std::max(now.acceleration / hardest_, 1.0) + floor;
        const bool slips = strokes_ >= first && spike > least_;
        if (slips) {
            count_ = 0;
            suspects_ = false;
            return true;
        }
        hardest_ = std::max(hardest_, now.acceleration);
        seen_ = std::max(seen_, spike);
        return false;
    }

    double least() const noexcept { return least_; }  // mu
    // The last way may be a slip, which the next one decides.
    bool suspects() const noexcept { return suspects_; }

private:
    struct Means {
        double sum = 0, samples = 0;
        double low[2] = {far, far}, high[2] = {-far, -far};

        void add(double measured, double motor) noexcept {
            const double its[2] = {measured, motor};
            for (std::size_t i = 0; i < 2; ++i) {
                low[i] = std::min(low[i], its[i]);
                high[i] = std::max(high[i], its[i]);
            }
            sum += measured - motor;
            ++samples;
        }
        double scale() const noexcept { return high[0] - low[0]; }
        double motor() const noexcept { return high[1] - low[1]; }
    };

    static constexpr double far = 1e9, none = 1e12;
    static constexpr double reserve = 3;  // above the largest spike before
    static constexpr int first = 4;       // strokes that show what an axis does

    std::array<double, 3> past_{};
    std::size_t count_ = 0;
    bool suspects_ = false;
    int strokes_ = 0;
    double seen_ = 0, least_ = 0;  // mu
    double hardest_ = std::numeric_limits<double>::min();
    Means means_;
    double last_ = none, difference_ = none;  // mu, scale minus motor: of the last stroke; before any slip
};

}  // namespace plumb
