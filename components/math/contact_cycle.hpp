// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact_reference.hpp"

#include <array>
#include <cstdint>

namespace plumb {

// One cycle of a program after the other: numbers the approaches, learns a reference from a cycle or finds
// the partners of its contacts in the reference.  Pairing goes by operation, tool and occurrence: the n-th
// approach of that tool in that operation, whether or not the ones before met the work, so that a missed
// contact shifts no other one.
class ContactCycle {
public:
    bool running() const noexcept { return running_; }
    bool learning() const noexcept { return running_ && learning_; }
    std::int32_t number() const noexcept { return number_; }  // of this cycle, counted from 1
    const ContactReferences& references() const noexcept { return lists_[in_force_]; }

    void begin(bool learn) noexcept {
        running_ = true;
        learning_ = learn;
        spoilt_ = false;
        ++number_;
        kinds_ = 0;
        met_.fill(false);
        draft().clear();
    }

    struct Ended {
        bool learnt;          // there is a new reference
        std::int32_t missed;  // contacts of the reference that did not come
    };

    // The cycle has ended, in whatever state.  Only a complete and unspoilt learning cycle with a contact
    // gives a reference; otherwise the one before stays.  What a cycle that is not complete has missed is not
    // known: 0.
    Ended end(bool complete) noexcept {
        Ended ended{learning() && complete && !spoilt_ && draft().size() > 0, 0};
        if (!learning() && complete)
            for (std::int32_t i = 0; i < references().size(); ++i) ended.missed += !met_[i];
        if (ended.learnt) in_force_ = 1 - in_force_;
        running_ = false;
        return ended;
    }

    // The key of the contact to which an approach that now begins may lead.  An occurrence of 0, which has no
    // partner and cannot be learnt, if there are too many kinds.
    ContactKey approach(std::int32_t operation, std::int32_t tool) noexcept {
        for (std::int32_t i = 0; i < kinds_; ++i) {
            if (last_[i].operation != operation || last_[i].tool != tool) continue;
            ++last_[i].occurrence;
            return last_[i];
        }
        if (kinds_ == most_kinds) return {operation, tool, 0};
        return last_[kinds_++] = {operation, tool, 1};
    }

    // The reference of a contact, which has now come; or null.
    const ContactReference* partner(const ContactKey& key) noexcept {
        const std::int32_t i = references().find(key);
        if (i < 0) return nullptr;
        met_[i] = true;
        return &references()[i];
    }

    // While learning.
    void learn(const ContactReference& reference) noexcept {
        spoilt_ |= reference.key.occurrence < 1 || !draft().add(reference);
    }
    void spoil() noexcept { spoilt_ = true; }  // this cycle cannot become a reference

    // From a file.  Refused while learning, if implausible, full or doubled, or if made by another program.
    bool restore(const ContactReference& reference, std::int32_t program) noexcept {
        return !learning() && reference.valid() && reference.program == program &&
               (references().size() == 0 || valid_for(program)) && lists_[in_force_].add(reference);
    }
    void forget() noexcept { lists_[in_force_].clear(); }

    // There is a reference, and it belongs to this program.
    bool valid_for(std::int32_t program) const noexcept {
        return references().size() > 0 && references()[0].program == program;
    }

private:
    static constexpr std::int32_t most_kinds = 4 * ContactReferences::capacity;  // not each meets the work

    ContactReferences& draft() noexcept { return lists_[1 - in_force_]; }

    ContactReferences lists_[2];  // one in force, the other a draft
    int in_force_ = 0;
    bool running_ = false;
    bool learning_ = false;
    bool spoilt_ = false;
    std::int32_t number_ = 0;
    std::int32_t kinds_ = 0;                               // of approaches in this cycle
    std::array<ContactKey, most_kinds> last_;              // the last one of each kind
    std::array<bool, ContactReferences::capacity> met_{};  // by index of the reference
};

}  // namespace plumb
