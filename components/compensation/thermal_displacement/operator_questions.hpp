// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/growth_by_contact.hpp"
#include "components/math/blocks/edge.hpp"
#include "hal/component.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

// Questions that only the operator can answer: what a shift of contacts is, and why the origin of the program
// has changed.
struct OperatorQuestions : hal::Group {
    using Group::Group;

    // An answer by M68.
    enum class Answer : std::int32_t { none, growth, not_growth, zero, by_hand, depth };

    // Once a period, before the contacts are compared. Returns the reason of a change of the origin, if one
    // is given.
    OriginReason reason() noexcept {
        given_ = by_program();
        return is_zero || given_ == Answer::zero         ? OriginReason::zero
               : is_by_hand || given_ == Answer::by_hand ? OriginReason::by_hand
               : is_depth || given_ == Answer::depth     ? OriginReason::depth
                                                         : OriginReason::none;
    }

    // After reason().
    void answer(GrowthByContact& measured) noexcept {
        if (growth_.rises(is_growth || given_ == Answer::growth)) measured.shift_is_growth();
        if (other_.rises(is_not_growth || given_ == Answer::not_growth)) measured.shift_is_not_growth();
    }

    bool open(const GrowthByContact& measured, const DisplacementSettings& settings) const noexcept {
        return measured.origin_change() != 0 || measured.filter().shift(settings) != Shift::none;
    }

    void show(const GrowthByContact& measured, const DisplacementSettings& settings, bool applying) noexcept {
        const GrowthFilter& growth = measured.filter();
        const bool shifted = applying && growth.shift(settings) != Shift::none;
        shift_size = shifted ? growth.shift_size() : 0;
        origin_change = applying ? measured.origin_change() : 0;
        wait = applying && wait_for_answer && open(measured, settings);
    }

    hal::In<bool> wait_for_answer{this, "wait-for-answer", false,
                                  "While a question has no answer, the next cycle is to wait: wait is true.",
                                  hal::machine()};
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
                             "4 change-is-growth, 5 change-is-depth; 0 for none."};
    hal::Out<double> shift_size{this, "shift-size", "mu",
                                "Distance by which contacts moved at once, not by growth; 0 for none."};
    hal::Out<double> origin_change{
        this, "origin-change", "mu",
        "Change of work offset or tool length for which no reason was given; 0 for none."};
    hal::Out<bool> wait{this, "wait", "The next cycle is to wait for an answer."};

private:
    Answer by_program() noexcept {
        const double number = answered;
        const double last = static_cast<double>(Answer::depth);
        return number > 0.5 && number < last + 0.5 ? static_cast<Answer>(std::lround(number)) : Answer::none;
    }

    Edge growth_, other_;
    Answer given_ = Answer::none;
};

}  // namespace plumb
