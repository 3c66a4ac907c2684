// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/authority.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"

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
    no_growth,
    poor_reference,
    prediction,
    uncertain,
};

constexpr const char* sentence(Doubt doubt) {
    switch (doubt) {
        case Doubt::load: return "The load is not valid: the offset holds, and returns to 0 after hold-time.";
        case Doubt::missed:
            return "Contacts do not come, or do not count: the offset holds, and returns to 0 after "
                   "hold-time.";
        case Doubt::old: return "No contact has counted for hold-time: the offset returns to 0.";
        case Doubt::contradiction:
            return "The contacts of one operation contradict the others: check its tool, and learn again.";
        case Doubt::program_event:
            return "The load of an operation rises by the program, not by the work: it does not count.";
        case Doubt::no_growth:
            return "The spindle should have grown at its speed, and contacts do not show it: verify them.";
        case Doubt::poor_reference: return "The reference is uncertain: learn again, or improve the load.";
        case Doubt::prediction:
            return "The growth since the last contact is uncertain: the offset holds that contact.";
        case Doubt::uncertain: return "The growth is uncertain: the offset is a part of it, or may do harm.";
        default: return nullptr;
    }
}

// The growth that may be applied: that of the last contacts and, as far as it is certain, the change that the
// model adds to it; times an Authority. In a cycle a loss of certainty holds it as it is.
class GrowthAuthority {
public:
    struct Settings {
        double floor = 0.015;  // mu, standard deviation from which a prediction counts for nothing
        double hold = 1800;    // s without a contact that counted
    };

    struct Evidence {
        double held = 0, predicted = 0;     // mu, at the last accepted contact and now
        double sigma = 0, since_sigma = 0;  // mu, of `predicted`, and of its change since that contact
        double spread = 0;                  // mu, of the gate
        double reference_sigma = 0;         // mu
        double agreement = 1;               // 0 to 1, of the last contacts
        bool predicts = true;               // the model is asked for
        bool load_valid = true;
        bool barren = false;  // contacts should have come, and none has counted
        bool contradicted = false, program_event = false, no_growth = false;
        bool settled = true;                      // contacts have shown the growth to expect
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
        authority_.step({growth_, sigma_, age_, e.agreement}, e.in_cycle,
                        {1, 2, settings.floor / 3, settings.hold});
        if (!holds || authority_.part() > before) offset_ = authority_.part() * growth_;
        judge(e, certain, settings);
    }

    double offset() const noexcept { return offset_; }          // mu, to be applied
    double part() const noexcept { return authority_.part(); }  // of the growth
    double age() const noexcept { return age_; }                // s without a contact that counted
    Doubt doubt() const noexcept { return doubt_; }

    void forget() noexcept { *this = GrowthAuthority(); }

private:
    void judge(const Evidence& e, double certain, const Settings& settings) noexcept {
        const double poor = 0.4 * settings.floor, harm = settings.floor / 3;
        const double unapplied = std::abs(growth_ - offset_);
        // So far may the growth be off before the offset does more harm than that.
        const double margin = std::abs(growth_) - 0.5 * (std::abs(offset_) - harm);
        const bool risky = std::abs(offset_) > harm && margin < sigma_;
        if (std::abs(growth_) > harm && authority_.part() > 0.9) was_trusted_ = true;
        const bool doubtful = risky || (was_trusted_ && unapplied > harm);
        doubt_ = !e.load_valid                   ? Doubt::load
                 : age_ > settings.hold          ? Doubt::old
                 : e.contradicted                ? Doubt::contradiction
                 : e.program_event               ? Doubt::program_event
                 : e.barren || e.agreement < 0.5 ? Doubt::missed
                 : e.no_growth                   ? Doubt::no_growth
                 : e.reference_sigma > poor      ? Doubt::poor_reference
                 : !e.settled                    ? Doubt::none
                 : !doubtful                     ? Doubt::none
                 : e.predicts && certain < 0.5   ? Doubt::prediction
                                                 : Doubt::uncertain;
    }

    Authority authority_;
    double base_ = 0, growth_ = 0, sigma_ = 0, offset_ = 0;
    double trusted_ = 0, age_ = 0;
    Edge silence_;
    bool was_trusted_ = false;
    Doubt doubt_ = Doubt::none;
};

}  // namespace plumb
