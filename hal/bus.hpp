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
        const std::uint32_t word = sender(who, where) | row << 24 | content << 8;
        return beating(word | ((word >> 24 ^ word >> 16 ^ word >> 8 ^ salt) & 0xFFU), beat);
    }
    // A word of beat 0 at another beat, which lies in one byte, and so in the check, too.
    static constexpr std::uint32_t beating(std::uint32_t word, std::uint32_t beat) noexcept {
        const std::uint32_t its = beat % beats;
        return word ^ (its << 17 | its << 1);
    }

    // Whether such a word may come from there at all.
    static constexpr bool fits(std::uint32_t word, Party who, Direction where) noexcept {
        return checks(word) && ((word ^ sender(who, where)) & who_and_where) == 0;
    }
    static constexpr std::uint32_t row(std::uint32_t word) noexcept { return word >> 24 & no_row; }
    static constexpr std::uint32_t beat(std::uint32_t word) noexcept { return word >> 17 & 63; }
    static constexpr std::uint32_t content(std::uint32_t word) noexcept {
        return word >> 8 & ((1U << content_bits) - 1);
    }

private:
    friend class BusListener;
    static constexpr std::uint32_t salt = 0xA5, who_and_where = 0xE0800000;  // bits of the word

    static constexpr std::uint32_t sender(Party who, Direction where) noexcept {
        return 1U << 31 | static_cast<std::uint32_t>(who) << 29 | static_cast<std::uint32_t>(where) << 23;
    }
    static constexpr bool checks(std::uint32_t word) noexcept {
        const std::uint32_t halves = word ^ word >> 16;
        return ((halves ^ halves >> 8) & 0xFFU) == salt;
    }
};

// One end that listens.
class BusListener {
public:
    // One that takes the row of the first word.
    BusListener(Party who, Direction where) : BusListener(who, where, BusWord::no_row, 10) {}
    // dead: periods without a beat.
    BusListener(Party who, Direction where, std::uint32_t row, int dead)
        : sender_(BusWord::sender(who, where)),
          is_program_(who == Party::program),
          row_(row),
          dead_(dead),
          silence_(dead) {}

    // Once in each period.
    void step(std::uint32_t word) noexcept {
        const bool fits = BusWord::checks(word) && is_mine(word);
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
    bool is_mine(std::uint32_t word) const noexcept {
        const std::uint32_t other = (word ^ (sender_ | row_ << 24)) & (BusWord::who_and_where | 31U << 24);
        if (other == 0) return true;
        if ((other & BusWord::who_and_where) != 0) return false;
        return (is_program_ ? BusWord::row(word) : row_) == BusWord::no_row;
    }

    std::uint32_t sender_;
    bool is_program_, heard_ = false, fitted_ = false;
    std::uint32_t row_, beat_ = 0, content_ = 0;
    int dead_, silence_;
};

}  // namespace plumb::hal
