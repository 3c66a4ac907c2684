// SPDX-License-Identifier: GPL-2.0-or-later
// A bit that linuxcnc_link tells the operator when it rises, beside the status: what is over when it is read,
// such as a result. The sentence has values of pins in braces, {rows}; a code stands there as its sentence.
//
//     hal::Told told_learnt{this, "learnt", hal::Tell::text, "Learned from this part: {rows} contacts."};
#pragma once

#include "hal/pin.hpp"
#include "hal/status.hpp"

#include <string>

namespace plumb::hal {

struct Told {
    Told(Owner owner, const std::string& pin, Tell tell, const std::string& sentence) {
        owner.registrar().add(ToldInfo{owner.name(pin), name(tell), sentence});
    }
};

}  // namespace plumb::hal
