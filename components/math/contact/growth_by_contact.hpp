// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/math/contact/approach_clock.hpp"
#include "components/math/contact/contact_cycle.hpp"
#include "components/math/contact/contact_onset.hpp"
#include "components/math/contact/contact_rejection.hpp"
#include "components/math/contact/descent.hpp"
#include "components/math/contact/displacement_law.hpp"
#include "components/math/contact/growth_authority.hpp"
#include "components/math/contact/growth_estimator.hpp"
#include "components/math/contact/load_contact.hpp"
#include "components/math/contact/plausibility_gate.hpp"
#include "components/math/contact/reference_refusal.hpp"
#include "components/math/contact/steady_feed.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace plumb {

// Measures the growth of a spindle cycle by cycle: finds the contacts, learns from a cycle or pairs them
// with the reference, and accepts contacts that can be compared and lie within the gate.
class GrowthByContact {
public:
    struct Settings {
        Method method = Method::coordinate;
        bool program_clock = false;              // the clock starts with the cycle, not at the start height
        std::array<std::int32_t, 8> excluded{};  // keys of operations without a gauge of Z; 0 for none
        double load_latency = 0;                 // s, age of the load
        std::int32_t reference_cycles = 1;       // cycles in the mean
        LoadContact::Settings contact;
        ContactLimits limits;
        PlausibilityGate::Settings gate;
        GrowthBetweenContacts::Settings between;
        double hold_time = 1800;  // s without a contact that counted, after which the offset returns to 0

        GrowthEstimator::Settings estimator() const noexcept { return {between, gate.floor, gate.cap}; }

        bool valid() const noexcept {
            return hold_time > 0 && hold_time <= 1e6 && load_latency >= 0 && load_latency <= 10 &&
                   reference_cycles >= 1 && contact.valid() && limits.valid() && gate.valid() &&
                   between.valid();
        }
    };

    // The signals of one period.
    struct Sample {
        bool enable = false;
        bool learn = false;
        bool cycle_running = false;
        bool cycle_complete = false;  // as the cycle ends: it was not aborted
        MachiningSetup setup;
        std::int32_t motion = 0;  // as LinuxCNC's motion.motion-type
        std::int32_t tool = 0;
        std::int32_t operation = 0;  // key; 0 for none
        double load = 0;             // %
        bool load_valid = true;
        double speed = 0;                // rpm
        double z = 0;                    // mu, offset included
        double velocity = 0;             // mu/s, signed, negative towards the work
        double feed_override = 1;        // ratio
        double start_height = 0;         // mu, without offset
        double applied_offset = 0;       // mu
        double step = 0;                 // mu, by which it is displaced on purpose
        double temperature = 20;         // degC, to remember; the last good one stays
        std::int32_t date = 0;           // YYYYMMDD, to remember
        bool temperature_valid = false;  // the growth may follow it
    };

    // The invalid part of a sample; such a sample is not used.
    enum class Lost { nothing, load, position, speed, offset, approach };

    static Lost lost(const Sample& s) noexcept {
        const auto bad = [](double x) { return !(std::abs(x) <= 1e6); };
        if (bad(s.load)) return Lost::load;
        if (bad(s.z) || bad(s.velocity)) return Lost::position;
        if (bad(s.speed)) return Lost::speed;
        if (bad(s.applied_offset)) return Lost::offset;
        return bad(s.feed_override) || bad(s.start_height) ? Lost::approach : Lost::nothing;
    }

    // The result of a period.
    enum class Event { none, contact, accepted };

    // One period of dt > 0, in s. `at_zero`: no offset is in force, as it must be while learning. The
    // settings must be valid.
    Event step(const Sample& s, bool at_zero, const Settings& settings, double dt) noexcept {
        const Event event = find(s, at_zero, settings, dt);
        if (known())
            authority_.step(evidence(s, event, settings), {settings.gate.floor, settings.hold_time}, dt);
        return event;
    }

private:
    Event find(const Sample& s, bool at_zero, const Settings& settings, double dt) noexcept {
        const bool complete_sample = lost(s) == Lost::nothing && s.load_valid;
        step_ = s.step;
        follow_cycle(s, settings);
        if (!complete_sample || !s.learn || !at_zero || !(s.setup == setup_)) cycle_.spoil();
        gate_.step(dt);
        estimator_.step(s.speed, s.temperature, s.temperature_valid, settings.estimator(), dt);
        if (complete_sample) speed_history_.step(std::abs(s.speed), history_time, dt);
        follow_clock(s, complete_sample, settings.program_clock, dt);

        const Travel way = travel(s, settings);
        descent_.step(s.z, feeds_down(s), way == Travel::clear, s.operation, s.tool);
        follow_approach(s, way);
        if (complete_sample) {
            feed_.step(s.velocity, settings.limits.feed_tolerance, dt);
            follow_depth(s, way);
        }

        const double load = complete_sample ? s.load : std::numeric_limits<double>::quiet_NaN();
        const LoadContact::Event event = detector_.step(load, s.speed, way, settings.contact, dt);
        const bool approach = complete_sample && way == Travel::towards_work && !detector_.blanked();
        note_age_ += dt;
        if (event == LoadContact::Event::rise) note(s, settings.load_latency);
        if (event == LoadContact::Event::contact) onset_.start(known_time_constant());
        const bool fitted = onset_.step(approach, s.load, s.z, dt);
        if (event == LoadContact::Event::blanked) return judge(Rejection::blanked, settings);
        return fitted ? judge(fit(settings.load_latency), settings) : Event::none;
    }

public:
    const ContactCycle& cycle() const noexcept { return cycle_; }
    const ReferenceRefusal& refusal() const noexcept { return refusal_; }
    const LoadContact& detector() const noexcept { return detector_; }
    double gate(const Settings& settings) const noexcept { return gate_.spread(settings.gate); }  // mu

    // The tool may be cutting, is still lower than at its contact, or feeds down to it. An offset that
    // moves meanwhile changes the feed at the contact, and goes on moving until the load shows it.
    bool in_work() const noexcept { return detector_.in_work() || below_contact_ || descent_.under_way(); }

    // The growth is known to half of the narrowest gate at best.
    bool uncertain(const Settings& settings) const noexcept {
        return !known() || estimator_.sigma() > 0.5 * settings.gate.floor;
    }
    LearningFault learning_fault() const noexcept { return learning_fault_; }  // of the last learning cycle

    // The growth may be applied: nothing is being learnt, and the reference is not refused.
    bool applicable() const noexcept {
        return !cycle_.learning() && refusal_.reason() == Refusal::none &&
               (refusal_.compares() || !cycle_.running());
    }

    // In the last cycles, at least three, contacts were compared and none accepted: the accepted growth is
    // wrong by now, and the gate rejects the right one. Ends with an accepted contact.
    bool lost_track() const noexcept { return barren_cycles_ >= 3; }

    // The last contact, even a rejected one.
    const Contact& contact() const noexcept { return note_.contact; }
    Rejection rejection() const noexcept { return rejection_; }  // the last one

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

    struct Counts {
        std::int32_t contacts = 0;  // learnt ones, and the next three
        std::int32_t accepted = 0;
        std::int32_t rejected = 0;
        std::int32_t unexpected = 0;  // without a partner
        std::int32_t missed = 0;      // in complete cycles
    };
    const Counts& counts() const noexcept { return counts_; }

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
    static constexpr double history_time = 600;         // s
    static constexpr std::int32_t rapid = 1, feed = 2;  // of motion

    // A cycle begins as cycle_running rises, never in its middle, and ends as that or enable falls.
    void follow_cycle(const Sample& s, const Settings& settings) noexcept {
        if (cycle_.running() && !(s.enable && s.cycle_running)) {
            const bool learnt_from = cycle_.learning(), compared = refusal_.compares();
            const bool complete = s.enable && s.cycle_complete;
            if (onset_.busy()) cycle_.spoil();
            onset_.cancel();
            const ContactCycle::Ended ended =
                cycle_.end(complete, settings.method, settings.reference_cycles, settings.gate.floor);
            if (learnt_from && ended.fault == LearningFault::none && cycle_.learnt() == 0) {
                estimator_.renew_gauges();
                agreement_ = 1;
            }
            if (compared && !learnt_from && complete)
                barren_ = barren_ || counts_.accepted == accepted_before_;
            reference_sigma_ = judge_references(settings);
            refusal_.end(complete && !learnt_from);
            if (compared) counts_.missed += ended.missed;
            if (learnt_from) learning_fault_ = ended.fault;
            if (compared && !learnt_from && s.cycle_complete && counts_.rejected > rejected_before_)
                ++barren_cycles_;
            clock_.stop();
        }
        if (s.enable && s.cycle_running && !was_running_) {
            cycle_.begin(s.learn, s.setup);
            refusal_.begin(cycle_.references(), s.setup, s.learn);
            approaching_ = false;
            descent_.cancel();
            rejected_before_ = counts_.rejected;
            accepted_before_ = counts_.accepted;
            reference_sigma_ = judge_references(settings);
            setup_ = s.setup;
            if (settings.program_clock) clock_.start();
        }
        was_running_ = s.cycle_running;
    }

    void follow_clock(const Sample& s, bool complete_sample, bool program_clock, double dt) noexcept {
        if (!complete_sample || (s.operation != operation_ && !program_clock)) clock_.stop();
        operation_ = s.operation;
        clock_.step(s.velocity, dt);
        if (complete_sample && !program_clock)
            clock_.start_below(s.z - s.applied_offset, s.start_height, s.velocity, dt);
    }

    Travel travel(const Sample& s, const Settings& settings) const noexcept {
        if (s.motion == rapid || (s.velocity > 0 && !detector_.high())) return Travel::clear;
        if (!feeds_down(s)) return Travel::other;
        const auto& excluded = settings.excluded;
        const bool used = std::find(excluded.begin(), excluded.end(), s.operation) == excluded.end();
        return used ? Travel::towards_work : Travel::other;
    }

    // In an operation of a cycle, even if its contacts do not count.
    bool feeds_down(const Sample& s) const noexcept {
        return s.motion == feed && s.velocity < 0 && cycle_.running() && s.operation != 0;
    }

    // An approach begins as Z feeds towards the work for the first time since it was clear of it.
    void follow_approach(const Sample& s, Travel way) noexcept {
        if (way == Travel::clear) approaching_ = false;
        if (way != Travel::towards_work || (approaching_ && same_task(s, approach_))) return;
        approaching_ = true;
        approach_ = cycle_.approach(s.operation, s.tool);
        feed_.begin();
    }

    // Above its last contact the tool is out of the work; so it is on its way to another one.
    void follow_depth(const Sample& s, Travel way) noexcept {
        const bool leaving = way == Travel::clear && s.operation != 0 && !same_task(s, note_.key);
        if (s.z >= note_.contact.coordinate || leaving) below_contact_ = false;
    }

    static bool same_task(const Sample& s, const ContactKey& key) noexcept {
        return s.operation == key.operation && s.tool == key.tool;
    }

    // Notes the state when the load crossed the threshold, earlier by the age of the load.
    void note(const Sample& s, double load_latency) noexcept {
        const double ago = detector_.since_rise() + load_latency;
        below_contact_ = true;
        note_age_ = 0;
        give_up_fit();
        note_.key = approach_;
        note_.contact.coordinate = s.z - s.velocity * ago;
        note_time_ = clock_.time();
        note_.contact.time = std::max(0.0, note_time_ - ago);
        note_.contact.lost_time = clock_.lost_time(s.velocity);
        note_.contact.feed = s.velocity;
        note_.contact.feed_override = s.feed_override;
        note_.contact.applied_offset = s.applied_offset;
        steady_time_ = feed_.time() - ago;
        note_.setup = s.setup;
        note_.speed_history = speed_history_.value();
        note_.temperature = usable(s.temperature, 1e3, note_.temperature);
        note_.date = std::max(s.date, 0);
    }

    // The next contact has come before the moment of the last one was known.
    void give_up_fit() noexcept {
        if (!onset_.busy()) return;
        onset_.cancel();
        ++counts_.contacts;
        cycle_.spoil();
        reject(Rejection::no_onset);
    }

    // The time constant of the contact's partner; 0 without a partner.
    double known_time_constant() const noexcept {
        const ContactReference* partner = cycle_.expected(note_.key);
        return partner ? partner->contact.time_constant : 0;
    }

    // The fit moves the noted contact to its true place.
    Rejection fit(double load_latency) noexcept {
        if (!onset_.found()) return Rejection::no_onset;
        note_.contact.coordinate = onset_.coordinate() - note_.contact.feed * load_latency;
        if (note_time_ > 0)  // a clock ran
            note_.contact.time = std::max(0.0, note_time_ + note_age_ - onset_.ago() - load_latency);
        note_.contact.sigma = -note_.contact.feed * onset_.sigma();
        note_.contact.time_constant = onset_.time_constant();
        return Rejection::none;
    }

    // Accepts or rejects the noted contact, unless it is rejected already.
    Event judge(Rejection rejection, const Settings& settings) noexcept {
        ++counts_.contacts;
        const bool learning = cycle_.learning();
        const bool fresh = learning && cycle_.learnt() == 0;  // there is nothing to compare with yet
        if (!learning && !comparable(note_.setup)) return reject(Rejection::no_reference);
        return judge_comparable(rejection, fresh, settings);
    }

    Event judge_comparable(Rejection rejection, bool fresh, const Settings& settings) noexcept {
        const bool learning = cycle_.learning();
        const ContactReference* partner = cycle_.partner(note_.key);
        if (rejection != Rejection::none) return reject(rejection);
        if (steady_time_ < settings.limits.steady_time) return reject(Rejection::unsteady_feed);
        const Rejection reason = fresh      ? Rejection::none
                                 : !partner ? Rejection::unexpected
                                            : compare(*partner, settings);
        if (learning) cycle_.learn(note_, !fresh && reason == Rejection::none);
        if (reason != Rejection::none) return reject(reason);
        const double sigma = learning && fresh ? note_.contact.sigma : sigma_;
        if (learning) estimator_.learn(fresh ? 0 : growth_, sigma, fresh, settings.estimator());
        accept(fresh ? 0 : growth_);
        if (learning) return Event::contact;
        ++counts_.accepted;
        return Event::accepted;
    }

    bool comparable(const MachiningSetup& setup) const noexcept {
        return refusal_.compares() && cycle_.references().made_with(setup);
    }

    Rejection compare(const ContactReference& partner, const Settings& settings) noexcept {
        const Contact& now = note_.contact;
        const Rejection reason = comparison(settings.method, now, partner.contact, settings.limits);
        refusal_.compared(now, partner.contact, reason, settings.limits.feed_tolerance);
        if (reason != Rejection::none) return reason;
        growth_ = plumb::growth(settings.method, now, partner.contact);
        sigma_ = std::hypot(displacement_sigma(now, partner), feed_sigma(now, partner.contact));
        if (!(std::abs(growth_ - gate_.growth()) <= settings.limits.max_correction))
            return Rejection::too_large;
        const bool inside = std::abs(growth_ - gate_.growth()) <= gate_.spread(settings.gate);
        const bool admitted = gate_.admits(growth_, note_.key.tool, cycle_.number(), settings.gate);
        if (cycle_.learning()) return admitted ? Rejection::none : Rejection::beyond_gate;
        GrowthEstimator::Reading r = reading(partner, settings);
        r.admitted = admitted;
        r.confirmed = admitted && !inside;
        const GrowthEstimator::Verdict verdict = estimator_.judge(r, settings.estimator());
        if (verdict != GrowthEstimator::Verdict::withdrawn)
            agree(verdict == GrowthEstimator::Verdict::accepted);
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
        r.noise = std::hypot(std::max(note_.contact.sigma, partner.scatter),
                             feed_sigma(note_.contact, partner.contact));
        r.reference_sigma = own_sigma(partner, settings);
        r.applied_offset = note_.contact.applied_offset;
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

    void agree(bool agrees) noexcept {
        constexpr double part = 0.25;
        agreement_ += part * ((agrees ? 1 : 0) - agreement_);
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
        e.agreement = agreement_;
        e.predicts = settings.between.by_speed;
        e.load_valid = s.load_valid && lost(s) != Lost::load;
        e.barren = barren_;
        e.contradicted = estimator_.contradicted();
        e.program_event = estimator_.any(GrowthEstimator::Withdrawal::program);
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
        agreement_ = 1;
        barren_ = false;
    }

    void accept(double growth) noexcept {
        gate_.accept(growth);
        barren_ = false;
        barren_cycles_ = 0;
        rejected_before_ = counts_.rejected;
    }

    Event reject(Rejection reason) noexcept {
        ++(reason == Rejection::unexpected ? counts_.unexpected : counts_.rejected);
        rejection_ = reason;
        return Event::contact;
    }

    ApproachClock clock_;
    LoadContact detector_;
    ContactOnset onset_;
    ContactCycle cycle_;
    PlausibilityGate gate_;
    GrowthEstimator estimator_;
    GrowthAuthority authority_;
    double agreement_ = 1;  // of the last contacts, 0 to 1
    bool barren_ = false;   // since a cycle in which no contact counted
    double reference_sigma_ = 0;
    std::int32_t accepted_before_ = 0;  // when this cycle began
    FirstOrderLag speed_history_;
    bool was_running_ = false;
    bool approaching_ = false;
    Descent descent_;
    bool below_contact_ = false;
    ContactKey approach_;         // the present one, or the last
    std::int32_t operation_ = 0;  // in the last period
    MachiningSetup setup_;        // as the cycle began
    ReferenceRefusal refusal_;

    ContactReference note_;   // the last rise
    double note_age_ = 0;     // s
    double note_time_ = 0;    // s, of the clock then
    SteadyFeed feed_;         // of the approach
    double steady_time_ = 0;  // s before that rise
    Counts counts_;
    Rejection rejection_ = Rejection::none;
    double growth_ = 0;
    double sigma_ = 0;
    double step_ = 0;
    std::int32_t rejected_before_ = 0;  // when this cycle began, or at the last accepted contact
    std::int32_t barren_cycles_ = 0;
    LearningFault learning_fault_ = LearningFault::none;
};

}  // namespace plumb
