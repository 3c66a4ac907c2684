// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"
#include "components/math/contact/contact_rejection.hpp"

#include <cstdint>

namespace plumb {

// Why a reference as a whole is refused.
enum class Refusal : std::int32_t { none, program, tool_set, feed };

constexpr const char* sentence(Refusal refusal) {
    switch (refusal) {
        case Refusal::program: return "The reference is of another program.";
        case Refusal::tool_set: return "The reference is of another set of tools.";
        default: return nullptr;  // feed: as Rejection::feed_differs
    }
}

// Whether a reference may be used at all. It is judged as a cycle begins; a cycle in which all contacts
// came with another feed or override refuses it as well, for the next ones. A refusal stays until it is
// acknowledged, a cycle is learned from or there is no reference any more: a message to the operator must
// not vanish by itself.
class ReferenceRefusal {
public:
    Refusal reason() const noexcept { return reason_; }
    bool compares() const noexcept { return compares_; }  // in this cycle

    void begin(const ContactReferences& references, const MachiningSetup& setup, bool learn) noexcept {
        if (learn || references.size() == 0) {
            reason_ = Refusal::none;
        } else if (reason_ == Refusal::none && !references.made_with(setup)) {
            reason_ = references[0].setup.program != setup.program ? Refusal::program : Refusal::tool_set;
        }
        compares_ = reason_ == Refusal::none;
        agreed_ = differs_ = false;
    }

    // A contact of this cycle was compared with its partner, with this outcome.
    void compared(Rejection outcome) noexcept {
        (outcome == Rejection::feed_differs ? differs_ : agreed_) = true;
    }

    void end(bool complete) noexcept {
        if (compares_ && complete && !agreed_ && differs_) reason_ = Refusal::feed;
        compares_ = false;
    }

    void acknowledge() noexcept { reason_ = Refusal::none; }

private:
    Refusal reason_ = Refusal::none;
    bool agreed_ = false, differs_ = false;  // a contact of this cycle, in feed and override
    bool compares_ = false;
};

}  // namespace plumb
