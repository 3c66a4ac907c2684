// SPDX-License-Identifier: GPL-2.0-or-later
// The parts of a machine as boxes: to the right, to the back, upward.
#pragma once

#include "components/commissioning/squareness/machine_frame.hpp"
#include "components/commissioning/squareness/view_directions.hpp"
#include "components/math/geometry/axis_chain.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace plumb::commissioning {

struct MachinePart {
    enum class Kind { fixed, axis, work, tool };
    Eigen::Vector3d low, high;
    Kind kind = Kind::fixed;
    std::optional<Axis> axis;  // that moves it
    bool carries_name = false;
    bool see_through = false;
};

// No two parts reach into each other. Each axis has one part that carries its name.
std::vector<MachinePart> machine_parts(const AxisChain& chain, const ViewDirections& directions,
                                       MachineFrame frame);

}  // namespace plumb::commissioning
