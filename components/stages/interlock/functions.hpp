// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/stages/interlock/function_status.hpp"
#include "components/stages/interlock/services.hpp"
#include "components/stages/interlock/stages.hpp"
#include "hal/component.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumb {

// The functions that compensate.
struct Functions : hal::Group {
    static constexpr std::size_t most = 16;
    static constexpr std::int32_t first_four = 15;  // services: the default of when there were no more

    // `stages`, `services`: their numbers.
    Functions(hal::Owner owner, std::size_t number, std::size_t stages, std::size_t services)
        : Group(owner),
          all_stages_((1 << stages) - 1),
          first_services_(first_four & Services::of(services)),
          number_(number),
          its_(number) {
        for (std::size_t i = 0; i < number; ++i)
            heard_.emplace_back(hal::Party::function, hal::Direction::to_interlock,
                                static_cast<std::uint32_t>(i), 100);  // its thread may be a slower one
    }

    const std::int32_t all_stages_, first_services_;  // as sums
    const std::size_t number_;

    hal::Row<hal::In<bool>> is_on{this, number_, "function-switch", false,
                                  "The operator has switched the function on."};
    hal::Row<hal::In<bool>> is_off{this, number_, "function-off", false,
                                   "Off, whatever function-switch says: for a screen, where a signal drives "
                                   "function-switch."};
    hal::Row<hal::In<bool>> suspend{this, number_, "function-suspend", false,
                                    "The part program suspends the function."};
    hal::Row<hal::In<std::int32_t>> needs{
        this, number_, "function-services", first_services_,
        "Services that the function needs: the sum of 1 for service 0, 2 for service 1, 4 for service 2, ... "
        "128 for service 7."};
    hal::Row<hal::In<std::int32_t>> urgent{
        this, number_, "function-urgent", 0,
        "Services whose loss turns the function off at once, as a sum; the "
        "function must need them."};
    hal::Row<hal::In<std::int32_t>> its_stages{
        this, number_, "function-stages", all_stages_,
        "Stages that apply the offset of the function to an axis, as a sum like function-services."};
    hal::Row<hal::In<std::uint32_t>> state{this, number_, "function-state", 0U,
                                           "What the function does: from its state."};

    hal::Row<hal::Out<std::uint32_t>> permit{this, number_, "function-permit",
                                             "What the function may do: to its permit."};
    hal::Row<hal::Out<bool>> enable{this, number_, "function-enable", "The permit enables the function."};
    hal::Row<hal::Out<bool>> lost{
        this, number_, "function-lost",
        "A service was lost. The function is off, or goes off when it is no longer busy. When the service is "
        "ok again, turn the switch off and on, or start a cycle."};
    hal::Row<hal::Code<hal::Common>> status{
        this, number_, "function-status",
        "Reason why the function does not act, which its permit gives it; 0: "
        "none."};

    // Of one period.
    struct Now {
        bool starts;   // a cycle does
        bool probing;  // enables stay as they are
        bool cuts;     // a program does: the tool is not clear
        bool running;  // a program
        std::int32_t silent_stages;
        // By commissioning, as sums of 1, 2, 4, ...
        std::int32_t held_functions = 0, held_stages = 0;
        std::int32_t tried = 0;  // functions that it holds but for a trial
    };

    // Once in each period.  False where one needs services that there are not; it needs all of them then.
    bool step(const Services& services, const Now& now) noexcept {
        bool good = true;
        any_permitted_ = any_on_ = any_withdrawn_ = any_busy_ = changed_ = false;
        any_withheld_ = any_suspended_ = any_left_ = any_settling_ = any_ramping_ = false;
        all_enabled_ = true;
        urgent_services_ = 0;
        held_stages_ = now.held_stages;
        for (std::size_t i = 0; i < number_; ++i) {
            heard_[i].step(state[i]);
            const hal::FunctionState said = hal::FunctionState::of(heard_[i].content());
            const std::int32_t given = needs[i], at_once = urgent[i];
            const bool known = services.exist(given) && services.exist(at_once);
            good &= known;
            State& its = its_[i];
            const bool on_by_pin = is_on[i], off_by_pin = is_off[i], switched_on = on_by_pin && !off_by_pin;
            const bool is_busy = said.busy || (said.works_in_programs && now.running);
            its.leaves = !switched_on && its.on && its.enabled && now.cuts && at_once == 0 && !its.on_trial;
            const bool on = switched_on || its.leaves;
            any_left_ |= its.on && !on && its.enabled;
            const bool served = services.are_ok(known ? given : services.all());
            const bool is_urgent = !known || services.any_lost(at_once);
            const std::int32_t named = its_stages[i];
            its.stages = named >= 0 ? named : all_stages_;
            its.silent = !heard_[i].alive();
            its.silent_stages = now.silent_stages & its.stages;
            const bool is_held = (now.held_functions >> i & 1) != 0 || (now.held_stages & its.stages) != 0;
            any_settling_ |= said.settling;
            any_ramping_ |= said.ramping;
            const bool stays = its.granted && is_busy && !is_urgent && !its.on_trial;
            any_busy_ |= its.granted && is_busy;
            urgent_services_ |= known ? at_once : services.all();
            const bool renews = now.starts || (on && !its.on) || its.granted;
            if (served)
                its.lost = its.lost && !renews;
            else
                its.lost |= its.served;
            its.withdrawn = its.lost && (its.withdrawn || (its.granted && is_urgent));
            const bool hears = !its.silent && its.silent_stages == 0;
            const bool permitted = on && served && !its.lost && !is_held && hears, before = its.enabled;
            its.granted = permitted || (on && stays);
            its.is_held = is_held && !its.granted;
            its.on_trial = (now.tried >> i & 1) != 0;
            its.on = on;
            its.served = served;
            its.suspended = suspend[i];
            its.needs = known ? given : services.all();
            if (!now.probing) its.enabled = its.granted && !its.suspended;

            any_permitted_ |= permitted;
            any_withdrawn_ |= its.withdrawn;
            any_on_ |= on;
            any_withheld_ |= on && !its.granted;
            any_suspended_ |= its.granted && its.suspended;
            all_enabled_ &= its.enabled == on;
            changed_ |= its.enabled != before;
            enable[i] = its.enabled;
            lost[i] = its.lost;
        }
        return good;
    }

    // Of the machine.
    struct Machine {
        bool on, homed, in_order;
    };

    // After step().
    void show_status(const Services& services, const Stages::Now& stages, const Machine& machine,
                     std::uint32_t beat) noexcept {
        for (std::size_t i = 0; i < number_; ++i) {
            const State& its = its_[i];
            FunctionSeen seen;
            seen.on = its.on;
            seen.leaves = its.leaves;
            seen.suspended = its.suspended;
            seen.uncommissioned = its.is_held;
            seen.stages_uncommissioned = held_stages_ & its.stages;
            seen.enabled = its.enabled;
            seen.lost = its.lost;
            seen.lost_services = services.lost_of(its.needs);
            seen.late_services = services.late_of(its.needs);
            seen.machine_on = machine.on;
            seen.homed = machine.homed;
            seen.in_order = machine.in_order;
            seen.silent = its.silent;
            seen.silent_stages = its.silent_stages;
            seen.stages_with_fault = stages.fault & its.stages;
            seen.stages_that_lack = stages.uncompensated & ~stages.ramping & its.stages;
            seen.stages_limited = stages.limited & its.stages;
            const hal::Common reason = status_of(seen);
            status[i] = reason;
            permit[i] = hal::BusWord::of(hal::Party::function, hal::Direction::from_interlock,
                                         static_cast<std::uint32_t>(i), beat,
                                         hal::FunctionPermit{its.enabled, reason}.content());
        }
    }

    std::size_t number() const noexcept { return number_; }
    std::int32_t stages_of(std::size_t function) const noexcept { return its_[function].stages; }
    // That is not heard, and is switched on; -1: none.
    std::int32_t first_silent() const noexcept {
        for (std::size_t i = 0; i < number_; ++i)
            if (its_[i].silent && its_[i].on) return static_cast<std::int32_t>(i);
        return -1;
    }
    bool any_settling() const noexcept { return any_settling_; }
    bool any_ramping() const noexcept { return any_ramping_; }
    bool any_permitted() const noexcept { return any_permitted_; }
    bool any_on() const noexcept { return any_on_; }                // by the operator
    bool any_withheld() const noexcept { return any_withheld_; }    // on, and a service is missing
    bool any_suspended() const noexcept { return any_suspended_; }  // by the program
    bool any_busy() const noexcept { return any_busy_; }            // that was enabled
    bool any_withdrawn() const noexcept { return any_withdrawn_; }  // by a loss, and not renewed
    std::int32_t urgent_services() const noexcept { return urgent_services_; }  // whose loss holds the feed
    bool all_enabled() const noexcept { return any_on_ && all_enabled_; }       // that are switched on
    bool any_left() const noexcept { return any_left_; }  // by the operator, in this period
    bool changed() const noexcept { return changed_; }    // an enable, in this period

private:
    struct State {
        bool on = false, served = false, lost = false, granted = false, withdrawn = false, enabled = false;
        bool suspended = false, is_held = false, on_trial = false;
        bool leaves = false;  // goes off when the tool is clear
        bool silent = false;
        std::int32_t needs = 0, stages = 0, silent_stages = 0;  // services, its own stages, and of these
    };

    std::vector<State> its_;
    std::vector<hal::BusListener> heard_;
    std::int32_t urgent_services_ = 0, held_stages_ = 0;
    bool any_permitted_ = false, any_on_ = false, any_withdrawn_ = false, any_busy_ = false,
         all_enabled_ = false, changed_ = false, any_withheld_ = false, any_suspended_ = false,
         any_left_ = false, any_settling_ = false, any_ramping_ = false;
};

}  // namespace plumb
