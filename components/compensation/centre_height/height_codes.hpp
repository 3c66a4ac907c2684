// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

// More about a status: why there is no height, why the tool may not be moved, or the cuts that make an
// unknown height known. One at a time, and 0 for none.
enum class Detail : std::int32_t {
    none,
    diameter,
    radius,
    doubled,
    inch,
    metric,
    beam,
    position,
    settings,
    too_few,
    travel,
    travel_differs,
    order,
    short_travel,
    long_travel,
    past_centre,
    air_cut,
    clearance,
    no_step,
    no_solution,
    implausible,
    no_load,
    insert,
    not_shown,
    nothing_stored,
    second_angle,
    value_only = 31,  // a height, and Y may not move
    sign,
    insignificant,
    sigma,
    move,
    disagreement,
    at_rest,
    shim,
    sign_by_shim,
    x_bounded,
    more_cuts = 41,  // an unknown height
    lands,
    finer,
    finer_two,
    again,
    lobes,
};
constexpr const char* sentence(Detail detail) {
    using D = Detail;
    switch (detail) {
        case D::diameter: return "The diameter is not above 0. Measure and enter it again.";
        case D::radius: return "The entry is the radius, not the diameter. Enter the diameter.";
        case D::doubled: return "The entry is the diameter, not the radius. Enter the radius.";
        case D::inch: return "The entry is in inches. Enter it in the unit of the machine.";
        case D::metric: return "The entry is in millimetres. Enter it in the unit of the machine.";
        case D::beam: return "The work is not inside the beam, or more light is received than emitted.";
        case D::position: return "A position of X or Y is invalid.";
        case D::settings: return "A setting is out of its range.";
        case D::too_few: return "The method needs more cuts.";
        case D::travel: return "The travel of X between the cuts is not above 0.";
        case D::travel_differs:
            return "The entered travel is not the travel of X. Enter it as a radius, not in diameter.";
        case D::order:
            return "The second cut did not go deeper. The diameters are swapped, or the tool did not cut.";
        case D::short_travel: return "The diameters differ by more than X has travelled.";
        case D::long_travel: return "The travel is larger than both radii together.";
        case D::past_centre:
            return "The tool has passed the axis of the work; the radius is the height itself. Travel less.";
        case D::air_cut:
            return "The diameter of cut {suspect-cut} equals the diameter of the stock or of the land "
                   "before. "
                   "Read it again: a turn of a micrometer is 0.5 mm. If it reads the same, the tool removed "
                   "nothing: cut deeper.";
        case D::clearance: return "The tool rubs at this height: its clearance angle is too small.";
        case D::no_step: return "The method needs cuts at two positions of Y.";
        case D::no_solution: return "The cuts do not determine the height: move X and Y independently.";
        case D::implausible:
            return "The diameter of cut {suspect-cut} does not follow from X of the tool. Read it again: a "
                   "turn of a micrometer is 0.5 mm. If it reads the same, the tool did not cut, or its X or "
                   "Y is "
                   "wrong by more than max-x-correction or max-move.";
        case D::no_load:
            return "The load of the spindle has shown no cut. Start the spindle, and cut deeper.";
        case D::insert:
            return "The last diameter does not fit. Check the insert; index it if it is chipped, then begin "
                   "again.";
        case D::not_shown:
            return "The land does not have the programmed diameter. The tool table has its former values "
                   "again. Check the insert, the tool and the reading, then begin again.";
        case D::nothing_stored: return "Nothing was stored that a land could show.";
        case D::second_angle:
            return "Measure this cut a quarter turn further, too, and enter both diameters: a bar that is "
                   "not round shows so.";
        case D::value_only:
            return "The function is not permitted: move Y by {y-move} by hand, or switch it on.";
        case D::sign: return "Two cuts do not show the sign. Cut with a step of Y, or set sign to 1 or -1.";
        case D::insignificant: return "The height of {height} may be none: cut again.";
        case D::sigma: return "The uncertainty of the height, {sigma}, exceeds max-sigma.";
        case D::move: return "The move of Y by {y-move} exceeds max-move.";
        case D::disagreement:
            return "The cuts disagree by more than three sigmas: a burr, a chip or a slip. Cut {suspect-cut} "
                   "contradicts the others most: read it again.";
        case D::at_rest:
            return "The height of {height} is that at rest. Y is corrected by the height under the cut.";
        case D::shim:
            return "This machine has no Y: raise the tool by {y-move}, with a shim. Below 0, lower it.";
        case D::sign_by_shim:
            return "Two cuts do not show the sign. Cut a third time with a shim below the tool, or set sign "
                   "to 1 or -1.";
        case D::x_bounded:
            return "X of the tool is wrong by {x-correction}: that is beyond max-x-correction, or the "
                   "function is not permitted.";
        case D::more_cuts: return "Cut more lands in the same order, {cuts-needed} cuts in all.";
        case D::lands: return "Begin again with two lands in the order 1 2 2 1, {cuts-needed} cuts in all.";
        case D::again:
            return "Cut {suspect-cut} does not fit the others. Read it again, and correct it; or cut once "
                   "more.";
        case D::lobes:
            return "The work is not round: its readings at two angles differ. Take another bar, or read more "
                   "lands at two angles.";
        case D::finer:
            return "16 cuts are not enough: take a larger land-step, a finer gauge or a larger tolerance.";
        case D::finer_two:
            return "More cuts do not help. Take a finer gauge, a longer travel of X between the cuts, or a "
                   "larger tolerance.";
        default: return nullptr;
    }
}

// Where the procedure is.
enum class State : std::int32_t { idle, cut, measure, known, refused, aborted };

// The answer for Y and X of the tool.
enum class Verdict : std::int32_t { none, on_centre, both, y, x, unsure, unchecked, held, check, shown };

// given: a height from another instrument. show: the land that tests the stored values.
enum class Method : std::int32_t { two_cuts, two_lands, y_step, any_cuts, given, show };

enum class HeightStatus : std::int32_t {
    idle = hal::first_own,
    cut,
    measure,
    on_centre,
    off_centre,
    unsure,
    held,
    refused,
    interrupted,
    unchecked,
    y_off_centre,
    x_off_centre,
    entry_refused,
    check,
    shown,
    table
};

constexpr hal::Said said(HeightStatus status) {
    using hal::Button;
    using hal::Kind;
    using hal::Said;
    using hal::Tell;
    using S = HeightStatus;
    switch (status) {
        case S::idle:
            return {Kind::off, "No tool is measured.", "Begin with one of the methods.", Button::start};
        case S::cut:
            return {Kind::wait, "Waits for the next cut.",
                    "Cut the next land, and report its end: on the panel, or by M451.", Button::cut_done};
        case S::measure:
            return Said{Kind::wait, "Waits for the measurement of this cut.",
                        "Measure it, and enter the value: on the panel, by M452 P, or by the gauge.",
                        Button::enter}
                .told(Tell::behind_panel);
        case S::entry_refused:
            return {Kind::bad, "An entry is refused.", "Measure that cut again, and enter the value.",
                    Button::enter, "detail-code"};
        case S::check:
            return Said{Kind::wait, "Waits for the check: a cut whose diameter the others predict.",
                        "Cut once more, deeper, and report its end: on the panel, or by M451.",
                        Button::cut_done}
                .told(Tell::behind_panel);
        case S::table:
            return Said{
                Kind::warn, "The tool table was changed while LinuxCNC was off; nothing is stored.",
                "Keep it by M159 P1, or take it back: the message and the terminal show the row, old and "
                "new."};
        case S::shown: return Said{Kind::good, "A land shows the stored height."}.told(Tell::behind_panel);
        case S::on_centre: return Said{Kind::good, "The tool is on centre."}.told(Tell::behind_panel);
        case S::off_centre:
            return Said{Kind::warn,
                        "Y and X of the tool are wrong.",
                        "Store both: on the panel, or by M454.",
                        Button::store,
                        "",
                        "y-move"}
                .told(Tell::behind_panel);
        case S::y_off_centre:
            return Said{Kind::warn,
                        "Y of the tool is wrong.",
                        "Store it: on the panel, or by M454. X stays.",
                        Button::store,
                        "",
                        "y-move"}
                .told(Tell::behind_panel);
        case S::x_off_centre:
            return Said{Kind::warn,
                        "X of the tool is wrong.",
                        "Store it: on the panel, or by M454. Y stays.",
                        Button::store,
                        "detail-code",
                        "x-correction"}
                .told(Tell::behind_panel);
        case S::unsure:
            return Said{
                Kind::warn, "The height is not known well enough.", "Then measure again.", {}, "detail-code"}
                .told(Tell::behind_panel);
        case S::unchecked:
            return Said{Kind::warn, "The tool seems on centre, but the cuts are not checked for air.",
                        "Enter the diameter of the stock: M450 E."}
                .told(Tell::behind_panel);
        case S::held:
            return Said{Kind::warn,
                        "The tool is off centre, and nothing may be stored.",
                        "Remove the cause, cut once more, or begin again.",
                        {},
                        "detail-code"}
                .told(Tell::behind_panel);
        case S::refused:
            return {Kind::bad, "The cuts give no height.", "Begin again.", Button::start, "detail-code"};
        case S::interrupted:
            return {Kind::warn, "The measurement is interrupted.", "Resume it, or begin again.",
                    Button::resume};
        default:
            if (static_cast<hal::Common>(status) == hal::Common::fault) return {};  // entry_refused
            return hal::said(static_cast<hal::Common>(status));
    }
}

struct HeightSeen {
    State state = State::idle;
    Detail fault = Detail::none;
    Verdict verdict = Verdict::none;
    HeightStatus interlock{};
    bool table_asks = false;
};

inline HeightStatus status_of(const HeightSeen& seen) noexcept {
    using S = HeightStatus;
    switch (seen.state) {
        case State::refused: return S::refused;
        case State::aborted: return S::interrupted;
        default: break;
    }
    if (seen.fault != Detail::none) return S::entry_refused;
    if (seen.table_asks && (seen.state == State::idle || seen.state == State::known)) return S::table;
    switch (seen.state) {
        case State::cut: return S::cut;
        case State::measure: return S::measure;
        case State::known: break;
        default: return seen.interlock != S{} ? seen.interlock : S::idle;
    }
    switch (seen.verdict) {
        case Verdict::on_centre: return S::on_centre;
        case Verdict::held: return S::held;
        case Verdict::both: return S::off_centre;
        case Verdict::y: return S::y_off_centre;
        case Verdict::x: return S::x_off_centre;
        case Verdict::unchecked: return S::unchecked;
        case Verdict::check: return S::check;
        case Verdict::shown: return S::shown;
        default: return S::unsure;
    }
}

}  // namespace plumb
