// SPDX-License-Identifier: GPL-2.0-or-later
// From touches of the probe to the growth of a machine: mathematics without pins. Lengths in mu. In the order
// of a test:
//
//     TouchLatch        the place and direction of a touch
//     ProbedBore        the touches of one visit of a bore: its centre and face, or the fault
//     BoreReferences    the deviation of a bore from its first pass
//     SlipWatch         whether the whole artifact has slipped since the last pass
//     StopRule          whether it is warm: the test ends
//     MeanOverTime      the speed of the spindle since the last sample
#pragma once

#include "components/math/growth/bore_centre.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace plumb {

// Latches the first touch of a probe after it is armed. The direction of the touch is the fastest motion
// before it, because the machine begins to brake at the touch.
class TouchLatch {
public:
    void arm() noexcept { *this = TouchLatch{}; }

    // One period while the latch is armed: the probe touches, or begins to. Velocities in mu/s, finite. True
    // at the touch.
    bool step(bool touches, bool begins, const std::array<double, 3>& velocity) noexcept {
        std::size_t fastest = 0;
        for (std::size_t i = 1; i < 3; ++i)
            if (std::abs(velocity[i]) > std::abs(velocity[fastest])) fastest = i;
        if (!touches && velocity[fastest] != 0)
            direction_ = static_cast<std::int32_t>(fastest + 1) * (velocity[fastest] > 0 ? 1 : -1);
        latched_ = begins;
        return begins;
    }

    bool latched() const noexcept { return latched_; }
    // 1 to 3 for X to Z, negative for motion in -X to -Z; 0 if the machine did not move.
    std::int32_t direction() const noexcept { return direction_; }

private:
    bool latched_ = false;
    std::int32_t direction_ = 0;
};

enum class StopReason : std::int32_t { none, stable, maximum_time };

// Decides when a machine is warm. reserve() allocates; nothing else does, up to so many samples, cycles and
// deviations.
//
// First rule: the largest |T(now) - T(now - interval)| of the chosen sensors is at most the threshold. Second
// rule: for every deviation (a coordinate of a bore), the range in the last hour is at most 15 % of that in
// the first hour, or four of its uncertainties, or a floor. Never before the minimum time; at the maximum
// time in any case.
class StopRule {
public:
    static constexpr int most_sensors = 8;
    static constexpr int most_values = 96;  // 16 bores, two orientations, X, Y and Z
    static constexpr double hour = 3600;
    // Of the range in the first hour: a displacement that moves six times less than at first stands.
    static constexpr double range_share = 0.15;

    struct Settings {
        double threshold = 0;                       // K
        double interval = 0;                        // s; 0: one cycle
        double minimum_time = 0, maximum_time = 0;  // s
        double range_floor = 0;                     // mu
        double uncertainty = 0;                     // mu, of a deviation
        bool by_displacement = true;
        std::uint32_t sensors = 0xff;  // a bit each

        // An interval of one sample or less would compare a value with itself.
        bool valid() const noexcept {
            const auto within = [](double x, double most) { return x >= 0 && x <= most; };
            return threshold > 0 && threshold <= 1000 && within(interval, 24 * hour) &&
                   within(minimum_time, 240 * hour) && within(maximum_time, 240 * hour) && maximum_time > 0 &&
                   minimum_time <= maximum_time && within(range_floor, 1e3) && within(uncertainty, 1e3);
        }
        // The range for which the source states the rule.
        bool usual() const noexcept { return threshold >= 0.5 && threshold <= 5; }
    };

    using Temperatures = std::array<double, most_sensors>;  // degC; not a number: unknown

    void reserve(std::size_t most) {
        samples_.reserve(most);
        ends_.reserve(most);
        deviations_.reserve(most);
    }
    void clear() noexcept {
        samples_.clear();
        ends_.clear();
        deviations_.clear();
    }

    // A temperature of a sensor at a time; not a number if it is invalid.
    void sample(double time, std::size_t sensor, double temperature) noexcept {
        if (samples_.empty()) samples_.push_back({time, unknown_temperatures()});
        if (time > samples_.back().time) samples_.push_back({time, samples_.back().value});
        samples_.back().value[sensor] = temperature;
    }

    // A cycle of the machine ends: the temperatures of now are those of this cycle.
    void cycle_ends(double time) noexcept {
        ends_.push_back({time, samples_.empty() ? unknown_temperatures() : samples_.back().value});
    }

    // Largest change of a sensor within the interval, in K; infinite while it is unknown. A machine that
    // works in cycles is compared at the ends of cycles: its temperatures rise and fall within each.
    double change(const Settings& settings) const noexcept {
        const std::vector<Sample>& all = ends_.empty() ? samples_ : ends_;
        if (all.empty() || (ends_.empty() && !(settings.interval > 0))) return unknown;
        const double then = all.back().time - std::max(settings.interval, 1e-3);
        const auto before = std::find_if(all.rbegin(), all.rend(), [&](const Sample& its) {
            return its.time <= then + 1e-6 * settings.interval;
        });
        return before == all.rend() ? unknown : largest(all.back().value, before->value, settings.sensors);
    }

    // Whether a chosen sensor has risen by `least`, K, since its first value; true if none had a value.
    bool has_risen(double least, const Settings& settings) const noexcept {
        bool any = false;
        for (std::size_t i = 0; i < most_sensors; ++i) {
            double first = NAN;
            for (const Sample& its : samples_) {
                if ((settings.sensors >> i & 1U) == 0 || !std::isfinite(its.value[i])) continue;
                if (std::isnan(first)) first = its.value[i];
                any = true;
                if (its.value[i] - first >= least) return true;
            }
        }
        return !any;
    }

    // The deviation number `index` at a time, in mu. Those of one pass come together.
    void deviation(double time, int index, double value) noexcept {
        if (index < 0 || index >= most_values || !std::isfinite(value)) return;
        deviations_.push_back({time, static_cast<std::size_t>(index), value});
    }

    // Whether the second rule holds for all deviations. They must span the last hour, beyond the first one.
    bool ranges_are_small(double time, const Settings& settings) noexcept {
        series_.fill({});
        for (const Deviation& its : deviations_) {
            Series& series = series_[its.index];
            if (series.count++ == 0) series.began = its.time;
            if (its.time <= series.began + hour || series.count <= 2) series.first.take(its.value);
            if (its.time <= time - hour) series.last = {}, series.spans = true;  // the hour begins here
            series.last.take(its.value);
        }
        for (const Series& its : series_) {
            if (its.count == 0) continue;
            const double most =
                std::max({range_share * its.first.width(), 4 * settings.uncertainty, settings.range_floor});
            if (time - its.began < 2 * hour || !its.spans || !(its.last.width() <= most)) return false;
        }
        return !deviations_.empty();
    }

    StopReason reason(double time, const Settings& settings) noexcept {
        if (time >= settings.maximum_time) return StopReason::maximum_time;
        if (time < settings.minimum_time) return StopReason::none;
        if (!(change(settings) <= settings.threshold)) return StopReason::none;
        if (settings.by_displacement && !ranges_are_small(time, settings)) return StopReason::none;
        return StopReason::stable;
    }

    int cycles() const noexcept { return static_cast<int>(ends_.size()); }

private:
    static constexpr double unknown = HUGE_VAL;

    struct Sample {
        double time = 0;
        Temperatures value{};
    };
    struct Deviation {
        double time = 0;
        std::size_t index = 0;
        double value = 0;
    };
    struct Range {
        double low = HUGE_VAL, high = -HUGE_VAL;

        void take(double value) noexcept {
            low = std::min(low, value);
            high = std::max(high, value);
        }
        double width() const noexcept { return high >= low ? high - low : 0; }
    };
    struct Series {
        double began = 0;
        int count = 0;
        bool spans = false;
        Range first, last;
    };

    static Temperatures unknown_temperatures() noexcept {
        Temperatures all{};
        all.fill(NAN);
        return all;
    }

    static double largest(const Temperatures& now, const Temperatures& then, std::uint32_t sensors) noexcept {
        double most = -1;
        for (std::size_t i = 0; i < now.size(); ++i) {
            if ((sensors >> i & 1U) == 0) continue;
            const double change = std::abs(now[i] - then[i]);
            if (!std::isfinite(change)) return unknown;  // a chosen sensor that is not known decides nothing
            most = std::max(most, change);
        }
        return most >= 0 ? most : unknown;
    }

    std::vector<Sample> samples_, ends_;
    std::vector<Deviation> deviations_;
    std::array<Series, most_values> series_{};  // of ranges_are_small(): too large for the stack
};

// The positions of the bores in the first pass, from which those of later passes deviate.
class BoreReferences {
public:
    static constexpr std::int32_t most_bores = 16;

    // Number of X of a bore, 1 to most_bores; Y and Z follow.
    static std::size_t value(std::int32_t bore, bool turned) noexcept {
        return (static_cast<std::size_t>(bore - 1) * 2 + (turned ? 1 : 0)) * 3;
    }

    void clear() noexcept {
        known_.fill(false);
        grown_.fill(false);
        passes_.fill(0);
    }

    bool known(std::size_t value) const noexcept { return known_[value]; }
    double at(std::size_t value) const noexcept { return reference_[value]; }  // only if known

    // The deviation of a finite position. Nothing if the first pass has none, or if this pass has one
    // already: a bore that is probed again in a pass shows the drift within the pass, not that of the
    // machine.
    std::optional<double> deviation(std::size_t value, double at, std::int32_t pass) noexcept {
        if (!known_[value]) {
            if (pass > 1) return std::nullopt;
            known_[value] = true;
            reference_[value] = last_[value] = at;
        }
        if (passes_[value] == pass) return std::nullopt;
        grown_[value] = passes_[value] > 0;
        change_[value] = grown_[value] ? at - last_[value] : 0;
        passes_[value] = pass;
        last_[value] = at;
        return at - reference_[value];
    }

    // How far a known position is from the last one: as it is, and less the mean change of the other bores at
    // this orientation in this pass, if there are any.
    struct Step {
        double whole = 0;
        std::optional<double> alone;
    };
    Step step(std::size_t value, double at, std::int32_t pass) const noexcept {
        Step step;
        step.whole = at - last_[value];
        double sum = 0;
        int others = 0;
        constexpr std::size_t per_bore = 6;
        for (std::size_t i = value % per_bore; i < last_.size(); i += per_bore) {
            if (i == value || passes_[i] != pass || !grown_[i]) continue;
            sum += change_[i];
            ++others;
        }
        const bool again = passes_[value] == pass;  // the others have not changed since then
        if (again || others > 0) step.alone = step.whole - (again ? 0 : sum / others);
        return step;
    }

private:
    std::array<bool, StopRule::most_values> known_{};
    std::array<bool, StopRule::most_values> grown_{};  // it was known in a pass before
    std::array<double, StopRule::most_values> reference_{}, last_{},
        change_{};                                              // change_: since the pass before
    std::array<std::int32_t, StopRule::most_values> passes_{};  // of the last deviation
};

// The touches of one visit: those of the circle of a bore, and those of its face. Lengths in mu.
class ProbedBore {
public:
    void clear() noexcept {
        circle_.clear();
        face_ = 0;
        faces_ = 0;
    }

    // A touch in Z, direction 3 or -3, is one of the face.
    void add(std::int32_t direction, double x, double y, double z) noexcept {
        if (std::abs(direction) != 3) {
            if (circle_.add({x, y}))
                sides_[static_cast<std::size_t>(circle_.count() - 1)] = {x, y, std::abs(direction) == 1};
            return;
        }
        face_low_ = faces_ == 0 ? z : std::min(face_low_, z);
        face_high_ = faces_ == 0 ? z : std::max(face_high_, z);
        face_ += z;
        ++faces_;
    }

    bool has_circle() const noexcept { return circle_.count() > 0; }
    bool has_face() const noexcept { return faces_ > 0; }
    // See BoreTouches.
    std::optional<BoreTouches::Centre> centre() const noexcept { return circle_.centre(); }
    // How far the touches along X are outside of the circle, less those along Y, in the mean. A touch that is
    // wrong by e changes it by e / 2, the lobes of the probe do not. Only if there is a centre.
    double oval(const BoreTouches::Centre& centre) const noexcept {
        double sum[2]{}, count[2]{};
        for (int i = 0; i < circle_.count(); ++i) {
            const Side& side = sides_[static_cast<std::size_t>(i)];
            sum[side.along_x] +=
                std::hypot(side.x - centre.place.x(), side.y - centre.place.y()) - centre.radius;
            ++count[side.along_x];
        }
        return count[0] > 0 && count[1] > 0 ? sum[1] / count[1] - sum[0] / count[0] : 0;
    }
    // Mean Z of the face, and the difference of its touches; only if there is one.
    double face() const noexcept { return face_ / faces_; }
    double face_range() const noexcept { return face_high_ - face_low_; }

private:
    struct Side {
        double x = 0, y = 0;
        bool along_x = false;
    };

    BoreTouches circle_;
    std::array<Side, BoreTouches::most> sides_{};
    double face_ = 0, face_low_ = 0, face_high_ = 0;
    int faces_ = 0;
};

// Finds a slip of the whole artifact on its table between two passes. Growth moves the spindle against the
// table, and so all bores alike at both orientations of the table; a slip turns with the table, and shows at
// once. Without a second orientation, and along the axis of the table, only its course tells: growth under
// equal work goes on from pass to pass, a slip comes once. The pass after it shows that.
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
        Sum& sum = sums_[static_cast<std::size_t>(axis)][turned ? 1 : 0];
        sum.value += deviation;
        ++sum.count;
    }

    // The change of a bore since its first visit in this pass: the stopped spindle cools meanwhile.
    void take_again(int axis, double change) noexcept {
        double& drift = drift_[static_cast<std::size_t>(axis)];
        drift = std::fmax(drift, std::abs(change));
    }

    // A pass ends at `time`, s. `work`: the mean speed of the spindle since the pass before; not a number if
    // it is not known. A slip below `least`, mu, is not looked for.
    std::optional<Slip> end_pass(double time, double work, double least) noexcept {
        Pass now;
        now.time = time;
        now.work = work;
        now.drift = drift_;
        drift_.fill(NAN);
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t turned = 0; turned < 2; ++turned) {
                const Sum& sum = sums_[axis][turned];
                now.count[axis][turned] = sum.count;
                now.mean[axis][turned] = sum.count > 0 ? sum.value / sum.count : NAN;
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
            const double after = step(0, axis), middle = step(1, axis), first = step(2, axis);
            // However quickly growth dies away, half of the larger neighbour is left.
            const double alone = middle - (first + after) / 2;
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

        double half_difference(std::size_t axis) const noexcept {
            return (mean[axis][0] - mean[axis][1]) / 2;
        }
        // Of all that was probed.
        double middle(std::size_t axis) const noexcept {
            const auto& means = mean[axis];
            return std::isnan(means[1])   ? means[0]
                   : std::isnan(means[0]) ? means[1]
                                          : (means[0] + means[1]) / 2;
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

// The mean of a quantity over time.
class MeanOverTime {
public:
    // A value for so many seconds. A value that is not within ±limit does not count.
    void step(double value, double limit, double dt) noexcept {
        if (!(std::abs(value) <= limit)) return;
        sum_ += value * dt;
        time_ += dt;
    }

    // The mean since the last one was taken; nothing if no value counted.
    std::optional<double> take() noexcept {
        const std::optional<double> mean = time_ > 0 ? std::optional(sum_ / time_) : std::nullopt;
        clear();
        return mean;
    }

    void clear() noexcept { sum_ = time_ = 0; }

private:
    double sum_ = 0, time_ = 0;
};

}  // namespace plumb
