// SPDX-License-Identifier: GPL-2.0-or-later
// The growth of a spindle, by the contacts of a program, period by period.
//
// 1. A cycle begins or ends: ContactCycle learns from it, or compares with its reference.
// 2. ProgramOrigin sees a change of zero or tool length; its reason moves the references, or is asked for.
// 3. ContactFinder finds a contact; it is learned, or compared, and GrowthFilter judges it.
// 4. At events, and else each sixteenth period, the growth, its authority and its doubt are judged anew.
#pragma once

#include "components/compensation/thermal_displacement/contact.hpp"
#include "components/compensation/thermal_displacement/contact_cycle.hpp"
#include "components/compensation/thermal_displacement/contact_finder.hpp"
#include "components/compensation/thermal_displacement/growth_filter.hpp"
#include "components/math/blocks/edge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace plumb {

// Work offset and tool length, and when they change. A reason holds for a while after it was given, because
// the change may come late from another program.
//
// A zero and a tool length take in the growth at the moment when they are set, less the offset that is in
// force: the growth to come is lower by as much, unless they were corrected by it. Each keeps its own.
class ProgramOrigin {
public:
    static constexpr double patience = 1;  // s for which a reason holds

    struct Now {
        double work_offset = 0, tool_length = 0;  // mu
        std::int32_t tool = 0;
        OriginReason reason = OriginReason::none;  // that is being given
        double growth = 0, applied_offset = 0;     // mu
    };

    // One period of dt > 0, in s. A length of 0 is a tool without G43.
    void step(const Now& now, double dt) noexcept {
        given_ = now.reason != OriginReason::none && now.reason != now_.reason;
        waited_ = now.reason == OriginReason::none ? waited_ + dt : 0;
        if (now.reason != OriginReason::none) reason_ = now.reason;
        if (waited_ > patience) reason_ = OriginReason::none;
        before_ = now_.work_offset;
        offset_changed_ = known_ && differ(now.work_offset, before_);
        length_changed_ = known_ && now.tool == now_.tool && differ(now.tool_length, now_.tool_length) &&
                          now.tool_length != 0;
        if (offset_changed_) {
            take_in(0, now.work_offset, now);
            if (root_holds_) root_ = before_;
            root_holds_ = reason_ != OriginReason::none || !differ(now.work_offset, root_);
        }
        if (known_ && (now.tool != now_.tool || differ(now.tool_length, now_.tool_length)))
            take_in(now.tool, now.tool_length, now);
        now_ = now;
        known_ = true;
    }

    bool offset_changed() const noexcept { return offset_changed_; }  // in this period
    bool length_changed() const noexcept { return length_changed_; }  // of the tool in the spindle
    double offset_before() const noexcept { return before_; }         // mu
    double offset_root() const noexcept { return root_; }             // ... before changes without a reason

    bool reason_given() const noexcept { return given_; }  // in this period
    OriginReason reason() const noexcept { return reason_; }

    // Growth that this zero, or this length of a tool, has taken in, mu.
    double in_offset(double offset) const noexcept { return taken_in(0, offset); }
    double in_length(std::int32_t tool, double length) const noexcept { return taken_in(tool, length); }

    static bool differ(double a, double b) noexcept { return std::abs(a - b) > 1e-6; }  // mu

private:
    // A length of a tool, or with tool 0 a work offset.
    struct Set {
        std::int32_t tool = -1;        // none
        double value = 0, growth = 0;  // mu
    };
    const Set* find(std::int32_t tool, double value) const noexcept {
        const auto* its = std::find_if(sets_.begin(), sets_.end(), [&](const Set& each) {
            return each.tool == tool && !differ(each.value, value);
        });
        return its == sets_.end() ? nullptr : its;
    }
    // A value that comes back, such as G54 after G55, was not set anew.
    void take_in(std::int32_t tool, double value, const Now& now) noexcept {
        if (find(tool, value)) return;
        oldest_ = (oldest_ + 1) % sets_.size();
        sets_[oldest_] = {tool, value, now.growth - now.applied_offset};
    }
    double taken_in(std::int32_t tool, double value) const noexcept {
        const Set* its = find(tool, value);
        return its ? its->growth : 0;
    }

    Now now_;
    bool known_ = false, offset_changed_ = false, length_changed_ = false, given_ = false;
    OriginReason reason_ = OriginReason::none;
    bool root_holds_ = true;  // no change without a reason has followed it
    double waited_ = 0, before_ = 0, root_ = 0;
    std::array<Set, 64> sets_{};
    std::size_t oldest_ = 0;
};

// Measures the growth of a spindle cycle by cycle: finds the contacts, learns from a cycle or pairs them
// with the reference, and accepts contacts that can be compared and lie within the gate.
class GrowthByContact {
public:
    using Settings = DisplacementSettings;
    using Sample = ContactFinder::Sample;
    using Lost = ContactFinder::Lost;

    // The result of a period.
    enum class Event { none, contact, accepted };

    // One period of dt > 0, in s. The sample is judged. The settings must be valid.
    Event step(const Sample& s, const Settings& settings, double dt) noexcept {
        follow_cycle(s, settings);
        follow_origin(s, dt);
        waited_ += dt;
        const Event event = find(s, settings, dt);
        const std::int32_t state = 4 * cycle_.running() + 2 * s.load_lost + tally_.barren();
        due_ = ++periods_ >= seldom || waited_ >= longest_wait || event != Event::none ||
               std::exchange(state_, state) != state;
        if (due_) apply(s, event, settings);
        return event;
    }

    // Growth, authority and doubt were judged in this period: at an event, and else each sixteenth period.
    bool due() const noexcept { return due_; }

    const ContactCycle& cycle() const noexcept { return cycle_; }
    const ReferenceRefusal& refusal() const noexcept { return refusal_; }
    const LoadContact& detector() const noexcept { return finder_.detector(); }
    bool in_work() const noexcept { return finder_.in_work(); }  // see there

    // The growth is known to half of the narrowest gate at best.
    bool uncertain(const Settings& settings) const noexcept {
        return !known() || filter_.sigma(settings) > 0.5 * settings.floor;
    }
    const CycleTally& tally() const noexcept { return tally_; }

    // The growth may be applied: there is a reference, and it is not refused. While another one is learned,
    // the growth that is known stays in force.
    bool applicable() const noexcept {
        return cycle_.rows() > 0 && refusal_.reason() == Refusal::none &&
               (refusal_.compares() || !cycle_.running());
    }

    // The last contact, even a rejected one.
    const Contact& contact() const noexcept { return finder_.found().contact; }
    const ContactKey& contact_key() const noexcept { return finder_.found().key; }

    // By the last contact that could be compared, in mu.
    double growth() const noexcept { return growth_; }
    double sigma() const noexcept { return sigma_; }

    bool known() const noexcept { return filter_.known(); }
    const GrowthFilter& filter() const noexcept { return filter_; }

    // The answers to a shift, see GrowthFilter. Without a shift they change nothing.
    void shift_is_growth() noexcept { filter_.shift_is_growth(); }
    void shift_is_not_growth() noexcept {
        if (filter_.shift_size() == 0 || cycle_.learning()) return;
        for (std::int32_t i = 0; i < asked_references().size(); ++i)
            cycle_.displace(filter_.program(), i, filter_.displaced(i, asked_references()[i].contact.feed));
        filter_.shift_is_corrected();
    }

    // See GrowthFilter. A fixed surface answers a shift as an operator does.
    SurfaceCheck check(double height, std::int32_t tool, const Settings& settings) noexcept {
        if (cycle_.learning()) return SurfaceCheck::unknown;
        bool asked = false;
        for (std::int32_t i = 0; i < asked_references().size(); ++i)
            asked |= asked_references()[i].key.tool == tool && filter_.asks_of_tool(i);
        const SurfaceCheck found = filter_.check(height, tool, asked, settings);
        if (found == SurfaceCheck::is_no_growth) shift_is_not_growth();
        return found;
    }

    // The tool that is asked about alone; 0 for none.
    std::int32_t asked_tool(const Settings& settings) const noexcept {
        if (filter_.shift(settings) != Shift::one_tool) return 0;
        const ContactReferences& references = asked_references();
        for (std::int32_t i = 0; i < references.size(); ++i)
            if (filter_.displaced(i, references[i].contact.feed) == filter_.shift_size())
                return references[i].key.tool;
        return 0;
    }

    // Change of the program's origin that nobody has explained, in mu; 0 for none. Until then the contacts
    // count as if the program had another depth.
    double origin_change() const noexcept { return asked_.change; }

    // Nothing was learned from the first part of this program that was to be learned from: the next one is.
    bool learns_again(const MachiningSetup& setup) const noexcept { return again_ && setup == setup_; }

    double reference_sigma() const noexcept { return reference_sigma_; }  // mu, of all gauges together
    // The reference alone makes the error to expect about as large as the work tolerates.
    bool shows_z_poorly(const Settings& settings) const noexcept {
        return reference_sigma_ > 0.7 * settings.work_tolerance;
    }
    // Growth to expect within the learning cycle, in mu: a cut is compared with one at another time of it.
    double learning_growth() const noexcept { return learning_growth_; }

    // See ReferenceRefusal.
    void acknowledge() noexcept { refusal_.acknowledge(cycle_); }

    // See ContactCycle. The growth is unknown then.
    bool restore(const ContactReference& reference) noexcept {
        if (!cycle_.restore(reference)) return false;
        filter_.have_references(cycle_.program(), reference.common_sigma);
        forget_growth();
        return true;
    }
    void forget() noexcept {
        forget_growth();
        cycle_.forget();
    }

private:
    static constexpr std::int32_t seldom = 16;    // periods
    static constexpr double longest_wait = 0.05;  // s

    // Those that a question is about; another program may run.
    const ContactReferences& asked_references() const noexcept {
        return cycle_.references_of(filter_.program());
    }

    // The growth as it is now, before its contact is judged.
    void predict(const Sample& s, const Settings& settings) noexcept {
        if (waited_ <= 0) return;
        machine_.speed = s.speed;
        machine_.temperature = s.temperature;
        machine_.temperature_valid = s.temperature_valid;
        filter_.predict(machine_, settings, waited_);
        since_applied_ += std::exchange(waited_, 0);
        periods_ = 0;
    }

    void apply(const Sample& s, Event event, const Settings& settings) noexcept {
        predict(s, settings);
        machine_.reference_sigma = reference_sigma_;
        machine_.load_valid = !s.load_lost;
        machine_.barren = tally_.barren();
        machine_.in_cycle = cycle_.running();
        machine_.accepted = event == Event::accepted;
        machine_.origin = asked_.change != 0;
        filter_.apply(machine_, settings, std::exchange(since_applied_, 0));
    }

    Event find(const Sample& s, const Settings& settings, double dt) noexcept {
        if (!s.complete || !s.learn || !(s.setup == setup_)) cycle_.spoil();
        step_ = s.step;
        const auto found = finder_.step(s, cycle_, settings, dt);
        if (rose_again_.rises(finder_.detector().rose_again())) cycle_.doubt(finder_.found().key);
        switch (found) {
            case ContactFinder::Found::contact: predict(s, settings); return judge(Rejection::none, settings);
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
        if (!cycle_.running()) refusal_.look(cycle_, s.setup);
        if (cycle_.running() && !(s.enable && s.cycle_running)) {
            const bool complete = s.enable && s.cycle_complete;
            CycleTally::Cycle its;
            its.learning = cycle_.learning();
            its.compared = refusal_.compares();
            its.complete = s.cycle_complete;
            its.enabled = s.enable;
            if (finder_.end()) cycle_.spoil();
            const ContactCycle::Ended ended =
                cycle_.end(complete, settings.method(), settings.reference_cycles, settings.floor);
            its.new_reference = its.learning && ended.fault == LearningFault::none && cycle_.learnt() == 0;
            its.missed = ended.missed;
            its.fault = ended.fault;
            if (its.new_reference) {
                if (counts_from_here_) {
                    filter_.begin_at(filter_.growth() - origin_growth_, judge_references(settings), settings);
                    filter_.have_references(cycle_.program(), 0);
                } else {
                    filter_.learned_by_growth(cycle_.program(), settings);
                }
                cycle_.share(filter_.common_sigma(cycle_.program()));
                forget_question();
                if (counts_from_here_) learning_growth_ = std::abs(usual_growth(settings) - usual_growth_);
            }
            reference_sigma_ = judge_references(settings);
            refusal_.end(complete && !its.learning, cycle_);
            again_ = may_pass(its.fault) && !again_ && !cycle_.references().made_with(setup_);
            tally_.end(its);
        }
        if (s.enable && starts) {
            cycle_.begin(s.learn, s.setup);
            if (s.learn && cycle_.learnt() == 0) {
                counts_from_here_ = !filter_.known_within(settings.hold_time);
                origin_growth_ = learnt_contacts_ = 0;
            }
            if (cycle_.program() >= 0) filter_.use(cycle_.program());
            refusal_.begin(cycle_, s.setup, s.learn);
            finder_.begin(settings.program_clock);
            tally_.begin();
            reference_sigma_ = judge_references(settings);
            usual_growth_ = usual_growth(settings);
            setup_ = s.setup;
        }
    }

    // A reason moves the references with the origin, or lets them go to another depth.
    void follow_origin(const Sample& s, double dt) noexcept {
        if (s.lost == Lost::position || s.lost == Lost::offset) return;
        const double grown = known() ? filter_.growth() : 0;
        origin_.step({s.work_offset, s.tool_length, s.tool, s.origin_reason, grown, s.applied_offset}, dt);
        const OriginReason reason = origin_.reason();
        if (reason == OriginReason::none) return;
        if (origin_.reason_given() && asked_.change != 0) {
            const bool echo = !asked_.after_shift && filter_.shift_size() != 0;
            explain(reason);
            if (echo) filter_.shift_is_corrected();
        }
        if (origin_.offset_changed()) {
            move_zero(origin_.offset_before(), s.work_offset, reason, 0);
            // A zero replaces changes before it, whatever their reason was.
            if (reason == OriginReason::zero) move_zero(origin_.offset_root(), s.work_offset, reason, 0);
        }
        if (origin_.length_changed()) measure_tool(s.tool, s.tool_length, reason, 0);
    }

    // The references of a work offset get a new one, and with a new zero the growth in it is counted no more.
    void move_zero(double before, double now, OriginReason reason, double growth) noexcept {
        cycle_.each([&](ContactReference& its) noexcept {
            if (!ProgramOrigin::differ(its.contact.work_offset, before))
                its.contact.have_origin(now, its.contact.tool_length, reason != OriginReason::depth);
        });
        if (reason == OriginReason::by_hand) growth = now - before;
        if (known() && reason != OriginReason::depth && growth != 0) filter_.displace(-growth);
    }

    // A correction of growth in the length of one tool is another depth: the others do not have it.
    void measure_tool(std::int32_t tool, double length, OriginReason reason, double growth) noexcept {
        cycle_.each([&](ContactReference& its) noexcept {
            if (its.key.tool != tool) return;
            its.contact.have_origin(its.contact.work_offset, length, reason == OriginReason::zero);
            if (reason == OriginReason::zero) its.contact.coordinate -= growth;
        });
    }

    // Answers the question of the origin.
    void explain(OriginReason reason) noexcept {
        const Asked its = asked_;
        forget_question();
        if (ProgramOrigin::differ(its.now.work_offset, its.before.work_offset))
            move_zero(its.before.work_offset, its.now.work_offset, reason, its.in_offset);
        if (ProgramOrigin::differ(its.now.tool_length, its.before.tool_length))
            measure_tool(its.tool, its.now.tool_length, reason, its.in_length);
    }
    void forget_question() noexcept {
        asked_ = {};
        evidence_ = {};
    }

    // The contact has another origin than its reference, and nobody has said why. Contacts themselves show
    // whether the work has moved with the zero, or the tool has another length. If not, it is asked. Until
    // they have shown it both may be, and the contact is less certain by that.
    void compare_origins(const ContactReference& partner, const Settings& settings) noexcept {
        const Contact &now = finder_.found().contact, &before = partner.contact;
        const double change = now.origin_since(before);
        if (!(std::abs(change) > smallest_change)) {
            if (asked_.change != 0 && partner.key.tool == asked_.tool) forget_question();
            return;
        }
        if (before.work_offset == 0 && before.tool_length == 0) {  // a record of before the origin was kept
            cycle_.each([&](ContactReference& its) noexcept {
                if (!(its.key == partner.key)) return;
                its.contact.work_offset = now.work_offset;
                its.contact.tool_length = now.tool_length;
            });
            return;
        }
        const double in_program = plumb::growth(settings.method(), now, before);
        const bool zero = ProgramOrigin::differ(now.work_offset, before.work_offset);
        const std::int32_t tool = partner.key.tool;
        const GrowthFilter::Reading r = reading(partner, settings);
        const auto expected = filter_.expected(r, settings);
        const double left_out = filter_.displaced(r.gauge, r.feed);
        const bool asked =
            left_out != 0 && (zero ? filter_.probability() > 0 : filter_.asks_of_tool(r.gauge));
        if (asked && std::abs(left_out) > 3 * expected.sigma &&
            std::abs(in_program - (expected.mean - left_out)) < 3 * expected.sigma) {
            // What had shifted was measured anew.
            asked_ = {change, now, before, tool};
            explain(OriginReason::zero);
            filter_.shift_is_corrected();
            return;
        }
        const double in_offset = origin_.in_offset(now.work_offset);
        const double in_length = origin_.in_length(tool, now.tool_length);
        const double taken_in = zero ? in_offset : in_length;
        const double moved = (in_program - expected.mean) / expected.sigma;
        const double with_it = moved + taken_in / expected.sigma;
        const double stood = (in_program + change - expected.mean) / expected.sigma;
        const bool outside = std::abs(moved) < std::abs(with_it);  // measured where no growth is
        const double nearest = outside ? moved : with_it;
        Evidence& its = evidence(change, zero ? 0 : tool);
        if (std::min(std::abs(nearest), std::abs(stood)) < 3) {
            its.moved += stood * stood - nearest * nearest;
            ++its.contacts;
        }
        const bool decided = its.contacts >= most_contacts || !(its.moved < decisive);
        if (its.moved > 0 && !decided) {
            unmoved_ = 1 / (1 + std::exp(0.5 * its.moved));
            return;
        }
        const bool after_shift = asked_.change != 0 ? asked_.after_shift : filter_.shift_size() != 0;
        asked_ = {change, now, before, tool, in_offset, in_length, after_shift};
        unmoved_ = 1;
        if (its.moved < decisive || !(std::abs(nearest) < 3)) return;
        if (outside) asked_.in_offset = asked_.in_length = 0;
        explain(OriginReason::zero);
    }

    // Of a change of the zero, with tool 0, or of the length of a tool.
    struct Evidence {
        double change = 0;
        std::int32_t tool = 0;
        double moved =
            0;  // twice the logarithm of the ratio of likelihoods, that it has moved to that it stands
        std::int32_t contacts = 0;
    };
    Evidence& evidence(double change, std::int32_t tool) noexcept {
        for (Evidence& its : evidence_)
            if (its.tool == tool && !ProgramOrigin::differ(its.change, change)) return its;
        next_ = (next_ + 1) % evidence_.size();
        return evidence_[next_] = {change, tool, measured};
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
        if (finder_.steady_time() < settings.steady_time) return reject(Rejection::unsteady_feed);
        if (learning && lacks_clock(settings.method(), finder_.found().contact)) {
            cycle_.lack_clock();
            return reject(Rejection::no_clock);
        }
        if (std::abs(finder_.misplaced()) > harmless(settings)) {
            if (learning) cycle_.doubt(finder_.found().key);
            return reject(Rejection::rises_twice);
        }
        if (learning && !counts_from_here_) follow_former(settings);
        const Rejection reason = fresh      ? Rejection::none
                                 : !partner ? Rejection::unexpected
                                            : compare(*partner, settings);
        if (learning) {
            ContactReference learnt = finder_.found();
            if (!counts_from_here_) learnt.contact.displace(-filter_.growth());
            cycle_.learn(learnt, !fresh && reason == Rejection::none);
        }
        if (reason != Rejection::none) return reject(reason);
        if (fresh) sigma_ = finder_.found().contact.sigma;
        if (learning) origin_growth_ += (filter_.growth() - origin_growth_) / ++learnt_contacts_;
        tally_.accept(learning);
        return learning ? Event::contact : Event::accepted;
    }

    // mu, a displacement of a contact that matters little.
    static double harmless(const Settings& settings) noexcept { return settings.floor / 5; }

    bool comparable(const MachiningSetup& setup) const noexcept {
        return refusal_.compares() && cycle_.references().made_with(setup);
    }

    Rejection compare(const ContactReference& partner, const Settings& settings) noexcept {
        const Contact& now = finder_.found().contact;
        const Rejection reason = comparison(settings.method(), now, partner.contact, settings);
        refusal_.compared(reason);
        if (reason != Rejection::none) return reason;
        if (rises_unlike(now, partner.contact, partner.cycles, harmless(settings)))
            return Rejection::unlike_reference;
        unmoved_ = unexplained_ = 0;
        if (!cycle_.learning()) compare_origins(partner, settings);
        const double change = now.origin_since(partner.contact);
        growth_ = plumb::growth(settings.method(), now, partner.contact) + unmoved_ * change;
        unexplained_ = std::abs(change) * std::sqrt(unmoved_ * (1 - unmoved_));
        sigma_ = std::hypot(displacement_sigma(now, partner), feed_sigma(now, partner.contact), unexplained_);
        const GrowthFilter::Reading r = reading(partner, settings);
        if (!cycle_.learning()) return filter_.judge(r, settings);
        return filter_.compare(r.growth + (counts_from_here_ ? origin_growth_ : 0), settings);
    }

    // A program is learned again: what fits its former reference keeps the growth known.
    void follow_former(const Settings& settings) noexcept {
        const std::int32_t i = cycle_.references().find(finder_.found().key);
        if (i < 0) return;
        const ContactReference& former = cycle_.references()[i];
        const Contact& now = finder_.found().contact;
        if (comparison(settings.method(), now, former.contact, settings) != Rejection::none ||
            rises_unlike(now, former.contact, former.cycles, harmless(settings)) ||
            std::abs(now.origin_since(former.contact)) > smallest_change)
            return;
        growth_ = plumb::growth(settings.method(), now, former.contact);
        if (std::abs(growth_ - filter_.growth()) <= filter_.gate(settings))
            filter_.judge(reading(former, settings), settings);
    }

    GrowthFilter::Reading reading(const ContactReference& partner, const Settings& settings) const noexcept {
        const ContactReferences& references = cycle_.references();
        GrowthFilter::Reading r;
        r.growth = growth_;
        r.noise = std::hypot(std::max(finder_.found().contact.sigma, partner.scatter),
                             feed_sigma(finder_.found().contact, partner.contact), unexplained_);
        r.reference_sigma = own_sigma(partner, settings);
        r.step = step_;
        r.feed = finder_.found().contact.feed;
        r.gauge = references.find(partner.key);
        r.cycle = cycle_.number();
        for (std::int32_t i = 0; i < references.size(); ++i) {
            if (references[i].key.tool == partner.key.tool)
                r.of_tool |= std::uint64_t{1} << i;
            else
                r.other_tools |= !filter_.withdrawn(i);
        }
        return r;
    }

    double usual_growth(const Settings& settings) const noexcept { return filter_.usual_growth(settings); }

    static double own_sigma(const ContactReference& reference, const Settings& settings) noexcept {
        const double scatter = std::max(reference.scatter, settings.repeatability);
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

    void forget_growth() noexcept {
        again_ = false;
        forget_question();
        filter_.forget();
        tally_.forget();
    }

    Event reject(Rejection reason) noexcept {
        tally_.reject(reason);
        return Event::contact;
    }

    static constexpr double smallest_change = 1e-5;  // mu, of an origin
    // Twice the logarithms of ratios of likelihoods: 150 to 1, and 7 to 1 for a measurement before any
    // contact.
    static constexpr double decisive = 10, measured = 4;
    static constexpr std::int32_t most_contacts = 4;  // then the likelier one is taken

    // A change of the origin without a reason: at a contact of this tool, and at its reference.
    struct Asked {
        double change = 0;  // mu
        Contact now, before;
        std::int32_t tool = 0;
        double in_offset = 0, in_length = 0;  // mu, growth that it has taken in
        bool after_shift = false;             // contacts had moved before
    };

    ContactFinder finder_;
    ContactCycle cycle_;
    ProgramOrigin origin_;
    Asked asked_;
    std::array<Evidence, 8> evidence_{};
    std::size_t next_ = 0;
    double unmoved_ = 0, unexplained_ = 0;  // of this contact: probability, and mu
    GrowthFilter filter_;
    CycleTally tally_;
    double reference_sigma_ = 0;
    bool counts_from_here_ = false;  // the growth: it was not known when learning began
    double origin_growth_ = 0;       // mu, at the contacts that were learned since: the mean
    std::int32_t learnt_contacts_ = 0;
    double usual_growth_ = 0, learning_growth_ = 0;  // as this cycle began, and within the learning cycle
    Edge running_, rose_again_;
    MachiningSetup setup_;  // as the cycle began
    ReferenceRefusal refusal_;
    bool again_ = false;  // learns from the next cycle without being asked

    double growth_ = 0;
    double sigma_ = 0;
    double step_ = 0;
    GrowthFilter::Machine machine_;
    double waited_ = 0, since_applied_ = 0;  // s since growth was predicted, and applied
    std::int32_t periods_ = 0;               // since it was predicted
    bool due_ = false;
    std::int32_t state_ = 0;  // of cycle and load, in the last period
};

}  // namespace plumb
