// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/contact.hpp"
#include "components/compensation/thermal_displacement/contact_cycle.hpp"
#include "components/compensation/thermal_displacement/growth_filter.hpp"
#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

// The cause of a status: a fault, or a LearningFault, Refusal or Rejection as its number above these.
enum class DisplacementDetail : std::int32_t {
    none,
    load,
    position,
    spindle_speed,
    applied_offset,
    approach,
    settings,
    lost_track,
    learning_fault = 10,
    refusal = 20,
    rejection = 30,
};

constexpr std::int32_t number(DisplacementDetail detail) {
    return static_cast<std::int32_t>(detail);
}

constexpr DisplacementDetail behind(DisplacementDetail first, std::int32_t code) {
    return code == 0 ? DisplacementDetail::none : static_cast<DisplacementDetail>(number(first) + code);
}

constexpr DisplacementDetail detail(Rejection rejection) {
    return behind(DisplacementDetail::rejection, static_cast<std::int32_t>(rejection));
}

constexpr DisplacementDetail detail(LearningFault fault) {
    switch (fault) {
        case LearningFault::no_clock: return detail(Rejection::no_clock);
        case LearningFault::rises_twice: return detail(Rejection::rises_twice);
        default: return behind(DisplacementDetail::learning_fault, static_cast<std::int32_t>(fault));
    }
}

constexpr DisplacementDetail detail(Refusal refusal) {
    if (refusal == Refusal::feed) return detail(Rejection::feed_differs);
    return behind(DisplacementDetail::refusal, static_cast<std::int32_t>(refusal));
}

constexpr const char* sentence(DisplacementDetail detail) {
    using D = DisplacementDetail;
    switch (detail) {
        case D::load: return "The load is invalid.";
        case D::position: return "The position or velocity of Z is invalid: z-position, z-velocity-cmd.";
        case D::spindle_speed: return "The spindle speed is invalid: spindle-speed-cmd.";
        case D::applied_offset: return "The applied offset is invalid: applied-offset.";
        case D::approach: return "The feed override or start height is invalid: feed-override, start-height.";
        case D::settings: return "The settings are out of range; the last good ones are used.";
        case D::lost_track:
            return "No contact was accepted in three cycles. Check the machine and learn again.";
        default: break;
    }
    if (detail > D::rejection) return sentence(static_cast<Rejection>(number(detail) - number(D::rejection)));
    if (detail > D::refusal) return sentence(static_cast<Refusal>(number(detail) - number(D::refusal)));
    return sentence(static_cast<LearningFault>(number(detail) - number(D::learning_fault)));
}

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
    missed,
    dry_run,
    no_contact,
    bounded,
    asks,
    asks_origin,
    uncertain,
    asks_of_tool,
    asks_of_feeds,
    program_event,
    old,
    poor_reference,
    held_back = 62,
    waits,
    learns_again,
};

// Somebody has to act, or to answer.
constexpr hal::Said doubted(const char* sentence, const char* remedy, const char* detail = "",
                            const char* size = "") {
    return hal::Said{hal::Kind::warn, sentence, remedy, {}, detail, size}.told(hal::Tell::behind_panel);
}

// The next contacts end it.
constexpr hal::Said awaited(const char* sentence) {
    return {hal::Kind::warn, sentence, "Wait for the next contacts.", {}, "offset-sigma"};
}

constexpr hal::Said said(DisplacementStatus status) {
    using hal::Kind;
    using hal::Tell;
    using S = DisplacementStatus;
    switch (status) {
        case S::works: return {Kind::good, "Corrects the growth.", "", {}, "offset-sigma"};
        case S::load_lost:
            return {Kind::bad, "The load is lost: its sensor reports no valid value.",
                    "Check it. Until then the offset holds, and returns to 0 after the hold time."};
        case S::learning: return {Kind::good, "Learns from this part.", "", {}, "contacts"};
        case S::will_learn:
            return {Kind::wait, "Learns from the next part.",
                    "Run one part; on the cold machine while no growth is known."};
        case S::learning_failed:
            return hal::Said{Kind::warn, "Nothing was learned.", "Remove the cause, and learn again.",
                             hal::Button::learn, "detail-code"}
                .told(Tell::text);
        case S::learns_again:
            return hal::Said{Kind::wait,
                             "Nothing was learned: the next part is learned from.",
                             "Run it as before.",
                             {},
                             "detail-code"}
                .told(Tell::text);
        case S::refused:
            return {Kind::bad, "The reference is refused: nothing is corrected.",
                    "Acknowledge when the program has its feed again, or learn again.",
                    hal::Button::acknowledge, "detail-code"};
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
            return {Kind::warn, "No reference is of this program and these tools: nothing is corrected.",
                    "Learn from a part of this program. The references of others stay, of eight programs.",
                    hal::Button::learn, "detail-code"};
        case S::missed:
            return doubted(
                "Contacts do not come, or do not count: the offset holds, and returns to 0 after the hold "
                "time.",
                "Remove the cause, or learn again.", "detail-code");
        case S::old:
            return doubted("No contact has counted for the hold time: the offset returns to 0.",
                           "Remove the cause, or learn again.", "detail-code");
        case S::program_event:
            return doubted(
                "The load of an operation rises by the program, not by the work: it does not count.",
                "Keep the load steady before its contact, and learn again, or exclude the operation.");
        case S::poor_reference:
            return doubted("The reference is uncertain.", "Learn again, or improve the load.", "",
                           "reference-sigma");
        case S::uncertain: return awaited("The growth is less certain than the tolerance of the work.");
        case S::held_back: return awaited("The growth is so uncertain that only a part of it is applied.");
        case S::asks:
            return doubted(
                "All contacts moved at once, by growth or not: the offset harms no part either way.",
                "Other work, zero, tool or drive? Answer on the panel, by growth_answer or check_growth.",
                "unanswered-code", "shift-size");
        case S::asks_of_tool:
            return doubted(
                "The contacts of one tool moved at once, others did not: the offset leaves that out.",
                "Another tool? Answer on the panel, by growth_answer or check_growth.", "unanswered-code");
        case S::asks_of_feeds:
            return doubted(
                "The contacts moved in proportion to their feeds: the offset harms no part either way.",
                "Another latency of the drive? Answer on the panel, by growth_answer or check_growth.",
                "unanswered-code", "shift-size");
        case S::asks_origin:
            return doubted("The work offset or a tool length has changed without a reason.",
                           "New zero, growth corrected by hand, or another depth? Answer on the panel or by "
                           "growth_answer.",
                           "unanswered-code", "origin-change");
        case S::waits:
            return hal::Said{Kind::warn,
                             "The next part waits: the error to expect exceeds the tolerance of the work.",
                             "Acknowledge, and one part is made; its contacts may end the doubt.",
                             hal::Button::acknowledge,
                             "detail-code",
                             "offset-sigma"}
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
        default:
            if (static_cast<hal::Common>(status) == hal::Common::fault)
                return {Kind::bad, "A fault is active.", "Remove its cause.", {}, "detail-code"};
            return hal::said(static_cast<hal::Common>(status));
    }
}

struct DisplacementSeen {
    DisplacementDetail fault{};
    LearningFault learning_fault{};
    Refusal refusal{};
    Rejection rejection{};  // of the last contact
    Doubt doubt{};          // the load, a shift and the origin have statuses of their own
    Shift shift{};          // without an answer
    bool enabled = false, load_valid = true;
    bool learning = false, will_learn = false, learns_again = false;
    bool has_reference = false, has_rows = false;  // has_reference: for this program
    bool cycle_running = false, dry_run = false, asks_origin = false;
    bool known = false, bounded = false, waits = false;
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
    return hal::first<S>({{its.fault != DisplacementDetail{}, hal::common<S>(hal::Common::fault)},
                          {prevents(its.interlock), its.interlock},
                          {!its.enabled && its.interlock == S{}, hal::common<S>(hal::Common::off)},
                          {!its.load_valid, S::load_lost},
                          {its.learning, S::learning},
                          {its.learns_again, S::learns_again},
                          {its.will_learn, S::will_learn},
                          {its.learning_fault != LearningFault{}, S::learning_failed},
                          {its.refusal == Refusal::feed, S::refused},
                          {!its.has_reference && !its.has_rows, S::no_reference},
                          {!its.has_reference && !its.cycle_running && its.refusal == Refusal{}, S::kept},
                          {!its.has_reference, S::other_program},
                          {its.interlock != S{}, its.interlock},
                          {its.asks_origin, S::asks_origin},
                          {its.shift == Shift::one_tool, S::asks_of_tool},
                          {its.shift == Shift::by_feed, S::asks_of_feeds},
                          {its.shift != Shift::none, S::asks},
                          {its.waits, S::waits},
                          {its.doubt == Doubt::missed, S::missed},
                          {its.doubt == Doubt::old, S::old},
                          {its.doubt == Doubt::program_event, S::program_event},
                          {its.doubt == Doubt::poor_reference, S::poor_reference},
                          {its.doubt == Doubt::uncertain, S::uncertain},
                          {its.doubt == Doubt::held_back, S::held_back},
                          {its.dry_run, S::dry_run},
                          {!its.known || its.doubt == Doubt::unknown, S::no_contact},
                          {its.bounded, S::bounded},
                          {true, S::works}});
}

// As urgent as the statuses that name it. A learning cycle has its own rejections.
inline DisplacementDetail detail_of(const DisplacementSeen& its) noexcept {
    const bool failed = its.learning_fault != LearningFault{} && !its.learning;
    return hal::first<DisplacementDetail>({{its.fault != DisplacementDetail{}, its.fault},
                                           {failed, detail(its.learning_fault)},
                                           {its.refusal != Refusal{}, detail(its.refusal)},
                                           {true, detail(its.rejection)}});
}

}  // namespace plumb
