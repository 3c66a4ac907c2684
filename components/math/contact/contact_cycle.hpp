// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"
#include "components/math/contact/learning_check.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace plumb {

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
    const ContactReferences& references() const noexcept { return lists_[in_force_]; }

    void begin(bool learn, const MachiningSetup& setup) noexcept {
        running_ = true;
        learning_ = learn;
        spoilt_ = clockless_ = rose_twice_ = false;
        doubted_ = {};
        ++number_;
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
    // the last of `wanted` such cycles gives a reference; until then the one before stays. The number of
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
            std::swap(in_force_, mean_);
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

    // A reference was off by a distance, in mu: 0 ≤ i < references().size().
    void displace(std::int32_t i, double distance) noexcept {
        Contact& contact = lists_[in_force_][i].contact;
        contact.coordinate += distance;
        contact.be_higher(distance);
    }

    // Calls change(ContactReference&) for each contact that is known, of the present cycle too.
    template <class Change>
    void each(const Change& change) noexcept {
        for (ContactReferences& list : lists_)
            for (std::int32_t i = 0; i < list.size(); ++i) change(list[i]);
    }

    // From a file. Refused while learning, or if the reference is implausible, one too many, double, or of
    // another setup than those before.
    bool restore(const ContactReference& reference) noexcept {
        return !learning() && reference.valid() &&
               (references().size() == 0 || references().made_with(reference.setup)) &&
               lists_[in_force_].add(reference);
    }
    void forget() noexcept {
        lists_[in_force_].clear();
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

    static constexpr std::int32_t most_kinds = 4 * ContactReferences::capacity;  // not each meets the work

    ContactReferences& mean() noexcept { return lists_[mean_]; }
    ContactReferences& draft() noexcept { return lists_[draft_]; }
    const ContactReferences& partners() const noexcept { return lists_[learning_ ? mean_ : in_force_]; }

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

    ContactReferences lists_[3];
    int in_force_ = 0, mean_ = 1, draft_ = 2;  // of them; the draft is of the present cycle
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

}  // namespace plumb
