// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

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
        case LearningFault::disturbed:
            return "A signal was invalid, an offset was in force, or learn, program or tools changed.";
        case LearningFault::no_contact: return "No contact was found.";
        case LearningFault::poor: return "The load is too poor: no contact is more certain than gate-floor.";
        case LearningFault::disagree:
            return "Contacts of one tool disagree in how the load rises: learn from another cycle.";
        default: return nullptr;  // no_clock, rises_twice: as Rejection
    }
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
            poor_ |= poor;
            disagree_ |= odd && !poor;
        }
    }

    bool refuses(std::int32_t i) const noexcept { return refused_[i]; }
    bool poor() const noexcept { return poor_; }
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
    bool poor_ = false, disagree_ = false;
};

}  // namespace plumb
