// SPDX-License-Identifier: GPL-2.0-or-later
// The bus between interlock and all that it permits: to each stage and function one word, its permit, and
// from each one word, its state. A program that functions need has a state, too. A word says all that holds
// in one period:
//
//     bits 31       1
//          30-29    who: 1 a stage, 2 a function, 3 a program
//          28-24    row: its number at interlock; 31 in the state of one that has no permit yet, and of a
//                   program that may be any service
//          23       1 from interlock, 0 to it
//          22-17    beat: counts the periods
//          16-8     content, see the manual pages
//          7-0      check: the exclusive or of the other three bytes and of 0xA5
//
// Whoever listens takes a word only from who it expects, from the row that it expects, and with a right
// check. A stage or function takes the row of its first permit, and says it in its state: so interlock sees
// each net that ends at another one's pin. A word that stands still is void.
#pragma once

#include <algorithm>
#include <cstdint>

namespace plumb::hal {

enum class Party : std::uint32_t { stage = 1, function = 2, program = 3 };
enum class Direction : std::uint32_t { to_interlock, from_interlock };

struct BusWord {
    static constexpr std::uint32_t no_row = 31, content_bits = 9;
    static constexpr std::uint32_t beats = 61;  // no thread is slower by a multiple of it

    static constexpr std::uint32_t of(Party who, Direction where, std::uint32_t row, std::uint32_t beat,
                                      std::uint32_t content) noexcept {
        const std::uint32_t word = 1U << 31 | static_cast<std::uint32_t>(who) << 29 | row << 24 |
                                   static_cast<std::uint32_t>(where) << 23 | beat % beats << 17 |
                                   content << 8;
        return word | check(word);
    }

    // Whether such a word may come from there at all.
    static constexpr bool fits(std::uint32_t word, Party who, Direction where) noexcept {
        constexpr std::uint32_t sender = 0xE0800000U;  // all but the row
        return (word & 0xFFU) == check(word) && (word & sender) == (of(who, where, 0, 0, 0) & sender);
    }
    static constexpr std::uint32_t row(std::uint32_t word) noexcept { return word >> 24 & no_row; }
    static constexpr std::uint32_t beat(std::uint32_t word) noexcept { return word >> 17 & 63; }
    static constexpr std::uint32_t content(std::uint32_t word) noexcept {
        return word >> 8 & ((1U << content_bits) - 1);
    }

private:
    static constexpr std::uint32_t check(std::uint32_t word) noexcept {
        return (word >> 24 ^ word >> 16 ^ word >> 8 ^ 0xA5U) & 0xFFU;
    }
};

// One end that listens.
class BusListener {
public:
    // One that takes the row of the first word.
    BusListener(Party who, Direction where) : BusListener(who, where, BusWord::no_row, 10) {}
    // dead: periods without a beat.
    BusListener(Party who, Direction where, std::uint32_t row, int dead)
        : who_(who), where_(where), row_(row), dead_(dead), silence_(dead) {}

    // Once in each period.
    void step(std::uint32_t word) noexcept {
        const bool fits = BusWord::fits(word, who_, where_) && is_mine(BusWord::row(word));
        const bool mine = fits && fitted_;  // one alone may be a chance of another number
        fitted_ = fits;
        const bool beats = mine && heard_ && BusWord::beat(word) != beat_;
        silence_ = beats ? 0 : std::min(silence_ + 1, 2 * dead_);
        if (!mine) return;
        heard_ = true;
        if (row_ == BusWord::no_row) row_ = BusWord::row(word);
        beat_ = BusWord::beat(word);
        content_ = BusWord::content(word);
    }

    std::uint32_t row() const noexcept { return row_; }
    std::uint32_t content() const noexcept { return content_; }  // of the last good word; 0 before it
    bool heard() const noexcept { return heard_; }
    bool beats() const noexcept { return silence_ == 0; }  // in this period
    bool alive() const noexcept { return silence_ < dead_; }
    // Dead for so long that it is a fault, and not the first periods.
    bool missed() const noexcept { return silence_ >= 2 * dead_; }

private:
    bool is_mine(std::uint32_t row) const noexcept {
        const bool unknown = row == BusWord::no_row;
        return row == row_ || (who_ == Party::program ? unknown : row_ == BusWord::no_row && !unknown);
    }

    Party who_;
    Direction where_;
    std::uint32_t row_, beat_ = 0, content_ = 0;
    bool heard_ = false, fitted_ = false;
    int dead_, silence_;
};

}  // namespace plumb::hal
