// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/growth_by_contact.hpp"
#include "components/math/blocks/edge.hpp"
#include "hal/codes.hpp"
#include "hal/component.hpp"
#include "hal/told.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

// What is done while a doubt is open, until somebody answers or acknowledges.
enum class AtDoubt : std::int32_t { go_on, stop, call };

// at-doubt, from 1 on; of one tool that cuts deeper from 4 on, shallower from 7 on.
enum class Unanswered : std::int32_t { none };

constexpr const char* sentence(Unanswered unanswered) {
    constexpr const char* texts[] = {
        "If nobody answers, parts go on.",
        "If nobody answers, the next part waits.",
        "If nobody answers, parts go on, and the machine calls.",
        "Tool {shift-tool} has cut deeper for {shift-age}: {shift-size}. If nobody answers, parts go on.",
        "Tool {shift-tool} has cut deeper for {shift-age}: {shift-size}. If nobody answers, the next part "
        "waits.",
        "Tool {shift-tool} has cut deeper for {shift-age}: {shift-size}. If nobody answers, parts go on, and "
        "the machine calls.",
        "Tool {shift-tool} has cut shallower for {shift-age}: {shift-size}. If nobody answers, parts go on.",
        "Tool {shift-tool} has cut shallower for {shift-age}: {shift-size}. If nobody answers, the next part "
        "waits.",
        "Tool {shift-tool} has cut shallower for {shift-age}: {shift-size}. If nobody answers, parts go on, "
        "and the machine calls.",
    };
    const auto number = static_cast<std::int32_t>(unanswered);
    return number >= 1 && number <= 9 ? texts[number - 1] : nullptr;
}

constexpr const char* sentence(SurfaceCheck check) {
    switch (check) {
        case SurfaceCheck::unknown:
            return "The growth is not known yet. Machine a part, and probe the surface again.";
        case SurfaceCheck::first: return "The first height of this surface with this tool is kept.";
        case SurfaceCheck::growth: return "The surface shows the growth that the contacts have shown.";
        case SurfaceCheck::is_growth:
            return "The surface has moved as the contacts have: it is growth, and Z is corrected.";
        case SurfaceCheck::is_no_growth:
            return "The surface shows that the contacts moved without growth: the reference follows.";
        case SurfaceCheck::undecided:
            return "The surface does not decide yet. Probe it again, with a tool that is not in question.";
        case SurfaceCheck::unlike:
            return "The surface has moved, and not as the contacts have. Check the gauge tool and the place.";
        default: return nullptr;
    }
}

// Questions that the operator can answer, or a fixed surface: what a shift of contacts is, and why the origin
// of the program has changed. Until then they and other doubts are as at-doubt says.
struct OperatorQuestions : hal::Group {
    using Group::Group;

    // An answer by M68.
    enum class Answer : std::int32_t { none, growth, not_growth, zero, by_hand, depth, surface };

    // Once a period, before the contacts are compared. Returns the reason of a change of the origin, if one
    // is given.
    OriginReason reason() noexcept {
        given_ = by_program();
        return is_zero || given_ == Answer::zero         ? OriginReason::zero
               : is_by_hand || given_ == Answer::by_hand ? OriginReason::by_hand
               : is_depth || given_ == Answer::depth     ? OriginReason::depth
                                                         : OriginReason::none;
    }

    // After reason(). `acknowledged`: one part may be made in spite of a doubt. One question at a time: while
    // the origin is asked about, no shift is.
    void answer(GrowthByContact& measured, const DisplacementSettings& settings, std::int32_t tool,
                bool acknowledged, double dt) noexcept {
        age_ = measured.filter().has_moved() ? age_ + dt : 0;
        const bool growth = growth_.rises(is_growth || given_ == Answer::growth);
        const bool other = other_.rises(is_not_growth || given_ == Answer::not_growth);
        const bool asks_shift = measured.origin_change() == 0;
        if (growth && asks_shift) measured.shift_is_growth();
        if (other && asks_shift) measured.shift_is_not_growth();
        const bool running = measured.cycle().running();
        if (cycle_.changes(running)) {
            if (running)
                checked_ = SurfaceCheck::none;
            else
                passed_ = false;
        }
        passed_ |= acknowledged;
        const double height = surface;
        if (surface_.rises(given_ == Answer::surface) && std::abs(height) <= 1e6)
            checked_ = measured.check(height, tool, settings);
    }

    bool open(const GrowthByContact& measured, const DisplacementSettings& settings) const noexcept {
        return measured.origin_change() != 0 || measured.filter().shift(settings) != Shift::none;
    }

    void show(const GrowthByContact& measured, const DisplacementSettings& settings, bool applying) noexcept {
        const GrowthFilter& growth = measured.filter();
        const double asked = applying ? measured.origin_change() : 0;
        const bool shifted = applying && asked == 0 && growth.shift(settings) != Shift::none;
        shift_size = shifted ? growth.shift_size() : 0;
        shift_tool_ = shifted ? measured.asked_tool(settings) : 0;
        shift_tool = shift_tool_;
        shift_age = shifted ? age_ : 0;
        origin_change = asked;
        const std::int32_t number = at_doubt;
        const auto then = number == 1 ? AtDoubt::stop : number == 2 ? AtDoubt::call : AtDoubt::go_on;
        const bool asks = applying && open(measured, settings);
        const bool doubts = (asks || (applying && growth.doubtful())) && !passed_;
        waits_ = doubts && then == AtDoubt::stop;
        wait = waits_;
        call = doubts && then == AtDoubt::call;
        const std::int32_t of_tool = shift_tool_ == 0 ? 0 : growth.shift_size() > 0 ? 3 : 6;
        unanswered = static_cast<Unanswered>(asks ? static_cast<std::int32_t>(then) + 1 + of_tool : 0);
        check_due = measured.known() && (!growth.has_surface() || growth.shift(settings) != Shift::none);
        check_code = checked_;
        check_news = checked_ != SurfaceCheck::none && checked_ != SurfaceCheck::growth;
    }
    bool waits() const noexcept { return waits_; }

    hal::In<std::int32_t> at_doubt{this, "at-doubt", 0,
                                   "While a question is open, or the error to expect exceeds work-tolerance: "
                                   "0 continue, 1 stop before the "
                                   "next part, 2 call.",
                                   hal::machine(hal::Range{0, 2})};
    hal::In<bool> is_growth{this, "shift-is-growth", false,
                            "A rising edge answers a shift: it is growth, and is applied."};
    hal::In<bool> is_not_growth{
        this, "shift-is-not-growth", false,
        "A rising edge answers a shift: work, zero, tool or drive have changed; the references follow."};
    hal::In<bool> is_zero{this, "change-is-zero", false,
                          "The work offset or tool length changes, or has changed: a new zero, or the tool "
                          "was measured again."};
    hal::In<bool> is_by_hand{this, "change-is-growth", false,
                             "The work offset changes, or has changed: growth was corrected by hand."};
    hal::In<bool> is_depth{
        this, "change-is-depth", false,
        "The work offset or tool length changes, or has changed: another depth is wanted."};
    hal::In<double> answered{this, "answer", 0, "1",
                             "Answer by M68: 1 shift-is-growth, 2 shift-is-not-growth, 3 change-is-zero, "
                             "4 change-is-growth, 5 change-is-depth, 6 surface; 0 for none."};
    hal::In<double> surface{this, "surface", 0, "mu",
                            "Height of the joint at which a gauge tool has touched a fixed surface."};
    hal::Out<double> shift_size{this, "shift-size", "mu",
                                "Distance by which contacts moved at once, not by growth; 0 for none."};
    hal::Out<std::int32_t> shift_tool{this, "shift-tool", "Tool whose contacts alone moved; 0 for none."};
    hal::Out<double> shift_age{this, "shift-age", "s", "Time since the contacts moved at once."};
    hal::Out<double> origin_change{
        this, "origin-change", "mu",
        "Change of work offset or tool length for which no reason was given; 0 for none."};
    hal::Out<bool> wait{this, "wait", "The next cycle is to wait for an answer, or for acknowledge."};
    hal::Out<bool> call{this, "call", "A doubt needs somebody: for a lamp or a telephone."};
    hal::Code<Unanswered> unanswered{this, "unanswered-code",
                                     "What is done until the question is answered; 0 for no question."};
    hal::Out<bool> check_due{this, "check-due", "A fixed surface is to be probed before the next part."};
    hal::Code<SurfaceCheck> check_code{this, "check-code",
                                       "What the fixed surface has shown; 0 from the next cycle on."};
    hal::Out<bool> check_news{this, "check-news",
                              "The fixed surface has shown more than the growth of the contacts."};
    hal::Told told_check{this, "check-news", hal::Tell::text, "{check-code}"};

private:
    Answer by_program() noexcept {
        const double number = answered;
        const double last = static_cast<double>(Answer::surface);
        return number > 0.5 && number < last + 0.5 ? static_cast<Answer>(std::lround(number)) : Answer::none;
    }

    Edge growth_, other_, surface_, cycle_;
    Answer given_ = Answer::none;
    SurfaceCheck checked_ = SurfaceCheck::none;
    bool passed_ = false, waits_ = false;
    double age_ = 0;  // s, of a shift
    std::int32_t shift_tool_ = 0;
};

}  // namespace plumb
