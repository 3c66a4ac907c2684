// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/chopping/infeed.hpp"
#include "components/compensation/chopping/stroke_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {

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
        without_sections,  // removes all, also those of settings
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
        returns_ = shifts_ = aborts_ = false;
        if (number != number_) {
            number_ = number;
            refused_ = !give(number, value);
        }
        if (!forgets_ || moves) return;
        forgets_ = false;
        words_ = {};
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
        if (words_.infeed_at.given) its.at = static_cast<std::int32_t>(words_.infeed_at.value);
    }
    void replace(StrokeValues& its) const noexcept {
        put(words_.upper_dwell, its.stroke.upper_dwell);
        put(words_.lower_dwell, its.stroke.lower_dwell);
        put(words_.exact_stop, its.exact_stop);
        if (words_.spark_out.given) its.stroke.spark_out = static_cast<std::int32_t>(words_.spark_out.value);
        if (words_.stop_place.given) its.set_stop_kind(stop_kinds[static_cast<int>(words_.stop_place.value)]);
        if (words_.overrides.given && words_.overrides.value == 0 && its.override_value != 0)
            its.override_value = 1;
        if (words_.own_sections) its.stroke.sections = words_.sections;
    }

    // Whether a stroke from a position is to be checked now, and that position, mu.
    bool checks() const noexcept { return number_ == check; }
    double checked() const noexcept { return checked_; }

    bool returns() const noexcept { return returns_; }  // to the end position, ordered in this period
    bool shifts() const noexcept { return shifts_; }    // the region, ordered in this period
    bool aborts() const noexcept { return aborts_; }    // ordered in this period
    bool refused() const noexcept { return refused_; }  // the last word
    std::size_t sections() const noexcept { return words_.count; }

private:
    struct Word {
        double value = 0;
        bool given = false;
    };

    struct Words {
        Word upper_dwell, lower_dwell, exact_stop, spark_out, stop_place, overrides;
        Word infeed_amount, infeed_total, infeed_at;
        SpeedSection next;  // that is being given
        SpeedSections::Table sections{};
        std::size_t count = 0;
        bool own_sections = false;
    };

    static constexpr std::int32_t stop_kinds[] = {StrokeValues::at_end, StrokeValues::at_lower,
                                                  StrokeValues::at_upper};

    bool give(double number, double value) noexcept {
        if (number >= shift && number <= last_shift) return shifts_ = number == std::floor(number);
        if (!(number >= none && number <= infeed_at && number == std::floor(number))) return false;
        switch (static_cast<Number>(static_cast<std::int32_t>(number))) {
            case none: return true;
            case upper_dwell: return take(words_.upper_dwell, value, 3600);
            case lower_dwell: return take(words_.lower_dwell, value, 3600);
            case exact_stop: return take(words_.exact_stop, value, StrokeValues::farthest);
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
            case infeed_amount:
                if (!(std::abs(value) <= StrokeValues::farthest)) return false;
                words_.infeed_amount = {value, true};
                return true;
            case infeed_total: return take(words_.infeed_total, value, StrokeValues::farthest);
            case infeed_at: return take_whole(words_.infeed_at, value, Infeed::both);
            case shift: break;
        }
        return false;
    }

    static void put(const Word& word, double& place) noexcept {
        if (word.given) place = word.value;
    }
    static bool take(Word& word, double value, double most) noexcept {
        const bool possible = value >= 0 && value <= most;
        if (possible) word = {value, true};
        return possible;
    }
    static bool take_whole(Word& word, double value, double most) noexcept {
        return value == std::floor(value) && take(word, value, most);
    }
    static bool take_place(double& place, double value) noexcept {
        const bool possible = std::abs(value) <= StrokeValues::farthest;
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
    bool aborts_ = false;
};

}  // namespace plumb
