// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/pi.hpp"
#include "components/math/oscillation/reciprocation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

// A part of the stroke with a speed of its own, [from, to).
struct SpeedSection {
    // What from and to are. A phase section may wrap through 2 pi; heights hold for one direction or both.
    enum Kind : std::int32_t { off, phase, height, height_upward, height_downward };

    std::int32_t kind = off;
    double from = 0, to = 0;  // rad, 0 to 2 pi; or mu, from < to
    double ratio = 1;         // of the speed there to the speed without sections

    bool operator==(const SpeedSection& other) const noexcept {
        return kind == other.kind && from == other.from && to == other.to && ratio == other.ratio;
    }
};

// A piece of a stroke in one direction.
struct SpeedSpan {
    double from = 0, to = 0;  // mu, from < to
    double ratio = 1;

    bool operator==(const SpeedSpan& other) const noexcept {
        return from == other.from && to == other.to && ratio == other.ratio;
    }
};

// Up to four sections, and the pieces that they make of a stroke.
class SpeedSections {
public:
    static constexpr std::size_t most = 4;
    static constexpr std::size_t most_spans = 2 * most;  // a section that wraps is two pieces
    static constexpr double least_ratio = 1e-3, largest_ratio = 1e3;
    using Table = std::array<SpeedSection, most>;

    struct Spans {
        std::array<SpeedSpan, most_spans> list;  // ascending, disjoint
        std::size_t count = 0;

        const SpeedSpan* begin() const noexcept { return list.data(); }
        const SpeedSpan* end() const noexcept { return list.data() + count; }
        bool operator==(const Spans& other) const noexcept {
            return count == other.count && std::equal(begin(), end(), other.begin());
        }
    };

    // The pieces of an upward or a downward stroke. Requires sections that are valid one by one.
    static Spans spans(const Table& table, const Reciprocation& base, bool upward) noexcept {
        Spans result;
        const auto add = [&](double from, double to, double ratio) {
            from = std::max(from, base.lower);
            to = std::min(to, base.upper);
            if (!(from < to) || result.count == most_spans) return;
            std::size_t place = result.count++;
            for (; place > 0 && result.list[place - 1].from > from; --place)
                result.list[place] = result.list[place - 1];
            result.list[place] = {from, to, ratio};
        };
        // Of phases 0 <= from < to <= 2 pi.
        const auto add_phases = [&](double from, double to, double ratio) {
            const double low = upward ? from : 2 * pi - to, high = upward ? to : 2 * pi - from;
            if (low < pi) add(base.position(std::max(low, 0.0)), base.position(std::min(high, pi)), ratio);
        };
        for (const SpeedSection& each : table) {
            switch (each.kind) {
                case SpeedSection::phase:
                    if (each.from < each.to) {
                        add_phases(each.from, each.to, each.ratio);
                    } else {
                        add_phases(each.from, 2 * pi, each.ratio);
                        add_phases(0, each.to, each.ratio);
                    }
                    break;
                case SpeedSection::height: add(each.from, each.to, each.ratio); break;
                case SpeedSection::height_upward:
                    if (upward) add(each.from, each.to, each.ratio);
                    break;
                case SpeedSection::height_downward:
                    if (!upward) add(each.from, each.to, each.ratio);
                    break;
                default: break;
            }
        }
        return result;
    }

    // Whether each section alone is possible, whatever the region. False for NaN too.
    static bool valid(const Table& table) noexcept {
        return std::all_of(table.begin(), table.end(), [](const SpeedSection& each) {
            if (each.kind == SpeedSection::off) return true;
            if (!(each.ratio >= least_ratio && each.ratio <= largest_ratio)) return false;
            if (each.kind == SpeedSection::phase)
                return each.from >= 0 && each.from <= 2 * pi && each.to >= 0 && each.to <= 2 * pi &&
                       each.from != each.to;
            return each.kind >= SpeedSection::height && each.kind <= SpeedSection::height_downward &&
                   each.from < each.to && each.from >= -1e9 && each.to <= 1e9;
        });
    }

    // Whether two pieces of a stroke share more than rounding.
    static bool overlap(const Table& table, const Reciprocation& base) noexcept {
        const double slack = 1e-9 * base.stroke();
        for (const bool upward : {false, true}) {
            const Spans its = spans(table, base, upward);
            for (std::size_t i = 1; i < its.count; ++i)
                if (its.list[i].from < its.list[i - 1].to - slack) return true;
        }
        return false;
    }

    // The pieces of a phase section at a dead point make this the ratio there.
    static double ratio_at(const Spans& spans, double position) noexcept {
        for (const SpeedSpan& each : spans)
            if (position >= each.from && position <= each.to) return each.ratio;
        return 1;
    }
};

}  // namespace plumb
