// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/contact/contact_cycle.hpp"
#include "components/math/contact/contact_finder.hpp"
#include "components/math/contact/contact_rejection.hpp"
#include "components/math/contact/cycle_tally.hpp"
#include "components/math/contact/displacement_law.hpp"
#include "components/math/contact/growth_authority.hpp"
#include "components/math/contact/growth_estimator.hpp"
#include "components/math/contact/plausibility_gate.hpp"
#include "components/math/contact/reference_refusal.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plumb {

// Measures the growth of a spindle cycle by cycle: finds the contacts, learns from a cycle or pairs them
// with the reference, and accepts contacts that can be compared and lie within the gate.
class GrowthByContact {
public:
    struct Settings {
        Method method = Method::coordinate;
        std::int32_t reference_cycles = 1;  // cycles in the mean
        ContactFinder::Settings finder;
        ContactLimits limits;
        PlausibilityGate::Settings gate;
        GrowthBetweenContacts::Settings between;
        double hold_time = 1800;  // s without a contact that counted, after which the offset returns to 0

        GrowthEstimator::Settings estimator() const noexcept { return {between, gate.floor, gate.cap}; }

        bool valid() const noexcept {
            return hold_time > 0 && hold_time <= 1e6 && reference_cycles >= 1 && finder.valid() &&
                   limits.valid() && gate.valid() && between.valid();
        }
    };

    using Sample = ContactFinder::Sample;
    using Lost = ContactFinder::Lost;
    static Sample judged(const Sample& s) noexcept { return ContactFinder::judged(s); }

    // The result of a period.
    enum class Event { none, contact, accepted };

    // One period of dt > 0, in s. The sample is judged. `at_zero`: no offset is in force, as it must be while
    // learning. The settings must be valid.
    Event step(const Sample& s, bool at_zero, const Settings& settings, double dt) noexcept {
        const Event event = find(s, at_zero, settings, dt);
        if (known())
            authority_.step(evidence(s, event, settings), {settings.gate.floor, settings.hold_time}, dt);
        return event;
    }

    const ContactCycle& cycle() const noexcept { return cycle_; }
    const ReferenceRefusal& refusal() const noexcept { return refusal_; }
    const LoadContact& detector() const noexcept { return finder_.detector(); }
    double gate(const Settings& settings) const noexcept { return gate_.spread(settings.gate); }  // mu

    bool in_work() const noexcept { return finder_.in_work(); }  // see there

    // The growth is known to half of the narrowest gate at best.
    bool uncertain(const Settings& settings) const noexcept {
        return !known() || estimator_.sigma() > 0.5 * settings.gate.floor;
    }
    const CycleTally& tally() const noexcept { return tally_; }

    // The growth may be applied: nothing is being learnt, and the reference is not refused.
    bool applicable() const noexcept {
        return !cycle_.learning() && refusal_.reason() == Refusal::none &&
               (refusal_.compares() || !cycle_.running());
    }

    // The last contact, even a rejected one.
    const Contact& contact() const noexcept { return finder_.found().contact; }

    // By the last contact that could be compared, in mu.
    double growth() const noexcept { return growth_; }
    double sigma() const noexcept { return sigma_; }

    // A contact was accepted; nothing has been forgotten since.
    bool known() const noexcept { return gate_.known() && estimator_.known(); }

    // The growth now, by the model or the last accepted contact, and its standard deviation, in mu.
    double estimate(const Settings& settings) const noexcept {
        return settings.between.by_speed ? estimator_.growth() : gate_.growth();
    }
    double estimate_sigma() const noexcept { return estimator_.sigma(); }
    // The offset that may be applied, see there.
    const GrowthAuthority& authority() const noexcept { return authority_; }
    double reference_sigma() const noexcept { return reference_sigma_; }  // mu, of all gauges together
    // Growth to expect within the learning cycle, in mu: a cut is compared with one at another time of it.
    double learning_growth() const noexcept { return learning_growth_; }

    // See ReferenceRefusal.
    void acknowledge() noexcept { refusal_.acknowledge(); }

    // See ContactCycle. The growth is unknown then.
    bool restore(const ContactReference& reference) noexcept {
        if (!cycle_.restore(reference)) return false;
        forget_growth();
        return true;
    }
    void forget() noexcept {
        forget_growth();
        cycle_.forget();
    }

private:
    Event find(const Sample& s, bool at_zero, const Settings& settings, double dt) noexcept {
        follow_cycle(s, settings);
        if (!s.complete || !s.learn || !at_zero || !(s.setup == setup_)) cycle_.spoil();
        gate_.step(dt);
        estimator_.step(s.speed, s.temperature, s.temperature_valid, settings.estimator(), dt);
        step_ = s.step;
        switch (finder_.step(s, cycle_, settings.limits.feed_tolerance, settings.finder, dt)) {
            case ContactFinder::Found::contact: return judge(Rejection::none, settings);
            case ContactFinder::Found::blanked: return judge(Rejection::blanked, settings);
            case ContactFinder::Found::no_onset: return judge(Rejection::no_onset, settings);
            case ContactFinder::Found::lost:
                tally_.find();
                cycle_.spoil();
                reject(Rejection::no_onset);
                return Event::none;
            default: return Event::none;
        }
    }

    // A cycle begins as cycle_running rises, never in its middle, and ends as that or enable falls.
    void follow_cycle(const Sample& s, const Settings& settings) noexcept {
        const bool starts = running_.rises(s.cycle_running);
        if (cycle_.running() && !(s.enable && s.cycle_running)) {
            const bool complete = s.enable && s.cycle_complete;
            CycleTally::Cycle its;
            its.learning = cycle_.learning();
            its.compared = refusal_.compares();
            its.complete = s.cycle_complete;
            its.enabled = s.enable;
            if (finder_.end()) cycle_.spoil();
            const ContactCycle::Ended ended =
                cycle_.end(complete, settings.method, settings.reference_cycles, settings.gate.floor);
            its.new_reference = its.learning && ended.fault == LearningFault::none && cycle_.learnt() == 0;
            its.missed = ended.missed;
            its.fault = ended.fault;
            if (its.new_reference) {
                estimator_.renew_gauges();
                learning_growth_ = std::abs(estimator_.usual_growth(settings.estimator()) - usual_growth_);
            }
            reference_sigma_ = judge_references(settings);
            refusal_.end(complete && !its.learning);
            tally_.end(its);
        }
        if (s.enable && starts) {
            cycle_.begin(s.learn, s.setup);
            refusal_.begin(cycle_.references(), s.setup, s.learn);
            finder_.begin(settings.finder.program_clock);
            tally_.begin();
            reference_sigma_ = judge_references(settings);
            usual_growth_ = estimator_.usual_growth(settings.estimator());
            setup_ = s.setup;
        }
    }

    // Accepts or rejects the noted contact, unless it is rejected already.
    Event judge(Rejection rejection, const Settings& settings) noexcept {
        tally_.find();
        const bool learning = cycle_.learning();
        const bool fresh = learning && cycle_.learnt() == 0;  // there is nothing to compare with yet
        if (!learning && !comparable(finder_.found().setup)) return reject(Rejection::no_reference);
        return judge_comparable(rejection, fresh, settings);
    }

    Event judge_comparable(Rejection rejection, bool fresh, const Settings& settings) noexcept {
        const bool learning = cycle_.learning();
        const ContactReference* partner = cycle_.partner(finder_.found().key);
        if (rejection != Rejection::none) return reject(rejection);
        if (finder_.steady_time() < settings.limits.steady_time) return reject(Rejection::unsteady_feed);
        if (learning && lacks_clock(settings.method, finder_.found().contact)) {
            cycle_.lack_clock();
            return reject(Rejection::no_clock);
        }
        const Rejection reason = fresh      ? Rejection::none
                                 : !partner ? Rejection::unexpected
                                            : compare(*partner, settings);
        if (learning) cycle_.learn(finder_.found(), !fresh && reason == Rejection::none);
        if (reason != Rejection::none) return reject(reason);
        const double sigma = learning && fresh ? finder_.found().contact.sigma : sigma_;
        if (learning) estimator_.learn(fresh ? 0 : growth_, sigma, fresh, settings.estimator());
        gate_.accept(fresh ? 0 : growth_);
        tally_.accept(learning);
        return learning ? Event::contact : Event::accepted;
    }

    bool comparable(const MachiningSetup& setup) const noexcept {
        return refusal_.compares() && cycle_.references().made_with(setup);
    }

    Rejection compare(const ContactReference& partner, const Settings& settings) noexcept {
        const Contact& now = finder_.found().contact;
        const Rejection reason = comparison(settings.method, now, partner.contact, settings.limits);
        refusal_.compared(now, partner.contact, reason, settings.limits.feed_tolerance);
        if (reason != Rejection::none) return reason;
        growth_ = plumb::growth(settings.method, now, partner.contact);
        sigma_ = std::hypot(displacement_sigma(now, partner), feed_sigma(now, partner.contact));
        if (!(std::abs(growth_ - gate_.growth()) <= settings.limits.max_correction))
            return Rejection::too_large;
        const bool inside = std::abs(growth_ - gate_.growth()) <= gate_.spread(settings.gate);
        const bool admitted = gate_.admits(growth_, finder_.found().key.tool, cycle_.number(), settings.gate);
        if (cycle_.learning()) return admitted ? Rejection::none : Rejection::beyond_gate;
        GrowthEstimator::Reading r = reading(partner, settings);
        r.admitted = admitted;
        r.confirmed = admitted && !inside;
        const GrowthEstimator::Verdict verdict = estimator_.judge(r, settings.estimator());
        if (verdict != GrowthEstimator::Verdict::withdrawn)
            tally_.agree(verdict == GrowthEstimator::Verdict::accepted);
        switch (verdict) {
            case GrowthEstimator::Verdict::claim:
                return admitted ? Rejection::unconfirmed : Rejection::beyond_gate;
            case GrowthEstimator::Verdict::withdrawn: return Rejection::withdrawn;
            default: return Rejection::none;
        }
    }

    GrowthEstimator::Reading reading(const ContactReference& partner,
                                     const Settings& settings) const noexcept {
        const ContactReferences& references = cycle_.references();
        GrowthEstimator::Reading r;
        r.growth = growth_;
        r.noise = std::hypot(std::max(finder_.found().contact.sigma, partner.scatter),
                             feed_sigma(finder_.found().contact, partner.contact));
        r.reference_sigma = own_sigma(partner, settings);
        r.applied_offset = finder_.found().contact.applied_offset;
        r.step = step_;
        r.gauge = references.find(partner.key);
        r.tool = partner.key.tool;
        r.cycle = cycle_.number();
        for (std::int32_t i = 0; i < references.size(); ++i)
            r.other_tools |= references[i].key.tool != r.tool &&
                             estimator_.withdrawal(i) == GrowthEstimator::Withdrawal::none;
        return r;
    }

    static double own_sigma(const ContactReference& reference, const Settings& settings) noexcept {
        const double scatter = std::max(reference.scatter, settings.between.repeatability);
        return std::max(reference.contact.sigma,
                        std::hypot(reference.contact.sigma, scatter / std::sqrt(reference.cycles)));
    }

    // Of all gauges together.
    double judge_references(const Settings& settings) const noexcept {
        double sum = 0;
        const ContactReferences& references = cycle_.references();
        for (std::int32_t i = 0; i < references.size(); ++i) {
            const double sigma = own_sigma(references[i], settings);
            sum += 1 / (sigma * sigma);
        }
        return sum > 0 ? 1 / std::sqrt(sum) : 0;
    }

    GrowthAuthority::Evidence evidence(const Sample& s, Event event,
                                       const Settings& settings) const noexcept {
        GrowthAuthority::Evidence e;
        e.held = settings.between.by_speed ? estimator_.held() : gate_.growth();
        e.predicted = estimate(settings);
        e.sigma = estimator_.sigma();
        e.since_sigma = estimator_.since_sigma();
        e.spread = gate_.spread(settings.gate);
        e.reference_sigma = reference_sigma_;
        e.agreement = tally_.agreement();
        e.predicts = settings.between.by_speed;
        e.load_valid = !s.load_lost;
        e.barren = tally_.barren();
        e.contradicted = estimator_.contradicted();
        e.program_event = estimator_.program_event();
        e.no_growth = estimator_.lacks_growth(settings.estimator());
        e.settled = estimator_.accepted() >= 2;
        e.in_cycle = cycle_.running();
        e.accepted = event == Event::accepted;
        return e;
    }

    void forget_growth() noexcept {
        gate_.forget();
        estimator_.forget();
        authority_.forget();
        tally_.forget();
    }

    Event reject(Rejection reason) noexcept {
        tally_.reject(reason);
        return Event::contact;
    }

    ContactFinder finder_;
    ContactCycle cycle_;
    PlausibilityGate gate_;
    GrowthEstimator estimator_;
    GrowthAuthority authority_;
    CycleTally tally_;
    double reference_sigma_ = 0;
    double usual_growth_ = 0, learning_growth_ = 0;  // as this cycle began, and within the learning cycle
    Edge running_;
    MachiningSetup setup_;  // as the cycle began
    ReferenceRefusal refusal_;

    double growth_ = 0;
    double sigma_ = 0;
    double step_ = 0;
};

}  // namespace plumb
