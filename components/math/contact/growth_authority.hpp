// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/authority.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/contact/growth_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

// Why less than the whole growth is applied, or why it may be wrong.
enum class Doubt : std::int32_t {
    none,
    load,
    missed,
    old,
    contradiction,
    program_event,
    shift,
    poor_reference,
    prediction,
    uncertain,
    held_back,
    unknown,
    shift_of_only_tool,
};

constexpr const char* sentence(Doubt doubt) {
    switch (doubt) {
        case Doubt::load: return "The load is not valid: the offset holds, and returns to 0 after hold-time.";
        case Doubt::missed:
            return "Contacts do not come, or do not count: the offset holds, and returns to 0 after "
                   "hold-time.";
        case Doubt::old: return "No contact has counted for hold-time: the offset returns to 0.";
        case Doubt::contradiction:
            return "The contacts of one tool moved at once, others did not: another tool, or measured again? "
                   "Growth cannot do that.";
        case Doubt::program_event:
            return "The load of an operation rises by the program, not by the work: it does not count.";
        case Doubt::shift:
            return "All contacts moved at once: other work, zero, tool setting or drive? Growth cannot do "
                   "that.";
        case Doubt::shift_of_only_tool:
            return "All contacts moved at once: other work, zero, tool, tool setting or drive? Growth cannot "
                   "do that.";
        case Doubt::poor_reference: return "The reference is uncertain: learn again, or improve the load.";
        case Doubt::prediction:
            return "The growth since the last contact is uncertain: the offset holds that contact.";
        case Doubt::uncertain: return "The growth is less certain than work-tolerance.";
        case Doubt::held_back: return "The growth is so uncertain that only a part of it is applied.";
        case Doubt::unknown:
            return "The growth is unknown: no offset until the first contact. Pre-cut, probe, or accept.";
        default: return nullptr;
    }
}

// The growth that may be applied: that of the last contacts and, as far as it is certain, the change that the
// model adds to it; times an Authority. In a cycle a loss of certainty holds it as it is.
class GrowthAuthority {
public:
    struct Settings {
        double floor = 0.015;      // mu, standard deviation from which a prediction counts for nothing
        double hold = 1800;        // s without a contact that counted
        double tolerance = 0.010;  // mu, of the work: an error to expect beyond it is a doubt
    };

    struct Evidence {
        double held = 0, predicted = 0;     // mu, at the last accepted contact and now
        double sigma = 0, since_sigma = 0;  // mu, of `predicted`, and of its change since that contact
        double spread = 0;                  // mu, of the gate
        double reference_sigma = 0;         // mu
        bool predicts = true;               // the model is asked for
        bool load_valid = true;
        bool barren = false;  // contacts should have come, and none has counted
        bool program_event = false;
        bool compared = true;                     // a contact has come since the reference or the start
        Shift shift = Shift::none;                // that is large enough to matter
        bool in_cycle = false, accepted = false;  // in this period
    };

    // Once a period of dt > 0, in s, while a growth is known.
    void step(const Evidence& e, const Settings& settings, double dt) noexcept {
        const bool silent = e.barren || !e.load_valid;
        age_ = silent ? age_ + dt : 0;
        const double certain = silent || !e.predicts
                                   ? 0
                                   : Authority::rising(-e.since_sigma, -settings.floor, -settings.floor / 3);
        if (e.accepted) base_ = e.held;
        if (silence_.rises(silent)) base_ = growth_;
        const bool holds = e.in_cycle && !e.accepted && certain < trusted_;
        if (!holds) {
            trusted_ = certain;
            growth_ = base_ + bounded(trusted_ * (e.predicted - base_), e.spread);
        }
        sigma_ = silent ? e.sigma : std::hypot(e.sigma, growth_ - e.predicted);
        const double before = authority_.part();
        // What is held does harm if less than half of it is left; by the prediction twice that much is left.
        const double left = 2 * std::copysign(e.predicted, growth_ * e.predicted) - std::abs(growth_);
        const double value = silent ? growth_ : std::max(left, 0.0);
        authority_.step({value, e.sigma, age_, 1}, e.in_cycle,
                        {none, whole, settings.floor / 3, settings.hold});
        if (!holds || authority_.part() > before) offset_ = authority_.part() * growth_;
        judge(e, certain, settings);
    }

    double offset() const noexcept { return offset_; }          // mu, to be applied
    double part() const noexcept { return authority_.part(); }  // of the growth
    double age() const noexcept { return age_; }                // s without a contact that counted
    Doubt doubt() const noexcept { return doubt_; }

    void forget() noexcept { *this = GrowthAuthority(); }

private:
    // Standard deviations from harm. From three on the whole growth does it once in 700 contacts: that is for
    // a load so poor that its reference alone may be off by the whole growth.
    static constexpr double none = 1.5, whole = 3;

    void judge(const Evidence& e, double certain, const Settings& settings) noexcept {
        const double unapplied = std::abs(growth_ - offset_);
        const double expected = std::hypot(sigma_, unapplied);
        doubtful_ = expected > (doubtful_ ? 0.8 : 1) * settings.tolerance;
        doubt_ = !e.load_valid                        ? Doubt::load
                 : age_ > settings.hold               ? Doubt::old
                 : e.shift == Shift::one_tool         ? Doubt::contradiction
                 : e.shift == Shift::all              ? Doubt::shift
                 : e.shift == Shift::only_tool        ? Doubt::shift_of_only_tool
                 : e.program_event                    ? Doubt::program_event
                 : e.barren                           ? Doubt::missed
                 : !doubtful_                         ? Doubt::none
                 : !e.compared                        ? Doubt::unknown
                 : unapplied > 0.7 * expected         ? Doubt::held_back
                 : e.reference_sigma > 0.7 * expected ? Doubt::poor_reference
                 : e.predicts && certain < 0.5        ? Doubt::prediction
                                                      : Doubt::uncertain;
    }

    Authority authority_;
    double base_ = 0, growth_ = 0, sigma_ = 0, offset_ = 0;
    double trusted_ = 0, age_ = 0;
    Edge silence_;
    bool doubtful_ = false;
    Doubt doubt_ = Doubt::none;
};

}  // namespace plumb
