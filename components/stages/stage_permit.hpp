// SPDX-License-Identifier: GPL-2.0-or-later
// How interlock permits a stage: one word in each period, which says all that the stage may do now.
//
// A stage takes a word only if it has the number of the stage at interlock, and a beat that goes on. A word
// that stands still, that is not of interlock or that is for another stage is void as a whole: the stage
// holds its offset, and one that never had a word applies nothing.
#pragma once

#include "components/math/blocks/live_counter.hpp"
#include "hal/component.hpp"

#include <cstdint>
#include <stdexcept>
#include <string>

namespace plumb {

struct Permit {
    bool enable = false;      // the stage may apply its offset
    bool arm = false;         // a cycle runs, or a trial of this stage
    bool hold = false;        // another stage is on trial: nothing moves here
    std::int32_t source = 0;  // that alone acts in a trial, counted from 1; 0: all
};

// The bits: beat 6, row 5, enable, arm, hold, source 3, and a check of these 17.
class PermitWord {
public:
    static constexpr std::int32_t beats = 64, rows = 31, none = -1;

    static constexpr std::int32_t of(std::int32_t row, std::int32_t beat, const Permit& permit) noexcept {
        const std::int32_t low = beat % beats | (row + 1) << 6 | (permit.enable ? 1 << 11 : 0) |
                                 (permit.arm ? 1 << 12 : 0) | (permit.hold ? 1 << 13 : 0) |
                                 permit.source << 14;
        return low | check(low) << bits;
    }

    static constexpr bool is_for(std::int32_t word, std::int32_t row) noexcept {
        const std::int32_t low = word & ((1 << bits) - 1);
        return word >= 0 && word >> bits == check(low) && (low >> 6 & rows) == row + 1 && row >= 0;
    }
    static constexpr std::int32_t beat(std::int32_t word) noexcept { return word & (beats - 1); }
    static constexpr Permit permit(std::int32_t word) noexcept {
        return {(word >> 11 & 1) != 0, (word >> 12 & 1) != 0, (word >> 13 & 1) != 0, word >> 14 & 7};
    }

private:
    static constexpr int bits = 17;

    static constexpr std::int32_t check(std::int32_t low) noexcept {
        return static_cast<std::int32_t>((static_cast<std::uint32_t>(low) * 2654435761U) >> 18);
    }
};

// The end of a stage.
class StagePermit : hal::Group {
public:
    static constexpr const char* about =
        "With yes the stage applies an offset only by a permit of interlock, with no by its own pins "
        "heartbeat, arm "
        "and enable.";

    StagePermit(hal::Component* owner, const std::string& interlock)
        : Group(owner), expected_(interlock == "yes") {
        if (!expected_ && interlock != "no")
            throw std::invalid_argument("interlock=" + interlock + ": give yes or no");
    }

    // Once in each period, with the own pins of the stage.
    Permit step(bool enable, bool arm) noexcept {
        const std::int32_t word = permit_, number = row_, beat = heartbeat_;
        if (!expected_) {
            counter_.step(beat);
            return {enable, arm, false, 0};
        }
        if (PermitWord::is_for(word, number)) {
            beat_ = PermitWord::beat(word);
            last_ = PermitWord::permit(word);
        }
        counter_.step(beat_);  // as long as no word is valid, it stands still
        return {enable && last_.enable, last_.arm && alive(), last_.hold, last_.source};
    }

    bool alive() const noexcept { return counter_.alive(); }
    // Dead for so long that it is a fault, and not the first periods.
    bool missed() const noexcept { return counter_.missed(); }

private:
    const bool expected_;
    hal::In<std::int32_t> permit_{this, "permit", PermitWord::none,
                                  "What the stage may do now: interlock.stage-permit-N."};
    hal::In<std::int32_t> row_{this, "row", -1, "Number N of the stage at interlock."};
    hal::In<std::int32_t> heartbeat_{this, "heartbeat", -1,
                                     "With interlock=no: interlock.heartbeat, or -1 without interlock."};
    LiveCounter counter_;
    std::int32_t beat_ = 0;  // of the last valid word
    Permit last_;
};

}  // namespace plumb
