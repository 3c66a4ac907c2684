// SPDX-License-Identifier: GPL-2.0-or-later
// The status of a function: what it does now, as one code. Screens, messages and reports show its sentence
// and its remedy, and compute nothing. The function declares its own statuses, from first_own on; the others
// are common to all, and interlock finds most of them.
//
//     enum class LampStatus : std::int32_t { lit = hal::first_own, burnt_out };
//     constexpr hal::Said said(LampStatus status) {
//         switch (status) {
//             case LampStatus::lit: return {hal::Kind::good, "The lamp is lit."};
//             case LampStatus::burnt_out:
//                 return {hal::Kind::bad, "The lamp is burnt out.", "Replace the lamp."};
//             default: return said(static_cast<hal::Common>(status));
//         }
//     }
//     hal::Status<LampStatus> status{this};
//
// declares the pins (status_pins.hpp). A program without HAL includes this file alone.
#pragma once

#include "hal/service.hpp"

#include <cstdint>

namespace plumb::hal {

enum class Kind {
    good,  // it acts
    wait,  // it acts as soon as something comes that will come
    off,   // by the operator, or there is nothing to do
    warn,  // somebody has to act
    bad,   // a fault or a loss
};

constexpr const char* name(Kind kind) {
    switch (kind) {
        case Kind::good: return "good";
        case Kind::wait: return "wait";
        case Kind::off: return "off";
        case Kind::warn: return "warn";
        default: return "bad";
    }
}

// The button of a screen that ends a status. Pages of plumb panel register their buttons by these names.
enum class Button {
    none,
    switch_on,
    acknowledge,
    learn,
    dry_run,
    to_end,
    hold,
    stop,
    start,
    resume,
    report,
    cut_done,
    enter,
    store,
};

constexpr const char* name(Button button) {
    switch (button) {
        case Button::switch_on: return "switch";
        case Button::acknowledge: return "acknowledge";
        case Button::learn: return "learn";
        case Button::dry_run: return "dry-run";
        case Button::to_end: return "to-end";
        case Button::hold: return "hold";
        case Button::stop: return "stop";
        case Button::start: return "start";
        case Button::resume: return "resume";
        case Button::report: return "report";
        case Button::cut_done: return "cut-done";
        case Button::enter: return "enter";
        case Button::store: return "store";
        default: return "";
    }
}

// How linuxcnc_link shows it to the operator as a message of LinuxCNC.
enum class Tell {
    by_kind,       // a bad one as an error, any other never
    never,         // screens show it, or another component tells its cause
    behind_panel,  // as a text, unless plumb panel is on the screen
    text,
    error,
};

constexpr const char* name(Tell tell) {
    switch (tell) {
        case Tell::behind_panel: return "behind-panel";
        case Tell::text: return "text";
        case Tell::error: return "error";
        default: return "never";
    }
}

// A status as people read it.
struct Said {
    Kind kind = Kind::bad;
    const char* sentence = nullptr;  // null: there is no such status
    const char* remedy = "";         // a sentence: what ends it
    Button button = Button::none;
    const char* detail = "";  // pin that says more: a code, for its sentence, or a quantity
    const char* size = "";    // pin with the size of that: a length
    Tell tell = Tell::by_kind;
    double after = 0;  // s for which it must last before it is told

    constexpr Said told(Tell how, double seconds = 0) const {
        Said result = *this;
        result.tell = how;
        result.after = seconds;
        return result;
    }
    constexpr Said sized(const char* pin) const {
        Said result = *this;
        result.size = pin;
        return result;
    }
};

constexpr Tell tell(const Said& its) {
    if (its.tell != Tell::by_kind) return its.tell;
    return its.kind == Kind::bad ? Tell::error : Tell::never;
}

inline constexpr std::int32_t first_own = 40;

// The statuses that functions have in common; late, lost and ending by the number of the service.
enum class Common : std::int32_t {
    none,
    fault,
    off,
    suspended,
    probing,
    machine_off,
    not_homed,
    renew,
    order,
    stage_fault,
    stage_lacks,
    stage_limited,
    uncommissioned,
    stage_uncommissioned,
    leaves,
    unpermitted,
    late = 16,
    lost = late + services,
    ending = lost + services,
    at_point_r = 99,  // the last number
};

constexpr Common of_service(Common kind, std::int32_t number) {
    return static_cast<Common>(static_cast<std::int32_t>(kind) + number);
}

constexpr bool is_of_service(std::int32_t number) {
    return number >= static_cast<std::int32_t>(Common::late) && number < first_own;
}

inline constexpr ServiceSentences late_services{"Off: ", " is not ready."},
    lost_services{"Off: ", " does not answer."},
    ending_services{"Goes off when the program ends: ", " does not answer."};

constexpr Said said_of_service(Common status) {
    if (!is_of_service(static_cast<std::int32_t>(status))) return {};
    const std::int32_t number = static_cast<std::int32_t>(status) - static_cast<std::int32_t>(Common::late);
    const std::int32_t its = number % services;
    switch (number / services) {
        case 0:
            return Said{Kind::warn, late_services[its],
                        "Wait until it is ready. If it stays so, start LinuxCNC again."}
                .told(Tell::text, 30);
        // interlock tells a loss, once for all functions.
        case 1: return Said{Kind::bad, lost_services[its], "Start LinuxCNC again."}.told(Tell::never);
        default: return {Kind::warn, ending_services[its], "Start LinuxCNC again after the program."};
    }
}

constexpr Said said(Common status) {
    switch (status) {
        case Common::fault: return {Kind::bad, "A fault is active.", "Remove its cause.", {}, "fault-code"};
        case Common::off: return {Kind::off, "Switched off.", "Switch it on.", Button::switch_on};
        case Common::suspended:
            return {Kind::wait, "Suspended by the part program.", "The program ends this."};
        case Common::probing:
            return {Kind::wait, "Waits for the end of a probing move.", "It acts after the move."};
        case Common::machine_off: return {Kind::wait, "The machine is off.", "Turn the machine on."};
        case Common::not_homed: return {Kind::wait, "The machine is not homed.", "Home all axes."};
        case Common::renew:
            return {Kind::bad, "Off: a service was lost, and answers again.", "Turn the switch off and on.",
                    Button::switch_on};
        case Common::order:
            return Said{Kind::bad, "Held: functions of Plumb are in a wrong order in their thread.",
                        "Run plumb doctor --running."}
                .told(Tell::never);  // a fault of interlock
        case Common::stage_fault:
            return Said{Kind::bad, "The stage of an axis has a fault, and does not follow.",
                        "Look at the faults of the stages."}
                .told(Tell::never);  // a fault of the stage
        case Common::stage_lacks:
            return {Kind::wait, "An axis lacks its offset.", "It gets it when the next cycle begins."};
        case Common::stage_limited:
            return {Kind::warn, "A limit of a stage prevents the full offset of its axis.",
                    "Move the axis away from its soft limit, or raise the largest offset of the stage."};
        case Common::uncommissioned:
            return {Kind::warn, "Held: it waits for commissioning, or its wiring has changed since.",
                    "Run plumb commission for this function, or open the page Commissioning."};
        case Common::stage_uncommissioned:
            return {Kind::warn,
                    "Held: a stage of it waits for commissioning, or its wiring has changed since.",
                    "Run plumb commission for this function: it begins with its stages."};
        case Common::leaves:
            return {Kind::wait, "Switched off: the offset holds until the tool is clear, and then returns.",
                    "The next rapid move, tool change or end of the program ends it."};
        case Common::unpermitted:
            return {Kind::bad, "Held: the function and interlock do not hear each other.",
                    "Net function-permit of interlock to permit, and state to function-state of interlock."};
        case Common::at_point_r:
            return Said{Kind::warn,
                        "An axis strokes, and a position of this function has it stand at point R.",
                        "Run plumb wire again. A message of interlock names the pin and the missing net."}
                .told(Tell::text);
        default: return said_of_service(status);
    }
}

constexpr const char* sentence(Common status) {
    return said(status).sentence;
}

// Those that a stage has, too: interlock gives it none.
constexpr Said said_of_stage(Common status) {
    switch (status) {
        case Common::fault:
        case Common::off:
        case Common::suspended:
        case Common::probing:
        case Common::machine_off:
        case Common::not_homed: return said(status);
        default: return {};
    }
}

// Whether the number is a status that interlock gives.
constexpr bool is_common(std::int32_t number) {
    const bool own = number >= first_own && number != static_cast<std::int32_t>(Common::at_point_r);
    return number > 0 && !own && said(static_cast<Common>(number)).sentence;
}

template <class E>
constexpr E common(Common status) {
    return static_cast<E>(status);
}

}  // namespace plumb::hal
