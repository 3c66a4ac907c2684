// SPDX-License-Identifier: GPL-2.0-or-later
// The end of a stage at the bus: what interlock permits, and what it hears of the stage. A permit that is
// void holds the offset; a stage that never had one applies nothing.
#pragma once

#include "components/math/blocks/live_counter.hpp"
#include "hal/bus.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace plumb {

struct Permit {
    bool enable = false;       // the stage may apply its offset
    bool arm = false;          // a cycle runs, or a trial of this stage
    bool hold = false;         // another stage is on trial: nothing moves here
    std::uint32_t source = 0;  // that alone acts in a trial, counted from 1; 0: all but that of a trial

    static constexpr std::uint32_t of_trial = 5;  // the pin trial

    constexpr std::uint32_t content() const noexcept {
        return (enable ? 1U : 0) | (arm ? 2U : 0) | (hold ? 4U : 0) | source << 3;
    }
    static constexpr Permit of(std::uint32_t content) noexcept {
        return {(content & 1) != 0, (content & 2) != 0, (content & 4) != 0, content >> 3 & 7};
    }
};

// The sources of a stage, by number from 0: its pins offset-0 to -3, and last that of a trial.
template <class Offsets>
struct StageSources {
    static constexpr std::size_t number = Permit::of_trial;

    Offsets& offsets;
    double trial;

    double operator[](std::size_t i) const noexcept {
        return i + 1 < number ? static_cast<double>(offsets[i]) : trial;
    }
};
using SourceRow = hal::Row<hal::In<double>, 4>;

struct StageState {
    bool in_force = false;         // an offset
    bool ramping = false;          // ... which still changes
    bool uncompensated = false;    // the axis lacks its offset
    bool probing_refused = false;  // a probing move began with an offset in force
    bool fault = false;
    bool limited = false;  // a limit prevents the full offset

    static constexpr int bits = 6;

    constexpr std::uint32_t content() const noexcept {
        return (in_force ? 1U : 0) | (ramping ? 2U : 0) | (uncompensated ? 4U : 0) |
               (probing_refused ? 8U : 0) | (fault ? 16U : 0) | (limited ? 32U : 0);
    }
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
            return {own_->enable, own_->arm && *own_->arm, false, 0};
        }
        heard_.step(bus_->permit);
        Permit permit = Permit::of(heard_.content());
        permit.arm = permit.arm || !heard_.heard();  // a cycle that runs already is no start
        const double given = bus_->trial;
        trial_ = permit.source == Permit::of_trial ? given : 0;
        return permit;
    }

    // Offset of the pin trial; 0 where it has no trial.
    double trial() const noexcept { return trial_; }

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
    double trial_ = 0;
    std::uint32_t beat_ = 0;
};

}  // namespace plumb
