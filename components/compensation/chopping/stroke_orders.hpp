// SPDX-License-Identifier: GPL-2.0-or-later
// Orders to a stroke: pins give them (StrokeOrders), an axis gives them when it crosses a coordinate
// (Crossing), and a program gives them by words (StrokeWords). The words go before the settings.
#pragma once

#include "components/compensation/chopping/infeed.hpp"
#include "components/compensation/chopping/stroke_settings.hpp"
#include "components/math/blocks/edge.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace plumb {

// Whether a position crosses a coordinate, either way. A move that ends at the coordinate has crossed it. A
// new coordinate, or an invalid value, is no crossing.
class Crossing {
public:
    bool step(double position, double coordinate, double farthest) noexcept {
        if (!(std::abs(position) <= farthest && std::abs(coordinate) <= farthest)) return false;
        const int before = std::exchange(place_, (position > coordinate) - (position < coordinate));
        const bool same = std::exchange(coordinate_, coordinate) == coordinate;
        const int side = !same || place_ != 0 ? place_ : before != 0 ? -side_ : side_;
        return std::exchange(side_, side) * side < 0 && same;
    }

private:
    double coordinate_ = 0;
    int place_ = 0, side_ = 0;  // below -1, above 1; side: after the last crossing, 0 before it was seen
};

// The orders of the program and the operator, out of bits that stay. The end of a program ends the strokes
// that the program began. The begin of a program ends other strokes, and its moves wait for the axis.
class StrokeOrders {
public:
    // The bits of a period.
    struct Given {
        bool run = false, stop = false, enable = true, go_to_end = false, shift = false;
        bool shift_at_crossing = false;
        // outlasts: strokes go on when a program ends or begins
        bool program_running = false, outlasts = false;
        double crossing_position = 0, crossing_at = 0, farthest = 0;  // mu
    };

    // The orders of a period.
    struct Now {
        bool starts = false, returns = false, shifts = false;  // in this period
        bool run = false;                                      // the bit itself
        bool ordered = false;                                  // by the program or in MDI
        bool ended = false;                                    // by a program, which they do not outlast
        bool runs = false;                                     // strokes go on
        bool permitted = true;                                 // by enable
    };

    // One period of dt s.
    Now step(const Given& given, double dt) noexcept {
        Now now;
        now.run = given.run;
        now.permitted = given.enable;
        now.returns = end_.rises(given.go_to_end);
        now.starts = run_.rises(given.run);
        watch_program(given, now.starts, dt);
        now.ended = ended_;
        now.ordered = given.run && !ended_;
        now.runs = now.ordered && !given.stop;
        const bool crosses = crossing_.step(given.crossing_position, given.crossing_at, given.farthest);
        now.shifts = shift_.changes(given.shift) || (crosses && given.shift_at_crossing);
        return now;
    }

private:
    // A program that has begun is seen some time later.
    void watch_program(const Given& given, bool starts, double dt) noexcept {
        if (starts) {
            of_program_ = ended_ = false;
            since_start_ = 0;
        }
        since_start_ = std::min(since_start_ + dt, 2 * patience);
        const bool begins = program_.rises(given.program_running);
        if (given.program_running && since_start_ <= patience) of_program_ = true;
        const bool ends = of_program_ && !given.program_running;
        if (!ends && (of_program_ || !begins)) return;
        of_program_ = false;
        ended_ |= !given.outlasts;
    }

    static constexpr double patience = 1;  // s

    double since_start_ = 2 * patience;  // s
    bool of_program_ = false, ended_ = false;
    Edge run_, end_, program_, shift_;
    Crossing crossing_;
};

// The words that a program gives for its strokes, one after the other, as a number and a value. They go
// before the settings until the strokes end.
class StrokeWords {
public:
    enum Number : std::int32_t {
        none,
        upper_dwell,       // s
        lower_dwell,       // s
        exact_stop,        // mu, 0 without
        spark_out,         // strokes
        stop_place,        // 0 the end position, 1 the lower, 2 the upper dead point
        overrides,         // 1 the override multiplies the speed, 0 it does not
        section_from,      // mu
        section_to,        // mu
        section_ratio,     // 1
        section,           // adds this section: its SpeedSection::Kind
        without_sections,  // removes all sections, also the sections of the settings
        check,             // whether a stroke is possible that begins and ends at this position, mu
        forget,            // all words
        go_to_end,         // from where the axis rests
        abort,             // of the program
        infeed_amount,     // mu, by its sign inward; 0 without
        infeed_total,      // mu
        infeed_at,         // an Infeed::Place
        shift = 100        // and above: takes over the dead points, by each new number
    };

    // A number that changes gives its word. Words are forgotten when the axis rests.
    void step(double number, double value, bool moves) noexcept {
        if (moved_ && !moves) forgets_ = true;
        moved_ = moves;
        returns_ = shifts_ = aborts_ = changes_ = false;
        if (number != number_) {
            number_ = number;
            refused_ = !give(number, value);
            changes_ = true;
        }
        if (!forgets_ || moves) return;
        forgets_ = false;
        words_ = {};
        changes_ = true;
    }

    // The end of a program is the end of its words. It is seen some time later, so that words which are as
    // new stay.
    void watch_program(bool runs, double dt) noexcept {
        const bool gives = number_ != none && !(number_ >= shift);  // a shift stays as it is
        since_word_ = gives ? 0 : std::min(since_word_ + dt, 2 * newest);
        if (program_ && !runs && since_word_ > newest) forgets_ = true;
        program_ = runs;
    }

    // Puts the words in the place of their settings.
    void replace(Infeed::Settings& its) const noexcept {
        put(words_.infeed_amount, its.amount);
        put(words_.infeed_total, its.total);
        put(words_.infeed_at, its.at);
    }
    void replace(StrokeSettings& its) const noexcept {
        put(words_.upper_dwell, its.upper_dwell);
        put(words_.lower_dwell, its.lower_dwell);
        put(words_.exact_stop, its.exact_stop);
        put(words_.spark_out, its.spark_out);
        if (words_.stop_place) its.stop_kind = stop_kinds[static_cast<std::size_t>(*words_.stop_place)];
        if (words_.overrides == 0.0 && its.override_ != 0) its.override_ = 1;
        if (words_.own_sections) its.section = words_.sections;
    }

    // Whether a stroke from a position is to be checked now, and that position, mu.
    bool checks() const noexcept { return number_ == check; }
    double checked() const noexcept { return checked_; }

    bool returns() const noexcept { return returns_; }  // to the end position, ordered in this period
    bool shifts() const noexcept { return shifts_; }    // the region, ordered in this period
    bool aborts() const noexcept { return aborts_; }    // ordered in this period
    bool refused() const noexcept { return refused_; }  // the last word
    bool changes() const noexcept { return changes_; }  // replace() gives something else in this period
    std::size_t sections() const noexcept { return words_.count; }

private:
    using Word = std::optional<double>;

    struct Words {
        Word upper_dwell, lower_dwell, exact_stop, spark_out, stop_place, overrides;
        Word infeed_amount, infeed_total, infeed_at;
        SpeedSection next;  // that is being given
        SpeedSections::Table sections{};
        std::size_t count = 0;
        bool own_sections = false;
    };

    static constexpr std::int32_t stop_kinds[] = {StrokeSettings::at_end, StrokeSettings::at_lower,
                                                  StrokeSettings::at_upper};

    bool give(double number, double value) noexcept {
        if (number >= shift && number <= last_shift) return shifts_ = number == std::floor(number);
        if (!(number >= none && number <= infeed_at && number == std::floor(number))) return false;
        switch (static_cast<Number>(static_cast<std::int32_t>(number))) {
            case none: return true;
            case upper_dwell: return take(words_.upper_dwell, value, 3600);
            case lower_dwell: return take(words_.lower_dwell, value, 3600);
            case exact_stop: return take(words_.exact_stop, value, StrokeSettings::farthest);
            case spark_out: return take_whole(words_.spark_out, value, 1e6);
            case stop_place: return take_whole(words_.stop_place, value, 2);
            case overrides: return take_whole(words_.overrides, value, 1);
            case section_from: return take_place(words_.next.from, value);
            case section_to: return take_place(words_.next.to, value);
            case section_ratio: return take_place(words_.next.ratio, value);
            case section: return add_section(value);
            case without_sections:
                words_.sections = {};
                words_.count = 0;
                words_.own_sections = true;
                return true;
            case check: return take_place(checked_, value);
            case forget: forgets_ = true; return true;
            case go_to_end: returns_ = true; return true;
            case abort: aborts_ = true; return true;
            case infeed_amount: return take_place(words_.infeed_amount, value);
            case infeed_total: return take(words_.infeed_total, value, StrokeSettings::farthest);
            case infeed_at: return take_whole(words_.infeed_at, value, Infeed::both);
            case shift: break;
        }
        return false;
    }

    template <class T>
    static void put(const Word& word, T& place) noexcept {
        if (word) place = static_cast<T>(*word);
    }
    static bool take(Word& word, double value, double most) noexcept {
        const bool possible = value >= 0 && value <= most;
        if (possible) word = value;
        return possible;
    }
    static bool take_whole(Word& word, double value, double most) noexcept {
        return value == std::floor(value) && take(word, value, most);
    }
    template <class T>
    static bool take_place(T& place, double value) noexcept {
        const bool possible = std::abs(value) <= StrokeSettings::farthest;
        if (possible) place = value;
        return possible;
    }

    bool add_section(double kind) noexcept {
        SpeedSections::Table table{};
        table[0] = words_.next;
        if (words_.count == SpeedSections::most ||
            !(kind >= SpeedSection::height && kind <= SpeedSection::height_downward &&
              kind == std::floor(kind)))
            return false;
        table[0].kind = static_cast<std::int32_t>(kind);
        if (!SpeedSections::valid(table)) return false;
        words_.sections[words_.count++] = table[0];
        words_.own_sections = true;
        return true;
    }

    static constexpr double newest = 0.5;      // s
    static constexpr double last_shift = 1e9;  // a number

    Words words_;
    double since_word_ = 0;  // s
    bool program_ = false;
    double number_ = 0, checked_ = 0;
    bool refused_ = false, forgets_ = false, moved_ = false, returns_ = false, shifts_ = false;
    bool aborts_ = false, changes_ = false;
};

}  // namespace plumb
