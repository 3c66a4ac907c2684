// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/geometry/kinematic_chain.hpp"

namespace plumb {

// A machine without tilts.
inline KinematicChain::Settings chain(const char* text) {
    KinematicChain::Settings settings;
    settings.axes = AxisChainReader::read(text);
    return settings;
}

}  // namespace plumb
