// SPDX-License-Identifier: GPL-2.0-or-later
// Draws a machine from its chain, as it stands before the operator.
#pragma once

#include "components/commissioning/squareness/machine_frame.hpp"
#include "components/commissioning/squareness/squareness_of_chain.hpp"
#include "components/commissioning/squareness/view_directions.hpp"
#include "components/math/geometry/axis_chain.hpp"

#include <string>
#include <vector>

namespace plumb::commissioning {

struct MachineDrawing {
    std::string title;
    AxisChain chain;
    ViewDirections directions;
    MachineFrame frame = MachineFrame::any;
    std::vector<SquarenessQuantity> leans;  // drawn much enlarged

    std::string svg() const;
};

}  // namespace plumb::commissioning
