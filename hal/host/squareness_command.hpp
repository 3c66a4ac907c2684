// SPDX-License-Identifier: GPL-2.0-or-later
// plumb squareness: from what is set or measured of tilted axes to the settings of `squareness`.
#pragma once

#include <CLI/App.hpp>

#include <string>
#include <vector>

#include "components/math/axis_chain.hpp"
#include "components/math/corner.hpp"
#include "components/math/probed_shape.hpp"
#include "components/math/squareness_of_chain.hpp"
#include "components/math/tilt.hpp"
#include "components/math/tilted_branch.hpp"
#include "hal/host/command_manual.hpp"

namespace plumb::host {

struct SquarenessOptions {
    struct Tilt {
        Axis axis;
        Lean lean;
    };
    struct Measured {
        Corner corner;
        std::string how;
    };
    // A file of probed points, which is not read yet.
    struct Points {
        std::string file;
        double unit = 1;    // mm
        ProbedShape shape;  // what the file does not say
        std::string own;    // text of the artifact's own uncertainty: of an angle, or of a length for a ring
    };

    std::string chain_text = "w-X-Y.b-Z-C-t";
    AxisChain chain;
    std::string instance = "square";
    bool inch = false;
    TiltReading reading = TiltReading::component;
    TiltDatum against = TiltDatum::rail;
    std::vector<Axis> order;  // of all axes of the chain: each is true, or held against those before it
    double travel = 0;        // mm, of the test move
    std::vector<Tilt> tilts;
    std::vector<SquarenessQuantity> settings;  // of tilts, too
    std::vector<Measured> measured;
    std::vector<Points> points;
};

// Declares the arguments of the command, which are parsed into `options`.
void declare_squareness(CLI::App& command, SquarenessOptions& options);

CommandPage squareness_page();

// Prints settings, the lines for the .hal file and the test moves. Returns 0. Throws std::runtime_error and
// std::invalid_argument.
int squareness(const SquarenessOptions& options);

}  // namespace plumb::host
