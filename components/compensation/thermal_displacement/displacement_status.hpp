// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

enum class DisplacementStatus : std::int32_t {
    works = hal::first_own,
    load_lost,
    learning,
    will_learn,
    learning_failed,
    refused,
    no_reference,
    kept,
    other_program,
    doubted,
    dry_run,
    no_contact,
    bounded,
    asks,
    asks_origin,
    uncertain
};

constexpr hal::Said said(DisplacementStatus status) {
    using hal::Kind;
    using hal::Tell;
    using S = DisplacementStatus;
    switch (status) {
        case S::works: return {Kind::good, "Corrects the growth.", "", {}, "offset-sigma"};
        case S::load_lost:
            return {Kind::bad,
                    "The load is lost: its sensor reports no valid value.",
                    "Check the sensor of the load.",
                    {},
                    "doubt-code"};
        case S::learning: return {Kind::good, "Learns from this part.", "", {}, "contacts"};
        case S::will_learn:
            return {Kind::wait, "Learns from the next part.", "Run one part on the cold machine."};
        case S::learning_failed:
            return hal::Said{Kind::warn, "Nothing was learned.", "Remove the cause, and learn again.",
                             hal::Button::learn, "learning-failed-code"}
                .told(Tell::text);
        case S::refused:
            return {Kind::bad, "The reference is refused: nothing is corrected.",
                    "Acknowledge if the reference fits, or learn again.", hal::Button::acknowledge,
                    "refusal-code"};
        case S::no_reference:
            return {Kind::warn, "There is no reference: nothing is corrected.",
                    "Learn from a part on the cold machine.", hal::Button::learn};
        case S::kept:
            return {Kind::wait,
                    "A reference is kept, and waits for its program.",
                    "Start the program. Do not learn again.",
                    {},
                    "rows"};
        case S::other_program:
            return {Kind::warn, "The kept reference is of another program or other tools.",
                    "Load its program. Learning again replaces the reference.", hal::Button::learn};
        case S::doubted:
            return hal::Said{Kind::warn,
                             "The growth is not trusted.",
                             "Remove the cause, or learn again.",
                             {},
                             "doubt-code"}
                .told(Tell::behind_panel);
        case S::uncertain:
            return {Kind::warn, "The growth is uncertain.", "Wait for the next contacts.", {}, "doubt-code"};
        case S::asks:
            return hal::Said{Kind::warn,
                             "Contacts moved at once: the offset leaves that out, and waits for your answer.",
                             "Answer on the panel, or by growth_answer, whether it is growth.",
                             {},
                             "doubt-code"}
                .sized("shift-size")
                .told(Tell::behind_panel);
        case S::asks_origin:
            return hal::Said{
                Kind::warn, "The work offset or a tool length has changed without a reason.",
                "Give the reason on the panel, or by growth_answer: a new zero, growth corrected by "
                "hand, or another depth."}
                .sized("origin-change")
                .told(Tell::behind_panel);
        case S::dry_run:
            return {Kind::off, "Measure only: the growth is measured, and Z is not moved.",
                    "Let it correct when the growth is plausible.", hal::Button::dry_run};
        case S::no_contact:
            return hal::Said{
                Kind::wait, "Waits for the first contact: the growth is not known yet.",
                "The program brings it. Until then nothing is corrected: pre-cut, probe, or accept."}
                .told(Tell::behind_panel);
        case S::bounded:
            return {Kind::warn, "The growth exceeds the largest offset: Z is corrected in part.",
                    "Check the contacts, or raise the largest offset."};
        default: return hal::said(static_cast<hal::Common>(status));
    }
}

struct DisplacementSeen {
    bool fault = false, enabled = false, load_valid = true;
    bool learning = false, will_learn = false, learning_failed = false;
    bool refused = false, has_reference = false, has_rows = false;  // has_reference: for this program
    bool cycle_running = false, dry_run = false, doubted = false, asks = false, asks_origin = false;
    bool known = false, bounded = false;
    bool uncertain = false;  // doubted, and nobody has to act
    DisplacementStatus interlock{};
};

// Whether interlock keeps it from comparing contacts, too; with the machine off, the reference says more.
constexpr bool prevents(DisplacementStatus interlock) {
    switch (static_cast<hal::Common>(interlock)) {
        case hal::Common::off:
        case hal::Common::renew:
        case hal::Common::order: return true;
        default:
            return static_cast<std::int32_t>(interlock) >= static_cast<std::int32_t>(hal::Common::late) &&
                   static_cast<std::int32_t>(interlock) < static_cast<std::int32_t>(hal::Common::ending);
    }
}

inline DisplacementStatus status_of(const DisplacementSeen& its) noexcept {
    using S = DisplacementStatus;
    return hal::first<S>({{its.fault, hal::common<S>(hal::Common::fault)},
                          {prevents(its.interlock), its.interlock},
                          {!its.enabled && its.interlock == S{}, hal::common<S>(hal::Common::off)},
                          {!its.load_valid, S::load_lost},
                          {its.learning, S::learning},
                          {its.will_learn, S::will_learn},
                          {its.learning_failed, S::learning_failed},
                          {its.refused, S::refused},
                          {!its.has_reference && !its.has_rows, S::no_reference},
                          {!its.has_reference && !its.cycle_running, S::kept},
                          {!its.has_reference, S::other_program},
                          {its.interlock != S{}, its.interlock},
                          {its.asks_origin, S::asks_origin},
                          {its.asks, S::asks},
                          {its.uncertain, S::uncertain},
                          {its.doubted, S::doubted},
                          {its.dry_run, S::dry_run},
                          {!its.known, S::no_contact},
                          {its.bounded, S::bounded},
                          {true, S::works}});
}

}  // namespace plumb
