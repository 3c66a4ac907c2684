// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumb {

// The largest inward acceleration of a command and of an axis in the accelerating half of a stroke, each
// after its own reversal: friction hinders there, and helps before. By second differences over a sixth of the
// stroke, so that noise of a scale and vibration hardly show.
class ShownAcceleration {
public:
    // A stroke begins that takes so many s.
    void begin(bool upward, double duration, double dt) noexcept {
        sign_ = upward ? 1 : -1;
        const double span = std::max(duration / dt / 12, 1.0);
        stride_ = static_cast<std::size_t>(std::ceil(span / most));
        span_ = static_cast<std::size_t>(std::lround(span / static_cast<double>(stride_)));
        span_ = std::clamp(span_, std::size_t{1}, most);
        step_ = static_cast<double>(span_ * stride_) * dt;
        left_ = static_cast<std::size_t>(std::ceil(0.6 * duration / dt));
        skipped_ = 0;
        command_ = axis_ = {};
        valid_ = true;
    }

    void cancel() noexcept { valid_ = false; }

    // Returns true once, when the accelerating half is over.
    bool step(double command, double measured) noexcept {
        if (!valid_) return false;
        if (skipped_++ % stride_ == 0) {
            command_.step(sign_ * command, span_);
            axis_.step(sign_ * measured, span_);
        }
        if (left_-- > 1) return false;
        valid_ = false;
        return command_.largest > 0;
    }

    double commanded() const noexcept { return command_.largest / (step_ * step_); }  // mu/s2
    double done() const noexcept { return axis_.largest / (step_ * step_); }

private:
    static constexpr std::size_t most = 16;  // samples of one difference

    struct Motion {
        void step(double inward, std::size_t span) noexcept {
            const std::size_t size = samples.size(), now = next;
            next = (next + 1) % size;
            samples[now] = inward;
            if (count == 0 || inward < farthest) {  // it has not turned yet
                farthest = inward;
                count = 1;
                return;
            }
            if (++count <= 2 * span) return;
            const double middle = samples[(now + size - span) % size];
            const double first = samples[(now + size - 2 * span) % size];
            largest = std::max(largest, inward - 2 * middle + first);
        }

        std::array<double, 2 * most + 1> samples{};
        std::size_t next = 0, count = 0;
        double farthest = 0, largest = 0;
    };

    Motion command_, axis_;
    std::size_t span_ = 1, stride_ = 1, skipped_ = 0, left_ = 0;
    double step_ = 1, sign_ = 1;
    bool valid_ = false;
};

}  // namespace plumb
