// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"
#include "hal/component.hpp"

#include <cstdint>

namespace plumb {

// What a reference belongs to, and what is remembered with it.
struct ReferenceConditions {
    explicit ReferenceConditions(hal::Component* component) : owner(component) {}

    MachiningSetup setup() const noexcept { return {program_id, tool_set_id}; }

    bool acknowledges() noexcept {
        const bool now = acknowledge, edge = now && !acknowledging_;
        acknowledging_ = now;
        return edge;
    }

    hal::Component* const owner;
    hal::In<std::int32_t> program_id{owner, "program-id", 0, "Tells programs, and versions of one, apart."};
    hal::In<std::int32_t> tool_set_id{owner, "tool-set-id", 0,
                                      "Tells sets of tools apart, as a checksum of the tool table."};
    hal::In<double> temperature{owner, "temperature", 20, "degC",
                                "Temperature to remember with a reference."};
    hal::In<std::int32_t> date{owner, "date", 0, "YYYYMMDD to remember with a reference; 0 when not known."};
    hal::In<bool> acknowledge{owner, "acknowledge", false, "A rising edge ends a refusal of the reference."};

private:
    bool acknowledging_ = false;
};

}  // namespace plumb
