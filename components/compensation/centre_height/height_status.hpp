// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/centre_height/height_codes.hpp"
#include "hal/first.hpp"
#include "hal/status.hpp"

#include <cstdint>

namespace plumb {

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
    entry_refused
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
                        "Remove the cause, cut more lands, or begin again.",
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
};

inline HeightStatus status_of(const HeightSeen& its) noexcept {
    using S = HeightStatus;
    switch (its.state) {
        case State::refused: return S::refused;
        case State::aborted: return S::interrupted;
        default: break;
    }
    if (its.fault != Detail::none) return S::entry_refused;
    switch (its.state) {
        case State::cut: return S::cut;
        case State::measure: return S::measure;
        case State::known: break;
        default: return its.interlock != S{} ? its.interlock : S::idle;
    }
    switch (its.verdict) {
        case Verdict::on_centre: return S::on_centre;
        case Verdict::held: return S::held;
        case Verdict::both: return S::off_centre;
        case Verdict::y: return S::y_off_centre;
        case Verdict::x: return S::x_off_centre;
        case Verdict::unchecked: return S::unchecked;
        default: return S::unsure;
    }
}

}  // namespace plumb
