// SPDX-License-Identifier: GPL-2.0-or-later
// What both stages have in common: their end at the bus, and the sum of their sources. Once in each period:
//
//     StagePermit::step     first: what interlock, or a stage's own pins, permit
//     SourceSum::read       the sources, or the one that has a trial
//     StagePermit::report   last: what the stage does, for interlock
//
// A permit that is void holds the offset; a stage that never had one applies nothing.
#pragma once

#include "components/math/blocks/usable.hpp"
#include "hal/bus.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/stage_word.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>

namespace plumb {

using hal::Permit, hal::StageState;

// The sum of the sources of a stage: its pins offset-0 to -3, and that of a trial. An invalid one, or one
// beyond ±largest, keeps its last good value.
class SourceSum {
public:
    static constexpr std::size_t number = Permit::of_trial;
    static constexpr double largest = 1e3;  // mu

    // Reads each once; where the permit names one, the others stay as they are. Whether all are valid.
    template <class Row>
    bool read(Row& offsets, const Permit& permit) noexcept {
        bool good = true;
        for (std::size_t i = 0; i < number; ++i) {
            const double source = i + 1 < number ? static_cast<double>(offsets[i]) : permit.trial;
            if (permit.source != 0 && i + 1 != permit.source) continue;
            sources_[i] = usable(source, largest, sources_[i]);
            good = good && sources_[i] == source;
        }
        return good;
    }

    void clear() noexcept { sources_ = {}; }

    double operator[](std::size_t i) const noexcept { return sources_[i]; }
    // The sum without a source, by its number from 1; 0: with all.
    double without(std::size_t source) const noexcept {
        return value() - (source != 0 ? sources_[source - 1] : 0);
    }
    double value() const noexcept { return std::accumulate(sources_.begin(), sources_.end(), 0.0); }

private:
    std::array<double, number> sources_{};
};
using SourceRow = hal::Row<hal::In<double>, SourceSum::number - 1>;

// Whether a counter that counts once in each period still does. One below 0 is that of nobody, and counts as
// alive. Any other one is dead until it is seen to change: a value that was left behind means nothing.
class LiveCounter {
public:
    // Once in each period.
    void step(std::int32_t count) noexcept {
        if (count < 0 || (last_ >= 0 && count != last_))
            silence_ = 0;
        else
            silence_ = last_ < 0 ? dead : std::min(silence_ + 1, missed_after);
        last_ = count;
    }

    bool alive() const noexcept { return silence_ < dead; }
    // Dead for so long that it is a fault, and not the first periods.
    bool missed() const noexcept { return silence_ >= missed_after; }

private:
    static constexpr int dead = 10, missed_after = 20;  // periods without a change

    std::int32_t last_ = -1;
    int silence_ = dead;
};

class StagePermit : hal::Group {
public:
    static constexpr const char* about =
        "With yes the stage applies an offset only by a permit of interlock, with no by its own pins "
        "enable, arm and heartbeat.";

    // has_arm: a cycle start arms the stage.
    StagePermit(hal::Owner owner, const std::string& interlock, bool has_arm) : Group(owner) {
        if (hal::has_interlock(interlock))
            bus_.emplace(owner);
        else
            own_.emplace(owner, has_arm);
    }

    // Once in each period, first.
    Permit step() noexcept {
        if (own_) {
            counter_.step(own_->heartbeat);
            return {own_->enable, own_->arm && *own_->arm, false, 0, 0};
        }
        heard_.step(bus_->permit);
        Permit permit = Permit::of(heard_.content());
        permit.arm = permit.arm || !heard_.heard();  // a cycle that runs already is no start
        const double given = bus_->trial;
        permit.trial = permit.source == Permit::of_trial ? given : 0;
        return permit;
    }

    bool alive() const noexcept { return own_ ? counter_.alive() : heard_.alive(); }
    // Dead for so long that it is a fault, and not the first periods.
    bool missed() const noexcept { return own_ ? counter_.missed() : heard_.missed(); }

    // Once in each period, last.
    void report(const StageState& state) noexcept {
        if (bus_)
            bus_->state = hal::BusWord::of(hal::Party::stage, hal::Direction::to_interlock, heard_.row(),
                                           beat_++, state.content());
    }

private:
    struct Bus final : Group {
        using Group::Group;
        hal::In<std::uint32_t> permit{this, "permit", 0, "What the stage may do: interlock.stage-permit-N."};
        hal::In<double> trial{this, "trial", 0, "mu",
                              "Offset of a trial of the stage, for plumb commission: interlock.trial."};
        hal::Out<std::uint32_t> state{this, "state", "What the stage does: to interlock.stage-state-N."};
    };
    struct Own final : Group {
        Own(hal::Owner owner, bool has_arm) : Group(owner) {
            if (has_arm)
                arm.emplace(this, "arm", false, "A rising edge is a cycle start, which arms the stage.");
        }
        hal::In<bool> enable{this, "enable", true, "Apply the offset; false: it returns to 0."};
        hal::In<std::int32_t> heartbeat{
            this, "heartbeat", -1,
            "Counter that changes in each period, else the stage holds its offset; -1: none is watched."};
        std::optional<hal::In<bool>> arm;
        hal::Effects applies{this, hal::Effect::applies, enable};
    };

    std::optional<Bus> bus_;
    std::optional<Own> own_;
    LiveCounter counter_;
    hal::BusListener heard_{hal::Party::stage, hal::Direction::from_interlock};
    std::uint32_t beat_ = 0;
};

}  // namespace plumb
