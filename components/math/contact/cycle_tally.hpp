// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_rejection.hpp"
#include "components/math/contact/learning_check.hpp"

#include <cstdint>

namespace plumb {

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
