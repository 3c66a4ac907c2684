// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/blocks/edge.hpp"
#include "components/math/contact/contact_reference.hpp"
#include "hal/component.hpp"

#include <cstdint>

namespace plumb {

// The setup that a reference belongs to, and the conditions that are remembered with it.
struct ReferenceConditions : hal::Group {
    using Group::Group;

    MachiningSetup setup() const noexcept {
        MachiningSetup now;
        now.program = program_id;
        now.tool_set = tool_set_id;
        return now;
    }

    bool acknowledges() noexcept { return acknowledging_.rises(acknowledge); }

    hal::In<std::int32_t> program_id{this, "program-id", 0, "Identifies the program and its version."};
    hal::In<std::int32_t> tool_set_id{this, "tool-set-id", 0,
                                      "Identifies the set of tools, as a checksum of the tool table."};
    hal::In<double> temperature{this, "temperature", 20, "degC", "Temperature to remember with a reference."};
    hal::In<std::int32_t> date{this, "date", 0, "YYYYMMDD to remember with a reference; 0 when not known."};
    hal::In<bool> acknowledge{this, "acknowledge", false, "A rising edge ends a refusal of the reference."};

private:
    Edge acknowledging_;
};

}  // namespace plumb
