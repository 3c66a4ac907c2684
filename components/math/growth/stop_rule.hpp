// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

enum class StopReason : std::int32_t { none, stable, maximum_time };

// Decides when a machine is warm. Realtime: fixed size, no allocation.
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

    struct Settings {
        double threshold = 0.5;  // K
        double interval = hour;  // s; 0: one cycle
        double minimum_time = 4 * hour;
        double maximum_time = 12 * hour;
        double range_share = 0.15;    // of the range in the first hour
        double range_floor = 0.002;   // mu
        double uncertainty = 0.0007;  // mu, of a deviation
        bool by_displacement = true;
        std::uint32_t sensors = 0xff;  // a bit each

        // An interval of one sample or less would compare a value with itself.
        bool valid() const noexcept {
            const auto within = [](double x, double most) { return x >= 0 && x <= most; };
            return threshold > 0 && threshold <= 1000 && within(interval, 24 * hour) &&
                   within(minimum_time, 240 * hour) && within(maximum_time, 240 * hour) && maximum_time > 0 &&
                   minimum_time <= maximum_time && within(range_share, 1) && within(range_floor, 1e3) &&
                   within(uncertainty, 1e3);
        }
        // The range for which the source states the rule.
        bool usual() const noexcept { return threshold >= 0.5 && threshold <= 5; }
    };

    using Temperatures = std::array<double, most_sensors>;  // degC; not a number: unknown

    void clear() noexcept {
        samples_.clear();
        ends_.clear();
        cycles_ = 0;
        for (Series& its : series_) its.count = 0;
    }

    // Temperatures at a time, a few seconds or more after the last ones.
    void sample(double time, const Temperatures& now, const Settings& settings) noexcept {
        latest_ = now;
        latest_time_ = time;
        const double every = settings.interval / (History::most - 1);
        if (settings.interval > 0) samples_.take(time, now, every * (1 - 1e-9));
    }

    // A cycle of the machine ends: the temperatures of now are those of this cycle.
    void cycle_ends(double time, const Settings& settings) noexcept {
        ++cycles_;
        latest_time_ = time;
        ends_.take(time, latest_, settings.interval / (History::most - 1) * (1 - 1e-9));
    }

    // Largest change of a sensor within the interval, in K; infinite while it is unknown. A machine that
    // works in cycles is compared at the ends of cycles: its temperatures rise and fall within each.
    double change(const Settings& settings) const noexcept {
        if (cycles_ == 0)
            return settings.interval > 0
                       ? change(samples_, latest_, latest_time_ - settings.interval, settings)
                       : unknown;
        const double then = ends_.time(0) - std::max(settings.interval, 1e-3);
        return change(ends_, ends_.value(0), then, settings);
    }

    // The deviation number `index` at a time, in mu. Those of one pass come together.
    void deviation(double time, int index, double value) noexcept {
        if (index < 0 || index >= most_values || !std::isfinite(value)) return;
        Series& its = series_[static_cast<std::size_t>(index)];
        if (its.count == 0) {
            its.began = time;
            its.first = Range();
            its.last_hour.clear();
        }
        if (time <= its.began + hour || its.count < 2) its.first.take(value);
        its.last_hour.take(time, value);
        ++its.count;
    }

    // Whether the second rule holds for all deviations. They must span the last hour, beyond the first one.
    bool ranges_are_small(double time, const Settings& settings) const noexcept {
        bool any = false;
        for (const Series& its : series_) {
            if (its.count == 0) continue;
            any = true;
            if (time - its.began < 2 * hour) return false;
            const Range recent = its.last_hour.range(time);
            if (!recent.spans) return false;
            const double most = std::max(
                {settings.range_share * its.first.width(), 4 * settings.uncertainty, settings.range_floor});
            if (!(recent.width() <= most)) return false;
        }
        return any;
    }

    StopReason reason(double time, const Settings& settings) const noexcept {
        if (time >= settings.maximum_time) return StopReason::maximum_time;
        if (time < settings.minimum_time) return StopReason::none;
        if (!(change(settings) <= settings.threshold)) return StopReason::none;
        if (settings.by_displacement && !ranges_are_small(time, settings)) return StopReason::none;
        return StopReason::stable;
    }

    int cycles() const noexcept { return cycles_; }

private:
    static constexpr double unknown = HUGE_VAL;

    // The last temperatures.
    class History {
    public:
        static constexpr int most = 65;

        // Those that come sooner than `every` after the last ones are left out.
        void take(double time, const Temperatures& value, double every) noexcept {
            if (count_ > 0 && time - times_[index(0)] < every) return;
            next_ = (next_ + 1) % most;
            count_ = std::min(count_ + 1, most);
            times_[index(0)] = time;
            values_[index(0)] = value;
        }
        void clear() noexcept { count_ = 0; }
        int count() const noexcept { return count_; }
        // So many before the last.
        double time(int before) const noexcept { return times_[index(before)]; }
        const Temperatures& value(int before) const noexcept { return values_[index(before)]; }

    private:
        std::size_t index(int before) const noexcept {
            return static_cast<std::size_t>((next_ - before + most) % most);
        }

        std::array<double, most> times_{};
        std::array<Temperatures, most> values_{};
        int next_ = most - 1, count_ = 0;
    };

    struct Range {
        double low = HUGE_VAL, high = -HUGE_VAL;
        bool spans = false;

        void take(double value) noexcept {
            low = std::min(low, value);
            high = std::max(high, value);
        }
        double width() const noexcept { return high >= low ? high - low : 0; }
    };

    // The values of the last hour. Passes are minutes apart; of more than `most`, neighbours are merged.
    class Recent {
    public:
        void clear() noexcept { count_ = 0; }

        void take(double time, double value) noexcept {
            if (count_ == 0 || time - slot(0).begin >= hour / (most - 1)) {
                next_ = (next_ + 1) % most;
                count_ = std::min(count_ + 1, most);
                slot(0) = {time, {}};
            }
            slot(0).range.take(value);
        }

        // With the last value before the hour began, without which the hour is not spanned.
        Range range(double time) const noexcept {
            Range all;
            for (int i = 0; i < count_; ++i) {
                const Slot& one = slot(i);
                all.take(one.range.low);
                all.take(one.range.high);
                all.spans = one.begin <= time - hour;
                if (all.spans) break;
            }
            return all;
        }

    private:
        static constexpr int most = 24;
        struct Slot {
            double begin = 0;
            Range range;
        };

        // The slot so many before the last one.
        Slot& slot(int before) noexcept {
            return slots_[static_cast<std::size_t>((next_ - before + most) % most)];
        }
        const Slot& slot(int before) const noexcept {
            return slots_[static_cast<std::size_t>((next_ - before + most) % most)];
        }

        std::array<Slot, most> slots_{};
        int next_ = most - 1, count_ = 0;
    };

    struct Series {
        double began = 0;
        std::int64_t count = 0;
        Range first;
        Recent last_hour;
    };

    // Against the youngest ones that are at least as old as `then`.
    static double change(const History& history, const Temperatures& now, double then,
                         const Settings& settings) noexcept {
        for (int i = 0; i < history.count(); ++i)
            if (history.time(i) <= then + 1e-6 * settings.interval)
                return largest(now, history.value(i), settings.sensors);
        return unknown;
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

    History samples_, ends_;
    Temperatures latest_{};
    double latest_time_ = 0;
    int cycles_ = 0;
    std::array<Series, most_values> series_{};
};

}  // namespace plumb
