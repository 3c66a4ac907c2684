// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/stages/interlock/functions.hpp"
#include "hal/component.hpp"
#include "hal/linuxcnc_unit.hpp"
#include "hal/message.hpp"
#include "hal/thread_watch.hpp"
#include "hal/wiring_list.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {

// A number for the wiring of a stage or a function: its signals, the joint, the drive and its scale, the
// unit, and the signs of its settings. Another angle, limit or rate does not change it.
class WiringIdentity {
public:
    WiringIdentity(const hal::WiringList& list, const hal::ThreadList& threads, std::string interlock,
                   const std::string& unit)
        : list_(list), threads_(threads), interlock_(std::move(interlock)), unit_("unit " + unit) {
        for (const hal::WiredPin& pin : list.pins) {
            instances_[instance_of(pin.name)].push_back(&pin);
            if (!pin.signal.empty()) signals_[pin.signal].push_back(&pin);
        }
    }

    // 0 where the pin of interlock has no stage or function.
    std::int32_t of_stage(std::size_t number) const {
        const std::string name = writer_of("stage-state-" + std::to_string(number));
        return name.empty() ? 0 : number_of(stage_lines(name));
    }

    // `stages`: the numbers of those that take its offset.
    std::int32_t of_function(std::size_t number, const std::vector<std::size_t>& stages) const {
        const std::string name = reader_of("function-permit-" + std::to_string(number));
        if (name.empty()) return 0;
        Lines lines{unit_, name + " " + options_of(name)};
        for (const hal::WiredPin* pin : pins_of(name)) {
            const std::string setting = setting_of(*pin);
            if (pin->signal.empty()) {
                if (!pin->writes && asked(name, "plumb_turns", setting, false))
                    lines.insert(setting + " " + sign_of(pin->value));
            } else if (!pin->writes) {
                add_writer(lines, setting, pin->signal);
            } else if (pin->is_real) {
                for (const hal::WiredPin* reader : signals_.at(pin->signal))
                    if (is_source(reader->name)) lines.insert(setting + " > " + instance_of(reader->name));
            }
        }
        for (const std::size_t stage : stages) lines.insert("stage " + std::to_string(of_stage(stage)));
        return number_of(lines);
    }

    // The source of stage `number` that is the offset of function `function`; -1 where there is none.
    std::int32_t source_of(std::size_t number, std::size_t function) const {
        const std::string stage = writer_of("stage-state-" + std::to_string(number));
        const std::string its = reader_of("function-permit-" + std::to_string(function));
        if (stage.empty() || its.empty()) return -1;
        for (const hal::WiredPin* pin : pins_of(stage)) {
            if (pin->signal.empty() || !is_source(pin->name)) continue;
            for (const hal::WiredPin* other : signals_.at(pin->signal))
                if (other->writes && instance_of(other->name) == its)
                    return std::stoi(pin->name.substr(pin->name.rfind('-') + 1));
        }
        return -1;
    }

    // An input of a function that has an axis at point R, and the function that strokes this axis.
    struct Unseen {
        std::size_t reader, stroker;  // their numbers
        std::string sentence;
    };

    // A stage lets the strokes of its axis out of the position of the joint: its source has release-at-off.
    // Whoever reads a signal that this stage shares with its joint has the axis at point R.
    std::vector<Unseen> unseen_strokes(std::size_t functions) const {
        std::map<std::string, std::size_t> numbers;
        for (std::size_t i = 0; i < functions; ++i)
            numbers.emplace(reader_of("function-permit-" + std::to_string(i)), i);
        numbers.erase("");
        std::vector<Unseen> found;
        for (const hal::WiredPin& release : list_.pins) {
            if (release.value == 0 || release.name.find(release_at_off) == std::string::npos) continue;
            const std::string stage = instance_of(release.name), setting = setting_of(release);
            if (setting.rfind(release_at_off, 0) != 0) continue;
            const std::string source = stage + ".offset-" + setting.substr(release_at_off.size());
            const hal::WiredPin* const stroke = writer_at(source);
            const auto stroker = numbers.find(stroke ? instance_of(stroke->name) : "");
            if (stroker == numbers.end()) continue;
            for (const hal::WiredPin* pin : pins_of(stage)) {
                if (!pin->is_real || pin->signal.empty()) continue;
                const auto& ends = signals_.at(pin->signal);
                const auto joint = std::find_if(ends.begin(), ends.end(), is_of_joint);
                for (const hal::WiredPin* end : ends) {
                    const auto reader = numbers.find(instance_of(end->name));
                    if (joint == ends.end() || end->writes || reader == numbers.end() || reader == stroker)
                        continue;
                    found.push_back({reader->second, stroker->second,
                                     end->name + " has " + (*joint)->name + ", which lacks the stroke of " +
                                         stroker->first + ": run plumb wire again, or net " + stroker->first +
                                         ".command to a position, .command-velocity to a velocity, and "
                                         ".measured-position to a measured position."});
                }
            }
        }
        return found;
    }

private:
    using Lines = std::set<std::string>;

    static constexpr std::string_view release_at_off = "release-at-off-";

    static bool is_of_joint(const hal::WiredPin* pin) { return pin->name.rfind("joint.", 0) == 0; }

    const std::vector<const hal::WiredPin*>& pins_of(const std::string& instance) const {
        const auto its = instances_.find(instance);
        return its == instances_.end() ? none_ : its->second;
    }

    // The pin of this name, if it has a signal; else null.
    const hal::WiredPin* wired(const std::string& name) const {
        for (const hal::WiredPin* pin : pins_of(instance_of(name)))
            if (pin->name == name) return pin->signal.empty() ? nullptr : pin;
        return nullptr;
    }

    // The output at the signal of a pin; null without one.
    const hal::WiredPin* writer_at(const std::string& pin) const {
        const hal::WiredPin* const own = wired(pin);
        if (!own) return nullptr;
        const auto& ends = signals_.at(own->signal);
        const auto its = std::find_if(ends.begin(), ends.end(), [](auto* end) { return end->writes; });
        return its == ends.end() ? nullptr : *its;
    }

    static std::string instance_of(const std::string& pin) { return pin.substr(0, pin.rfind('.')); }

    // The declaration of the module of an instance.
    template <class Answer>
    Answer asked(const std::string& instance, const char* symbol, const std::string& about,
                 Answer otherwise) const {
        for (const hal::ListedFunction& one : threads_.functions)
            if (one.name == instance + ".update")
                return hal::asked_of_module(one.code, symbol, about.c_str(), otherwise);
        return otherwise;
    }
    // In its load line.
    std::string options_of(const std::string& instance) const {
        return asked<const char*>(instance, "plumb_given", instance, "");
    }

    // The name of the pin in its instance.
    static std::string setting_of(const hal::WiredPin& pin) {
        return pin.name.substr(pin.name.rfind('.') + 1);
    }

    static bool is_source(const std::string& pin) { return pin.find(".offset-") != std::string::npos; }

    static bool ends_with(const std::string& text, const std::string& end) {
        return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
    }

    static const char* sign_of(double value) { return value > 0 ? "+" : value < 0 ? "-" : "0"; }

    // The instance at the other end of the signal at a pin of interlock.
    std::string writer_of(const std::string& pin) const { return other_end(pin, true); }
    std::string reader_of(const std::string& pin) const { return other_end(pin, false); }
    std::string other_end(const std::string& pin, bool writes) const {
        const std::string whole = interlock_ + "." + pin;
        const hal::WiredPin* const own = wired(whole);
        if (!own) return "";
        for (const hal::WiredPin* other : signals_.at(own->signal)) {
            const bool is_end = writes ? other->writes : ends_with(other->name, ".permit");
            if (is_end && other->name != whole) return instance_of(other->name);
        }
        return "";
    }

    // What interlock itself writes depends on numbers that may change.
    void add_writer(Lines& lines, const std::string& setting, const std::string& signal) const {
        for (const hal::WiredPin* writer : signals_.at(signal))
            if (writer->writes) {
                if (instance_of(writer->name) != interlock_) lines.insert(setting + " < " + writer->name);
                return;
            }
        lines.insert(setting + " < signal " + signal);
    }

    Lines stage_lines(const std::string& name) const {
        Lines lines{unit_, name + " " + options_of(name)};
        for (const hal::WiredPin* pin : pins_of(name)) {
            if (pin->signal.empty() || is_source(pin->name)) continue;
            const std::string setting = setting_of(*pin);
            if (!pin->writes) add_writer(lines, setting, pin->signal);
            for (const hal::WiredPin* other : signals_.at(pin->signal)) {
                const bool of_motion =
                    other->name.rfind("joint.", 0) == 0 || other->name.rfind("axis.", 0) == 0;
                if (pin->writes && other != pin && (pin->is_real || of_motion))
                    lines.insert(setting + " > " + other->name);
                if (pin->is_real && other != pin) add_scales(lines, instance_of(other->name));
            }
        }
        return lines;
    }

    // The scale of a drive has its unit and its sign.
    void add_scales(Lines& lines, const std::string& drive) const {
        const auto add = [&](const std::string& name, double value) {
            if (name.find("scale", drive.size()) == std::string::npos || instance_of(name) != drive) return;
            char text[40];
            std::snprintf(text, sizeof text, " = %.9g", value);
            lines.insert(name + text);
        };
        for (const hal::WiredPin* pin : pins_of(drive))
            if (!pin->writes && pin->signal.empty()) add(pin->name, pin->value);
        for (const hal::WiredParameter& parameter : list_.parameters) add(parameter.name, parameter.value);
    }

    // FNV-1a of the lines; never 0.
    static std::int32_t number_of(const Lines& lines) {
        std::uint32_t sum = 2166136261U;
        for (const std::string& line : lines)
            for (const char c : line + '\n') sum = (sum ^ static_cast<unsigned char>(c)) * 16777619U;
        return static_cast<std::int32_t>(sum ? sum : 1);
    }

    const hal::WiringList& list_;
    const hal::ThreadList& threads_;
    const std::string interlock_, unit_;
    std::map<std::string, std::vector<const hal::WiredPin*>> signals_, instances_;
    const std::vector<const hal::WiredPin*> none_{};
};

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
          words_(stages) {}

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
    hal::Row<hal::Out<std::uint32_t>> stage_permit{
        this, stages, "stage-permit", "Permit of the stage: net it to the pin permit of the stage."};
    hal::Out<double> trial{this, "trial", "mu",
                           "Offset of the stage on trial: to the pin trial of each stage."};

    // Once in each period, before the functions; dt of the computer's clock. Whether anything is new.
    bool step(const Machine& machine, const Stages& its_stages, const Functions& its_functions,
              double dt) noexcept {
        const std::int32_t stage = trial_stage, function = trial_function;
        const bool chosen = stage >= 0 || function >= 0, beat = trial_beat, on = required;
        // A beat of the press before begins no trial.
        silence_ = !chosen ? longest_pause : beat != beat_ ? 0 : std::min(silence_ + dt, longest_pause);
        beat_ = beat;
        const bool heard = silence_ < longest_pause;
        since_ += dt;
        on_.store(on, std::memory_order_relaxed);
        if (on || since_ >= interval) {
            since_ = 0;
            asked_.store(true, std::memory_order_relaxed);
        }
        const bool measures = chosen && trial_measures, stands = chosen && spindle_speed == 0;
        begun_ = chosen && (begun_ || heard);
        over_ = chosen && (over_ || (begun_ && (!heard || !machine.on || !(stands || measures))));
        pressed_ = on && chosen && heard && !over_;
        const double most = pressed_ ? std::abs(trial_limit) : 0.0, given = pressed_ ? trial_offset : 0.0;
        moves_ = pressed_ && stands && machine.on && machine.homed && !machine.program && !machine.cycle &&
                 possible(stage, stages) && std::abs(given) <= most;
        const bool acts = pressed_ && possible(function, functions);
        const Sum on_trial = acts ? Sum{1} << function : 0;
        trial = moves_ ? given : 0;
        tried_ = moves_              ? Sum{1} << stage
                 : acts && !measures ? its_functions.stages_of(static_cast<std::size_t>(function))
                                     : 0;
        tried_function_ = acts ? static_cast<std::size_t>(function) : 0;
        // The stage of an axis takes its offset back while it is armed.
        rests_ = tried_ != 0 ? tried_ : rests_;
        resting_ = tried_ != 0 ? 0 : std::min(resting_ + dt, longest_return);
        if (tried_ == 0 && ((its_stages.in_force & rests_) == 0 || resting_ >= longest_return)) rests_ = 0;
        const Sum held_stages = held(on, stages, stage_identities_, stage_passed, stage_identity),
                  held_functions =
                      held(on, functions, function_identities_, function_passed, function_identity);
        return replaces(held_, {held_functions & ~on_trial, held_stages, held_functions & on_trial});
    }

    const Held& now() const noexcept { return held_; }

    // At the end of each period: the words to the stages. `armed` is a cycle that runs; one in which somebody
    // presses arms the stages on trial alone.
    void permit(const Stages& its_stages, std::uint32_t beat, bool armed) noexcept {
        trial_cycle_ = armed && (trial_cycle_ || pressed_);
        const Sum enabled = (~held_.stages | (moves_ ? tried_ : 0)) & ~its_stages.state.unheard(),
                  armed_now = rests_ | (armed && !trial_cycle_ ? ~Sum{0} : 0),
                  holding = its_stages.state.silent() | (pressed_ ? ~tried_ : 0);
        const std::array<Sum, 4> now{enabled, armed_now, holding, tried_};
        const bool changes = tried_ != 0 || now != permitted_;  // a source on trial may be another one
        permitted_ = now;
        for (std::size_t i = 0; i < stages; ++i) {
            if (changes || words_[i] == 0) words_[i] = word(i);
            stage_permit[i] = hal::BusWord::beating(words_[i], beat);
        }
    }

    // In background().
    void work(Functions& its_functions) {
        if (!asked_.exchange(false, std::memory_order_relaxed)) return;
        const bool on = on_.load(std::memory_order_relaxed);
        if (on && wait_-- > 0) return;
        const auto wiring = hal::list_wiring();
        const auto threads = hal::list_threads();
        if (!wiring || !threads) return;
        wait_ = pause;
        const WiringIdentity identity(*wiring, *threads, interlock_, unit());
        look_for_strokes(identity, its_functions);
        for (std::size_t i = 0; on && i < stages; ++i) {
            stage_identities_[i] = identity.of_stage(i);
            for (std::size_t k = 0; k < functions; ++k)
                sources_[i * functions + k] = static_cast<std::uint32_t>(identity.source_of(i, k) + 1);
        }
        for (std::size_t i = 0; on && i < functions; ++i)
            function_identities_[i] = identity.of_function(i, stages_of(*wiring, i));
    }

private:
    static constexpr double longest_pause = 0.5, longest_return = 5, interval = 1;  // s
    static constexpr int pause = 20;  // calls of background() between two looks

    void look_for_strokes(const WiringIdentity& wiring, Functions& its_functions) {
        std::vector<Sum> unseen(functions);
        std::set<std::string> sentences;
        for (const WiringIdentity::Unseen& its : wiring.unseen_strokes(functions)) {
            unseen[its.reader] |= Sum{1} << its.stroker;
            sentences.insert(its.sentence);
            if (reported_.count(its.sentence) == 0) hal::report_error(its.sentence.c_str());
        }
        reported_ = std::move(sentences);
        for (std::size_t i = 0; i < functions; ++i) its_functions.see(i, unseen[i]);
    }

    static bool possible(std::int32_t number, std::size_t rows) noexcept {
        return number >= 0 && static_cast<std::size_t>(number) < rows;
    }

    // The rows that have not passed as they are wired now.
    template <class Identities, class Passed, class Shown>
    static Sum held(bool on, std::size_t rows, const Identities& identities, Passed& passed,
                    Shown& shown) noexcept {
        Sum held = 0;
        for (std::size_t i = 0; on && i < rows; ++i) {
            const std::int32_t identity = identities[i].load(std::memory_order_relaxed);
            held |= Sum{identity == 0 || passed[i] != identity} << i;
            shown[i] = identity;
        }
        return held;
    }

    // To a stage, of beat 0.
    std::uint32_t word(std::size_t stage) const noexcept {
        const auto& [enabled, armed, holding, tried] = permitted_;
        std::uint32_t only = 0;  // source of the stage, from 1
        if (has(tried, stage))
            only = moves_ ? hal::Permit::of_trial
                          : sources_[stage * functions + tried_function_].load(std::memory_order_relaxed);
        const bool holds = has(holding, stage) || (pressed_ && only == 0);
        return hal::BusWord::of(hal::Party::stage, hal::Direction::from_interlock,
                                static_cast<std::uint32_t>(stage), 0,
                                hal::Permit{has(enabled, stage), has(armed, stage), holds, only}.content());
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
    std::vector<std::uint32_t> words_;
    std::atomic<bool> asked_{false}, on_{false};
    int wait_ = 0;
    std::set<std::string> reported_;  // of the background
    double since_ = interval;         // s, since it was asked
    bool beat_ = false, pressed_ = false, trial_cycle_ = false, begun_ = false, over_ = false;  // of a trial
    bool moves_ = false;                                         // the stage on trial
    double silence_ = longest_pause, resting_ = longest_return;  // s
    Held held_{};
    Sum tried_ = 0, rests_ = 0;  // rests: those that take the offset of a trial back
    std::size_t tried_function_ = 0;
    std::array<Sum, 4> permitted_{};  // stages: may apply their offset, are armed, hold, are tried
};

}  // namespace plumb
