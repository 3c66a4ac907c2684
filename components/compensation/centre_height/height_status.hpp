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
    disagree
};

constexpr hal::Said said(HeightStatus status) {
    using hal::Kind;
    using hal::Tell;
    using S = HeightStatus;
    switch (status) {
        case S::idle:
            return {Kind::off, "No tool is measured.", "Begin with one of the methods.", hal::Button::start};
        case S::cut:
            return {Kind::wait, "Waits for the next cut.", "Cut the next land.", hal::Button::cut_done};
        case S::measure:
            return hal::Said{Kind::wait, "Waits for the measurement of this cut.",
                             "Measure it, and enter the value: on the panel, by M452 P, or by the gauge.",
                             hal::Button::enter}
                .told(Tell::behind_panel);
        case S::on_centre: return hal::Said{Kind::good, "The tool is on centre."}.told(Tell::behind_panel);
        case S::off_centre:
            return hal::Said{Kind::warn, "The tool is off centre.", "Store the values.", hal::Button::store,
                             "verdict-code"}
                .told(Tell::behind_panel);
        case S::unsure:
            return hal::Said{
                Kind::warn, "The height is not known well enough.", "Cut again.", {}, "verdict-code"}
                .told(Tell::behind_panel);
        case S::held:
            return hal::Said{Kind::warn,
                             "The tool is off centre, and nothing may be stored.",
                             "Remove the cause.",
                             {},
                             "hold-code"}
                .told(Tell::behind_panel);
        case S::refused:
            return {Kind::bad, "The cuts give no height.", "Begin again.", hal::Button::start, "fault-code"};
        case S::interrupted:
            return {Kind::warn, "The measurement is interrupted.", "Resume it, or begin again.",
                    hal::Button::resume};
        case S::disagree:
            return hal::Said{Kind::warn,
                             "The cuts disagree: a burr, a chip or a slip.",
                             "Cut more lands, or begin again.",
                             {},
                             "hold-code"}
                .told(Tell::behind_panel);
        default: return hal::said(static_cast<hal::Common>(status));
    }
}

struct HeightSeen {
    State state = State::idle;
    Fault fault = Fault::none;
    Verdict verdict = Verdict::none;
    HeightStatus interlock{};
    Hold hold = Hold::none;
};

inline HeightStatus status_of(const HeightSeen& its) noexcept {
    using S = HeightStatus;
    switch (its.state) {
        case State::refused: return S::refused;
        case State::aborted: return S::interrupted;
        default: break;
    }
    if (its.fault != Fault::none) return hal::common<S>(hal::Common::fault);
    switch (its.state) {
        case State::cut: return S::cut;
        case State::measure: return S::measure;
        case State::known: break;
        default: return its.interlock != S{} ? its.interlock : S::idle;
    }
    switch (its.verdict) {
        case Verdict::on_centre: return S::on_centre;
        case Verdict::held: return its.hold == Hold::disagreement ? S::disagree : S::held;
        case Verdict::both:
        case Verdict::y:
        case Verdict::x: return S::off_centre;
        default: return S::unsure;
    }
}

}  // namespace plumb
