// SPDX-License-Identifier: GPL-2.0-or-later
// The contacts of a program, cycle by cycle.
//
// 1. ContactCycle pairs each contact with its reference, or learns it.
// 2. LearningCheck refuses contacts that are no gauge, as a learning cycle ends.
// 3. ReferenceRefusal judges the reference as a whole, as a cycle begins and ends.
// 4. CycleTally counts what came of the contacts.
#pragma once

#include "components/compensation/thermal_displacement/contact.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace plumb {

// Why nothing was learned from a cycle.
enum class LearningFault : std::int32_t {
    none,
    aborted,
    disturbed,
    no_contact,
    poor,
    disagree,
    no_clock,
    rises_twice
};

constexpr const char* sentence(LearningFault fault) {
    switch (fault) {
        case LearningFault::aborted: return "The cycle was not complete.";
        case LearningFault::disturbed: return "A signal was invalid, or learn, program or tools changed.";
        case LearningFault::no_contact: return "No contact was found.";
        case LearningFault::poor:
            return "This load shows Z only to about {displacement-sigma}. Leave it on Measure only, or learn "
                   "from a steady plunge, not from interrupted milling.";
        case LearningFault::disagree:
            return "Contacts of one tool disagree in how the load rises: learn from another cycle.";
        default: return nullptr;  // no_clock, rises_twice: as Rejection
    }
}

// Another part of the same program may cure it.
constexpr bool may_pass(LearningFault fault) {
    return fault != LearningFault::none && fault != LearningFault::poor && fault != LearningFault::no_clock;
}

// Which contacts of a cycle are not learned: those with a sigma beyond `largest`, and those whose sigma or
// time constant is more than three times that of the others of their tool, or less than a third of it.
// Contacts of one tool see the same drive, so one of them met something else, or noise.
class LearningCheck {
public:
    LearningCheck(const ContactReferences& contacts, double largest) noexcept {
        for (std::int32_t i = 0; i < contacts.size(); ++i) {
            const Contact& contact = contacts[i].contact;
            const bool poor = contact.sigma > largest;
            const bool odd = differs(contacts, i, &Contact::time_constant, true) ||
                             differs(contacts, i, &Contact::sigma, false);
            refused_[i] = poor || odd;
            disagree_ |= odd && !poor;
        }
    }

    bool refuses(std::int32_t i) const noexcept { return refused_[i]; }
    bool disagree() const noexcept { return disagree_; }

private:
    // From most of its tool; of two contacts each differs from the other.
    static bool differs(const ContactReferences& contacts, std::int32_t i, double Contact::*value,
                        bool both_ways) noexcept {
        constexpr double most = 3;
        const double own = contacts[i].contact.*value;
        std::int32_t alike = 0, different = 0;
        for (std::int32_t j = 0; j < contacts.size(); ++j) {
            if (j == i || !(contacts[j].key.tool == contacts[i].key.tool)) continue;
            const double other = contacts[j].contact.*value;
            ++(own > most * other || (both_ways && other > most * own) ? different : alike);
        }
        return different > alike;
    }

    std::array<bool, ContactReferences::capacity> refused_{};
    bool disagree_ = false;
};

// One cycle of a program after the other: numbers the approaches, learns a reference from one cycle or
// several consecutive ones, or finds the partners of its contacts in the reference. Pairing goes by
// operation, tool and occurrence: the n-th approach of that tool in that operation, whether or not the ones
// before met the work, so that a missed contact shifts no other one.
//
// A mean of several cycles keeps the contacts that all of them had and that could be compared; an
// occasional contact is no gauge. An incomplete cycle counts for nothing and takes nothing away. A cycle of
// another setup, or without a contact that can be compared with the mean, begins a new mean; a cycle
// without learning ends it.
class ContactCycle {
public:
    bool running() const noexcept { return running_; }
    bool learning() const noexcept { return running_ && learning_; }
    std::int32_t number() const noexcept { return number_; }  // of this cycle, counted from 1
    std::int32_t learnt() const noexcept { return learnt_; }  // cycles in the mean that is still incomplete

    // Of the program of this cycle, or of the last one; none if that has none, and program() is -1.
    const ContactReferences& references() const noexcept { return references_of(program_); }
    const ContactReferences& references_of(std::int32_t program) const noexcept {
        return program < 0 ? nothing : lists_[list_[program]];
    }
    std::int32_t program() const noexcept { return program_; }
    bool has(const MachiningSetup& setup) const noexcept { return find(setup) >= 0; }
    bool has_program(std::int32_t number) const noexcept {
        for (const std::int32_t i : list_)
            if (lists_[i].size() > 0 && lists_[i][0].setup.program == number) return true;
        return false;
    }

    // All references, of all programs: 0 ≤ i < rows().
    std::int32_t rows() const noexcept {
        std::int32_t sum = 0;
        for (const std::int32_t i : list_) sum += lists_[i].size();
        return sum;
    }
    const ContactReference& row(std::int32_t i) const noexcept {
        std::int32_t program = 0;
        for (; i >= lists_[list_[program]].size(); ++program) i -= lists_[list_[program]].size();
        return lists_[list_[program]][i];
    }

    void begin(bool learn, const MachiningSetup& setup) noexcept {
        running_ = true;
        learning_ = learn;
        setup_ = setup;
        program_ = find(setup);
        spoilt_ = clockless_ = rose_twice_ = false;
        doubted_ = {};
        ++number_;
        if (program_ >= 0) begun_[program_] = number_;
        kinds_ = 0;
        met_.fill(false);
        draft().clear();
        if (!learn || !mean().made_with(setup)) drop_mean();
    }

    struct Ended {
        LearningFault fault;  // of a learning cycle
        std::int32_t missed;  // contacts with a partner that did not come
    };

    // The cycle has ended. Only a complete and unspoilt learning cycle with a contact is learned from, and
    // the last of `wanted` such cycles gives a reference. It replaces the reference of the same program, or
    // of the program that has not run for the longest time; until then the former one stays. The number of
    // missed contacts is 0 for an incomplete cycle. Contacts that LearningCheck refuses are not learned, and
    // another cycle is asked for; if they disagree there too, the others are learned alone.
    Ended end(bool complete, Method method, std::int32_t wanted, double largest_sigma) noexcept {
        Ended ended{learning() ? judge_draft(complete, largest_sigma) : LearningFault::none, 0};
        const bool learnt = learning() && ended.fault == LearningFault::none;
        if (complete)
            for (std::int32_t i = 0; i < partners().size(); ++i) ended.missed += !met_[i];
        running_ = false;
        if (!learnt) return ended;
        if (!take_in_draft(method)) {
            std::swap(mean_, draft_);
            learnt_ = 0;
        }
        if (++learnt_ >= wanted) {
            program_ = place(setup_);
            begun_[program_] = number_;
            std::swap(list_[program_], mean_);
            drop_mean();
        }
        return ended;
    }

    // The key of the contact to which the approach that begins now may lead. If there are too many kinds,
    // its occurrence is 0, which has no partner and cannot be learned.
    ContactKey approach(std::int32_t operation, std::int32_t tool) noexcept {
        for (std::int32_t i = 0; i < kinds_; ++i) {
            if (last_[i].operation != operation || last_[i].tool != tool) continue;
            ++last_[i].occurrence;
            return last_[i];
        }
        if (kinds_ == most_kinds) return {operation, tool, 0};
        return last_[kinds_++] = {operation, tool, 1};
    }

    // The reference for a contact of now, or the running mean while learning; null if there is none.
    const ContactReference* partner(const ContactKey& key) noexcept {
        const std::int32_t i = partners().find(key);
        if (i < 0) return nullptr;
        met_[i] = true;
        return &partners()[i];
    }

    // The same for a contact that may still come.
    const ContactReference* expected(const ContactKey& key) const noexcept {
        const std::int32_t i = partners().find(key);
        return i < 0 ? nullptr : &partners()[i];
    }

    // The least and the largest time constant of the contacts of a tool that may come, in s.
    std::pair<double, double> time_constants(std::int32_t tool) const noexcept {
        std::pair<double, double> range{1e9, 0};
        for (std::int32_t i = 0; i < partners().size(); ++i) {
            if (partners()[i].key.tool != tool) continue;
            const double its = partners()[i].contact.time_constant;
            range = {std::min(range.first, its), std::max(range.second, its)};
        }
        return range;
    }

    // While learning. `agrees`: the contact could be compared with its partner.
    void learn(const ContactReference& reference, bool agrees) noexcept {
        if (reference.key == doubted_) return;
        spoilt_ |= reference.key.occurrence < 1 || !draft().add(reference);
        if (!spoilt_) agrees_[draft().size() - 1] = agrees ? mean().find(reference.key) : -1;
    }
    // While learning: this contact may be an event of the program, and is not learned, even if its fit comes
    // later.
    void doubt(const ContactKey& key) noexcept {
        doubted_ = key;
        rose_twice_ = true;
        if (learning()) draft().retain([&](std::int32_t i) { return !(draft()[i].key == key); });
    }
    void spoil() noexcept { spoilt_ = true; }          // nothing can be learned from this cycle
    void lack_clock() noexcept { clockless_ = true; }  // a contact without a time is not learned

    // A reference of a program was off by a distance, in mu: 0 ≤ i < references_of(program).size().
    void displace(std::int32_t program, std::int32_t i, double distance) noexcept {
        lists_[list_[program]][i].contact.displace(distance);
    }
    void refuse_feed(bool refused) noexcept {
        if (program_ >= 0) lists_[list_[program_]].feed_differed = refused;
    }
    // All of this program share an error, in mu.
    void share(double sigma) noexcept {
        ContactReferences& its = lists_[list_[program_]];
        for (std::int32_t i = 0; i < its.size(); ++i) its[i].common_sigma = sigma;
    }

    // Calls change(ContactReference&) for each contact that is known, of the present cycle too.
    template <class Change>
    void each(const Change& change) noexcept {
        for (ContactReferences& list : lists_)
            for (std::int32_t i = 0; i < list.size(); ++i) change(list[i]);
    }

    // From a file. Refused while learning, or if the reference is implausible, one too many, double, or of
    // one program too many.
    bool restore(const ContactReference& reference) noexcept {
        if (learning() || !reference.valid()) return false;
        const std::int32_t program = place(reference.setup);
        ContactReferences& its = lists_[list_[program]];
        if ((its.size() > 0 && !its.made_with(reference.setup)) || !its.add(reference)) return false;
        program_ = program;
        return true;
    }
    void forget() noexcept {
        for (const std::int32_t i : list_) lists_[i].clear();
        program_ = -1;
        drop_mean();
        agrees_.fill(-1);
    }

private:
    LearningFault judge_draft(bool complete, double largest_sigma) noexcept {
        if (!complete) return LearningFault::aborted;
        if (spoilt_) return LearningFault::disturbed;
        if (rose_twice_) return LearningFault::rises_twice;
        if (draft().size() == 0) return clockless_ ? LearningFault::no_clock : LearningFault::no_contact;
        const LearningCheck check(draft(), largest_sigma);
        std::int32_t kept = 0;
        for (std::int32_t i = 0; i < draft().size(); ++i)
            if (!check.refuses(i)) agrees_[kept++] = agrees_[i];
        draft().retain([&](std::int32_t i) { return !check.refuses(i); });
        if (check.disagree() && !std::exchange(disagreed_, true)) return LearningFault::disagree;
        if (kept == 0) return check.disagree() ? LearningFault::disagree : LearningFault::poor;
        disagreed_ = false;
        return LearningFault::none;
    }

    static constexpr std::int32_t programs = ContactReferences::most_programs;
    static inline const ContactReferences nothing;
    static constexpr std::int32_t most_kinds = 4 * ContactReferences::capacity;  // not each meets the work

    ContactReferences& mean() noexcept { return lists_[mean_]; }
    ContactReferences& draft() noexcept { return lists_[draft_]; }
    const ContactReferences& partners() const noexcept { return learning_ ? lists_[mean_] : references(); }

    std::int32_t find(const MachiningSetup& setup) const noexcept {
        const auto* const its = std::find_if(list_.begin(), list_.end(),
                                             [&](std::int32_t i) { return lists_[i].made_with(setup); });
        return its == list_.end() ? -1 : static_cast<std::int32_t>(its - list_.begin());
    }
    // Of a program that may be new: a free one, or the one that has not run for the longest time.
    std::int32_t place(const MachiningSetup& setup) const noexcept {
        const auto age = [&](std::int32_t program) {
            const ContactReferences& its = lists_[list_[program]];
            return its.made_with(setup) ? -2 : its.size() == 0 ? -1 : begun_[program];
        };
        std::int32_t oldest = 0;
        for (std::int32_t i = 1; i < programs; ++i)
            if (age(i) < age(oldest)) oldest = i;
        return oldest;
    }

    void drop_mean() noexcept {
        mean().clear();
        learnt_ = 0;
    }

    // False, without a change, if no contact of the cycle agrees with the mean.
    bool take_in_draft(Method method) noexcept {
        std::array<bool, ContactReferences::capacity> taken{};
        bool any = false;
        for (std::int32_t i = 0; i < draft().size(); ++i) {
            if (agrees_[i] < 0) continue;
            take_in(method, mean()[agrees_[i]], draft()[i]);
            taken[agrees_[i]] = any = true;
        }
        if (any) mean().retain([&](std::int32_t i) { return taken[i]; });
        return any;
    }

    std::array<ContactReferences, programs + 2> lists_;
    std::array<std::int32_t, programs> list_{0, 1, 2, 3, 4, 5, 6, 7};  // of each program
    std::int32_t mean_ = programs, draft_ = programs + 1;  // of them; the draft is of the present cycle
    std::array<std::int32_t, programs> begun_{};           // number of the last cycle of each program
    std::int32_t program_ = -1;
    MachiningSetup setup_;  // of the cycle
    bool running_ = false;
    bool learning_ = false;
    bool spoilt_ = false;
    bool clockless_ = false;
    bool rose_twice_ = false;  // the load, in an approach
    ContactKey doubted_;       // the last of these
    bool disagreed_ = false;   // contacts of the last learning cycle, among each other
    std::int32_t number_ = 0;
    std::int32_t learnt_ = 0;
    std::int32_t kinds_ = 0;                                        // of approaches in this cycle
    std::array<ContactKey, most_kinds> last_;                       // the last one of each kind
    std::array<bool, ContactReferences::capacity> met_{};           // by index of the partner
    std::array<std::int32_t, ContactReferences::capacity> agrees_;  // index in the mean by that in the draft
};

// Why a program is not compared.
enum class Refusal : std::int32_t { none, program, tool_set, feed };

constexpr const char* sentence(Refusal refusal) {
    switch (refusal) {
        case Refusal::program: return "No reference is of this program.";
        case Refusal::tool_set: return "The reference of this program is of another set of tools.";
        default: return nullptr;  // feed: as Rejection::feed_differs
    }
}

// Whether the references may be used, judged as a cycle begins. If all contacts of a cycle came with another
// feed or override, the references of its program are refused until somebody acknowledges or learns again.
class ReferenceRefusal {
public:
    Refusal reason() const noexcept { return reason_; }
    bool compares() const noexcept { return compares_; }  // in this cycle

    void begin(const ContactCycle& cycle, const MachiningSetup& setup, bool learn) noexcept {
        reason_ = learn || cycle.rows() == 0         ? Refusal::none
                  : cycle.references().feed_differed ? Refusal::feed
                  : cycle.has(setup)                 ? Refusal::none
                  : cycle.has_program(setup.program) ? Refusal::tool_set
                                                     : Refusal::program;
        compares_ = reason_ == Refusal::none;
        agreed_ = differs_ = false;
    }

    // Between two cycles: the program may be back.
    void look(const ContactCycle& cycle, const MachiningSetup& setup) noexcept {
        const bool of_setup = reason_ == Refusal::program || reason_ == Refusal::tool_set;
        if (of_setup && cycle.has(setup)) reason_ = Refusal::none;
    }

    // A contact of this cycle was compared with its partner, with this outcome.
    void compared(Rejection outcome) noexcept {
        (outcome == Rejection::feed_differs ? differs_ : agreed_) = true;
    }

    // Not of a learning cycle.
    void end(bool complete, ContactCycle& cycle) noexcept {
        if (compares_ && complete && !agreed_ && differs_) {
            reason_ = Refusal::feed;
            cycle.refuse_feed(true);
        }
        compares_ = false;
    }

    void acknowledge(ContactCycle& cycle) noexcept {
        if (reason_ == Refusal::feed) cycle.refuse_feed(false);
        reason_ = Refusal::none;
    }

private:
    Refusal reason_ = Refusal::none;
    bool agreed_ = false, differs_ = false;  // a contact of this cycle, in feed and override
    bool compares_ = false;
};

// Counts contacts from cycle to cycle: accepted ones, rejected ones, and cycles without an accepted one.
class CycleTally {
public:
    struct Counts {
        std::int32_t contacts = 0;  // learned ones, and the next three
        std::int32_t accepted = 0;
        std::int32_t rejected = 0;
        std::int32_t unexpected = 0;  // without a partner
        std::int32_t missed = 0;      // in complete cycles
    };

    // A cycle that has ended.
    struct Cycle {
        bool compared = false;       // its contacts were compared with a reference
        bool learning = false;       // it was to be learned from
        bool complete = false;       // it was not aborted
        bool enabled = false;        // to its end
        bool new_reference = false;  // it gave one
        std::int32_t missed = 0;     // contacts with a partner that did not come
        LearningFault fault = LearningFault::none;
    };

    const Counts& counts() const noexcept { return counts_; }
    Rejection rejection() const noexcept { return rejection_; }  // the last one
    Rejection of_last_contact() const noexcept { return rejects_ ? rejection_ : Rejection::none; }
    LearningFault learning_fault() const noexcept { return learning_fault_; }  // of the last learning cycle
    bool barren() const noexcept { return barren_; }  // since a cycle in which no contact counted

    // In the last cycles, at least three, contacts were compared and none accepted.
    bool lost_track() const noexcept { return barren_cycles_ >= 3; }

    bool learnt() const noexcept { return learnt_; }  // the last cycle has given a reference

    void begin() noexcept {
        learnt_ = false;
        rejected_before_ = counts_.rejected;
        accepted_before_ = counts_.accepted;
    }

    void end(const Cycle& its) noexcept {
        if (its.learning) learning_fault_ = its.fault;
        learnt_ = its.new_reference;
        if (!its.compared) return;
        counts_.missed += its.missed;
        if (its.learning || !its.complete) return;
        if (its.enabled && counts_.accepted == accepted_before_) barren_ = true;
        if (counts_.rejected > rejected_before_) ++barren_cycles_;
    }

    void find() noexcept { ++counts_.contacts; }

    // A contact counts: it is learned, or accepted.
    void accept(bool learning) noexcept {
        barren_ = rejects_ = false;
        barren_cycles_ = 0;
        rejected_before_ = counts_.rejected;
        if (!learning) ++counts_.accepted;
    }

    void reject(Rejection reason) noexcept {
        ++(reason == Rejection::unexpected ? counts_.unexpected : counts_.rejected);
        rejection_ = reason;
        rejects_ = true;
    }

    // The growth is unknown from here on.
    void forget() noexcept { barren_ = false; }

private:
    Counts counts_;
    Rejection rejection_ = Rejection::none;
    LearningFault learning_fault_ = LearningFault::none;
    bool barren_ = false, learnt_ = false, rejects_ = false;
    std::int32_t barren_cycles_ = 0;
    std::int32_t accepted_before_ = 0;  // when this cycle began
    std::int32_t rejected_before_ = 0;  // then, or at the last accepted contact
};

}  // namespace plumb
