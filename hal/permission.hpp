// SPDX-License-Identifier: GPL-2.0-or-later
// The end of a function at the bus: what interlock permits, and what it hears of the function.
//
//     hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about};
//     hal::Permission permission{this, interlock, "Apply the correction; false: it returns to 0."};
//
// declares permit and state, or, with interlock=no, enable. A function without a sentence for enable acts
// always.
#pragma once

#include "hal/bus.hpp"
#include "hal/effect.hpp"
#include "hal/group.hpp"
#include "hal/pin.hpp"
#include "hal/status.hpp"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace plumb::hal {

// Whether the option says yes.
inline bool has_interlock(const std::string& option) {
    if (option != "yes" && option != "no")
        throw std::invalid_argument("interlock=" + option + ": give yes or no");
    return option == "yes";
}

// The contents of the words.
struct FunctionPermit {
    bool enable = false;
    Common reason = Common::none;  // why it does not act

    constexpr std::uint32_t content() const noexcept {
        return (enable ? 1U : 0) | static_cast<std::uint32_t>(reason) << 1;
    }
    static constexpr FunctionPermit of(std::uint32_t content) noexcept {
        return {(content & 1) != 0, static_cast<Common>(content >> 1)};
    }
};

struct FunctionState {
    bool busy = false;           // at work, in a program or not
    bool works_in_programs = true;  // busy while one runs
    bool settling = false;       // the next cut must wait for it
    bool ramping = false;        // to its target

    constexpr std::uint32_t content() const noexcept {
        return (busy ? 1U : 0) | (settling ? 2U : 0) | (ramping ? 4U : 0) | (works_in_programs ? 8U : 0);
    }
    static constexpr FunctionState of(std::uint32_t content) noexcept {
        return {(content & 1) != 0, (content & 8) != 0, (content & 2) != 0, (content & 4) != 0};
    }
};

class Permission : Group {
public:
    static constexpr const char* about =
        "With yes the function acts only by a permit of interlock, with no by its own pin enable, if it has "
        "one.";

    Permission(Owner owner, const std::string& interlock, const char* about_enable = nullptr,
               bool enabled_at_first = false)
        : Group(owner) {
        if (has_interlock(interlock)) {
            bus_.emplace(owner);
        } else if (about_enable) {
            enable_.emplace(owner, "enable", enabled_at_first, about_enable);
            effect_.emplace(owner, Effect::applies, *enable_);
        }
    }

    // Once in each period, first.
    void step() noexcept {
        if (!bus_) {
            now_ = {!enable_ || *enable_, Common::none};
            return;
        }
        heard_.step(bus_->permit);
        now_ = FunctionPermit::of(heard_.content());
        if (!heard_.alive()) now_ = {false, Common::unpermitted};
        bus_->enabled = now_.enable;
    }

    bool enabled() const noexcept { return now_.enable; }
    Common reason() const noexcept { return now_.reason; }

    // Once in each period, last.
    void report(const FunctionState& state) noexcept {
        if (bus_)
            bus_->state = BusWord::of(Party::function, Direction::to_interlock, heard_.row(), beat_++,
                                      state.content());
    }

private:
    struct Bus final : Group {
        using Group::Group;
        In<std::uint32_t> permit{this, "permit", 0,
                                 "What the function may do: interlock.function-permit-N."};
        Out<std::uint32_t> state{this, "state", "What the function does: to interlock.function-state-N."};
        Out<bool> enabled{this, "enabled", "The permit enables the function."};
    };

    std::optional<Bus> bus_;
    std::optional<In<bool>> enable_;
    std::optional<Effects> effect_;
    BusListener heard_{Party::function, Direction::from_interlock};
    FunctionPermit now_;
    std::uint32_t beat_ = 0;
};

}  // namespace plumb::hal
