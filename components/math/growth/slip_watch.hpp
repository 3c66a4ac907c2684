// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace plumb {

// Finds a slip of the whole artifact on its table between two passes. Growth moves the spindle against the table, and
// so all bores alike at both orientations of the table; a slip turns with the table, and shows at once. Without a
// second orientation, and along the axis of the table, only its course tells: growth under equal work goes on from
// pass to pass, a slip comes once. The pass after it shows that.
class SlipWatch {
public:
    struct Slip {
        int axis = 0;     // 0 X, 1 Y, 2 Z
        double size = 0;  // mu
    };

    void clear() noexcept {
        sums_ = {};
        drift_.fill(NAN);
        interrupt();
        last_ = {};
    }
    // The machine has not worked as before since the last pass.
    void interrupt() noexcept { chain_ = 0; }

    // The deviation of a bore in this pass.
    void take(int axis, bool turned, double deviation) noexcept {
        Sum& its = sums_[static_cast<std::size_t>(axis)][turned ? 1 : 0];
        its.value += deviation;
        ++its.count;
    }

    // The change of a bore since its first visit in this pass: the stopped spindle cools meanwhile.
    void take_again(int axis, double change) noexcept {
        double& its = drift_[static_cast<std::size_t>(axis)];
        its = std::fmax(its, std::abs(change));
    }

    // A pass ends at `time`, s. `work`: the mean speed of the spindle since the pass before; not a number if it is not
    // known. A slip below `least`, mu, is not looked for.
    std::optional<Slip> end_pass(double time, double work, double least) noexcept {
        Pass now;
        now.time = time;
        now.work = work;
        now.drift = drift_;
        drift_.fill(NAN);
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t turned = 0; turned < 2; ++turned) {
                const Sum& its = sums_[axis][turned];
                now.count[axis][turned] = its.count;
                now.mean[axis][turned] = its.count > 0 ? its.value / its.count : NAN;
            }
        sums_ = {};
        const Pass& before = last_[0];
        const bool same = now.count == before.count;
        std::optional<Slip> found;
        for (std::size_t axis = 0; axis < 3 && same && !found; ++axis) {
            const double jump = now.half_difference(axis) - before.half_difference(axis);
            // The second orientation comes later in the pass by half of it.
            const double cooled = (now.drift[axis] + before.drift[axis]) / 2;
            if (std::abs(jump) > least + cooled) found = Slip{static_cast<int>(axis), jump};
        }
        chain_ = same && chain_ > 0 && (chain_ < 2 || now.is_like(before, last_[1])) ? chain_ + 1 : 1;
        std::copy_backward(last_.begin(), last_.end() - 1, last_.end());
        last_[0] = now;
        if (chain_ < most) return found;
        for (std::size_t axis = 0; axis < 3 && !found; ++axis) {
            const double after = step(0, axis), its = step(1, axis), first = step(2, axis);
            // However quickly growth dies away, half of the larger neighbour is left.
            const double alone = its - (first + after) / 2;
            if (std::abs(alone) > least + std::max(std::abs(first), std::abs(after)) / 2)
                found = Slip{static_cast<int>(axis), alone};
        }
        return found;
    }

private:
    static constexpr std::size_t most = 4;

    struct Sum {
        double value = 0;
        int count = 0;
    };
    struct Pass {
        double time = 0, work = NAN;
        std::array<std::array<int, 2>, 3> count{};
        std::array<std::array<double, 2>, 3> mean{};
        std::array<double, 3> drift{};  // within it, mu; not a number if no bore was probed again

        double half_difference(std::size_t axis) const noexcept { return (mean[axis][0] - mean[axis][1]) / 2; }
        // Of all that was probed.
        double middle(std::size_t axis) const noexcept {
            const auto& its = mean[axis];
            return std::isnan(its[1]) ? its[0] : std::isnan(its[0]) ? its[1] : (its[0] + its[1]) / 2;
        }
        // Equal work for an equal time, as between the two passes before.
        bool is_like(const Pass& before, const Pass& first) const noexcept {
            const double now = time - before.time, then = before.time - first.time;
            constexpr double alike = 0.15, slowest = 50;  // rpm
            return std::abs(now - then) < alike * std::max(now, then) &&
                   std::abs(work - before.work) < alike * std::max(work, before.work) + slowest;
        }
    };

    double step(std::size_t back, std::size_t axis) const noexcept {
        return last_[back].middle(axis) - last_[back + 1].middle(axis);
    }

    std::array<std::array<Sum, 2>, 3> sums_{};
    std::array<double, 3> drift_{NAN, NAN, NAN};
    std::array<Pass, most> last_{};  // the last one first
    std::size_t chain_ = 0;          // passes in a row with equal work between them
};

}  // namespace plumb
