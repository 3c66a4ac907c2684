// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/edge.hpp"
#include "components/math/contact/growth_by_contact.hpp"
#include "hal/component.hpp"

namespace plumb {

// The question that a shift of contacts is, and its answer. Without an answer the offset leaves the shift
// out.
struct ShiftQuestion : hal::Group {
    using Group::Group;

    void answer(GrowthByContact& measured) noexcept {
        if (growth_.rises(is_growth)) measured.shift_is_growth();
        if (other_.rises(is_not_growth)) measured.shift_is_not_growth();
    }

    void show(const GrowthByContact& measured, const GrowthFromContacts::Settings& settings,
              bool applying) noexcept {
        const Shift shift = applying ? measured.from_contacts().shift(settings) : Shift::none;
        size = shift == Shift::none ? 0 : measured.from_contacts().estimator().shift_size();
        wait = shift != Shift::none && wait_for_answer;
    }

    hal::In<bool> wait_for_answer{this, "wait-for-answer", false,
                                  "While a shift has no answer, the next cycle is to wait: wait is true."};
    hal::In<bool> is_growth{this, "shift-is-growth", false,
                            "A rising edge answers a shift: it is growth, and is applied."};
    hal::In<bool> is_not_growth{
        this, "shift-is-not-growth", false,
        "A rising edge answers a shift: work, zero, tool or drive have changed; the references follow."};
    hal::Out<double> size{this, "shift-size", "mu",
                          "Distance by which contacts moved at once, not by growth; 0 for none."};
    hal::Out<bool> wait{this, "wait", "The next cycle is to wait for the answer to a shift."};

private:
    Edge growth_, other_;
};

}  // namespace plumb
