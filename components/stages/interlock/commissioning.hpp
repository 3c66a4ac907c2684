// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"
#include "components/stages/interlock/functions.hpp"
#include "components/stages/interlock/stages.hpp"
#include "components/stages/interlock/wiring_identity.hpp"
#include "components/stages/stage_permit.hpp"
#include "hal/component.hpp"
#include "hal/linuxcnc_unit.hpp"
#include "hal/thread_watch.hpp"
#include "hal/wiring_list.hpp"

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

namespace plumb {

// Functions and stages that did not pass plumb commission, or were wired again since, are held. A trial
// permits one of them while somebody presses.
struct Commissioning : hal::Group {
    Commissioning(hal::Component* owner, std::size_t number_of_functions, std::size_t number_of_stages)
        : Group(owner),
          functions(number_of_functions),
          stages(number_of_stages),
          interlock_(hal::registrar(owner).instance()),
          function_identities_(functions),
          stage_identities_(stages),
          sources_(functions * stages),
          permits_(stages) {}

    const std::size_t functions, stages;  // their numbers

    hal::In<bool> required{
        this, "commissioning", false,
        "Hold each function and stage until it has passed plumb commission; false: none is held."};
    hal::Row<hal::In<std::int32_t>> function_passed{
        this, functions, "function-passed", 0,
        "Identity with which the function passed plumb commission; 0: not yet. plumb-retain keeps it."};
    hal::Row<hal::In<std::int32_t>> stage_passed{
        this, stages, "stage-passed", 0,
        "Identity with which the stage passed plumb commission; 0: not yet. plumb-retain keeps it."};
    hal::In<std::int32_t> trial_function{this, "trial-function", -1,
                                         "Number of the function that a trial permits, or -1."};
    hal::In<std::int32_t> trial_stage{this, "trial-stage", -1,
                                      "Number of the stage that a trial moves, or -1."};
    hal::In<double> trial_offset{this, "trial-offset", 0, "mu", "Offset of the trial, for its stage."};
    hal::In<double> trial_limit{this, "trial-limit", 0, "mu",
                                "Largest offset of a trial, either way; 0: no stage can be tried."};
    hal::In<bool> trial_measures{
        this, "trial-measures", false,
        "The function on trial only measures: all stages hold, and the spindle may turn."};
    hal::In<double> spindle_speed{this, "spindle-speed", 0, "rpm",
                                  "Speed of the spindle: spindle.0.speed-out. A trial ends when it turns."};
    hal::In<bool> trial_beat{
        this, "trial-beat", false,
        "Changes at least twice a second while somebody presses. If it stops, the machine goes off or the "
        "spindle turns, the trial is over: set both trial numbers to -1 before the next one."};

    hal::Row<hal::Out<std::int32_t>> function_identity{
        this, functions, "function-identity",
        "Identity of the function: its signals, stages, unit, and the signs of its settings; 0: not known."};
    hal::Row<hal::Out<std::int32_t>> stage_identity{
        this, stages, "stage-identity",
        "Identity of the stage: its signals, joint, drive and unit; 0: not known."};
    hal::Row<hal::Out<std::uint32_t>> stage_permit{this, stages, "stage-permit",
                                                   "What the stage may do: to its permit."};
    hal::Out<double> trial{this, "trial", "mu",
                           "Offset of the stage on trial: to the pin trial of each stage."};

    struct Now {
        bool machine_on, homed, program_running;
        const Stages::Now& stages;
    };

    // Once in each period, before the functions; dt of the computer's clock.
    void step(const Now& now, const Functions& its_functions, double dt) noexcept {
        const bool beat = trial_beat;
        silence_ = beat != beat_ ? 0 : std::min(silence_ + dt, longest_pause);
        beat_ = beat;
        const bool heard = silence_ < longest_pause, on = required;
        if (on) asked_.store(true, std::memory_order_relaxed);
        const std::int32_t its_stage = trial_stage, its_function = trial_function;
        const bool chosen = its_stage >= 0 || its_function >= 0;
        const double speed = spindle_speed;
        const bool measures = trial_measures, stands = speed == 0;
        begun_ = chosen && (begun_ || heard);
        over_ = chosen && (over_ || (begun_ && (!heard || !now.machine_on || !(stands || measures))));
        const bool pressed = chosen && heard && !over_;
        const double most = std::abs(trial_limit), given = trial_offset;
        const bool moves = on && pressed && stands && now.machine_on && now.homed && !now.program_running &&
                           possible(its_stage, stages) && std::abs(given) <= most;
        const bool acts = on && pressed && possible(its_function, functions);
        pressed_ = on && pressed;
        on_trial_ = acts ? 1 << its_function : 0;
        trial = moves ? given : 0;
        const std::int32_t tried = moves ? 1 << its_stage
                                   : acts && !measures
                                       ? its_functions.stages_of(static_cast<std::size_t>(its_function))
                                       : 0;
        // The stage of an axis takes its offset back while it is armed.
        tried_ = tried != 0 ? tried : tried_;
        resting_ = tried != 0 ? 0 : std::min(resting_ + dt, longest_return);
        if (tried == 0 && ((now.stages.in_force & tried_) == 0 || resting_ >= longest_return)) tried_ = 0;
        held_stages_ = 0;
        for (std::size_t i = 0; i < stages; ++i) {
            const std::int32_t identity = stage_identities_[i].load(std::memory_order_relaxed);
            const std::int32_t passed = stage_passed[i];
            const bool held = on && (identity == 0 || passed != identity),
                       pressed_here = moves && (tried >> i & 1) != 0;
            held_stages_ |= held ? 1 << i : 0;
            stage_identity[i] = identity;
            std::uint32_t only = 0;
            if ((tried >> i & 1) != 0)
                only = moves ? Permit::of_trial : source(i, static_cast<std::size_t>(its_function));
            const bool unheard = (now.stages.unheard >> i & 1) != 0,
                       silent = (now.stages.silent >> i & 1) != 0;
            permits_[i] = {(!held || pressed_here) && !unheard, (tried_ >> i & 1) != 0,
                           (pressed_ && only == 0) || silent, only};
        }

        held_functions_ = 0;
        for (std::size_t i = 0; i < functions; ++i) {
            const std::int32_t identity = function_identities_[i].load(std::memory_order_relaxed);
            const std::int32_t passed = function_passed[i];
            function_identity[i] = identity;
            held_functions_ |= on && (identity == 0 || passed != identity) ? 1 << i : 0;
        }
    }

    // As sums of 1, 2, 4, ...
    std::int32_t held_functions() const noexcept { return held_functions_ & ~on_trial_; }
    std::int32_t held_stages() const noexcept { return held_stages_; }
    std::int32_t tried_functions() const noexcept { return held_functions_ & on_trial_; }

    // At the end of each period: the words to the stages. `armed` is a cycle that runs; one in which somebody
    // presses arms the stages on trial alone.
    void permit(std::uint32_t beat, bool armed) noexcept {
        trial_cycle_ = armed && (trial_cycle_ || pressed_);
        for (std::size_t i = 0; i < stages; ++i) {
            Permit its = permits_[i];
            its.arm |= armed && !trial_cycle_;
            stage_permit[i] = hal::BusWord::of(hal::Party::stage, hal::Direction::from_interlock,
                                               static_cast<std::uint32_t>(i), beat, its.content());
        }
    }

    // In background().
    void work() {
        if (!asked_.exchange(false, std::memory_order_relaxed)) return;
        if (wait_-- > 0) return;
        const auto wiring = hal::list_wiring();
        const auto threads = hal::list_threads();
        if (!wiring || !threads) return;
        wait_ = pause;
        const auto ask = [&](const std::string& instance, const char* symbol, const std::string& about,
                             auto otherwise) {
            for (const hal::ListedFunction& one : threads->functions)
                if (one.name == instance + ".update")
                    return hal::asked_of_module(one.code, symbol, about.c_str(), otherwise);
            return otherwise;
        };
        WiringIdentity::Modules modules;
        modules.turns = [&](const std::string& instance, const std::string& setting) {
            return ask(instance, "plumb_turns", setting, false);
        };
        modules.options = [&](const std::string& instance) -> std::string {
            return ask(instance, "plumb_given", instance, "");
        };
        const WiringIdentity identity(*wiring, interlock_, unit(), modules);
        for (std::size_t i = 0; i < stages; ++i) {
            stage_identities_[i] = identity.of_stage(i);
            for (std::size_t k = 0; k < functions; ++k)
                sources_[i * functions + k] = static_cast<std::uint32_t>(identity.source_of(i, k) + 1);
        }
        for (std::size_t i = 0; i < functions; ++i)
            function_identities_[i] = identity.of_function(i, stages_of(*wiring, i));
    }

private:
    static constexpr double longest_pause = 0.5, longest_return = 5;  // s
    static constexpr int pause = 20;  // calls of background() between two looks

    static bool possible(std::int32_t number, std::size_t rows) noexcept {
        return number >= 0 && static_cast<std::size_t>(number) < rows;
    }

    // Of a stage, from 1, for the trial of a function. 0: there is none.
    std::uint32_t source(std::size_t stage, std::size_t function) const noexcept {
        return sources_[stage * functions + function].load(std::memory_order_relaxed);
    }

    static std::string unit() {
        const char* const file = std::getenv("INI_FILE_NAME");
        const auto its =
            file ? hal::millimetres_of(hal::ini_value(file, "[TRAJ]", "LINEAR_UNITS")) : std::nullopt;
        return its ? std::to_string(*its) : "";
    }

    std::vector<std::size_t> stages_of(const hal::WiringList& list, std::size_t function) const {
        const std::string name = interlock_ + ".function-stages-" + std::to_string(function);
        std::int32_t sum = 0;
        for (const hal::WiredPin& pin : list.pins)
            if (pin.name == name) sum = static_cast<std::int32_t>(pin.value);
        std::vector<std::size_t> numbers;
        for (std::size_t i = 0; i < stages; ++i)
            if ((sum >> i & 1) != 0 && stage_identities_[i] != 0) numbers.push_back(i);
        return numbers;
    }

    const std::string interlock_;
    std::vector<std::atomic<std::int32_t>> function_identities_, stage_identities_;
    std::vector<std::atomic<std::uint32_t>> sources_;
    std::vector<Permit> permits_;
    std::atomic<bool> asked_{false};
    int wait_ = 0;
    bool beat_ = false, pressed_ = false, trial_cycle_ = false, begun_ = false, over_ = false;  // of a trial
    double silence_ = longest_pause, resting_ = longest_return;                                 // s
    std::int32_t held_functions_ = 0, on_trial_ = 0, held_stages_ = 0, tried_ = 0;
};

}  // namespace plumb
