// SPDX-License-Identifier: GPL-2.0-or-later
// The command line of plumb squareness: texts become the machine that they describe.
#pragma once

#include <CLI/App.hpp>

#include <optional>
#include <string>
#include <vector>

#include "components/commissioning/squareness/machine_frame.hpp"
#include "components/commissioning/squareness/squareness_advice.hpp"
#include "components/commissioning/squareness/squareness_given.hpp"
#include "components/commissioning/squareness/view_directions.hpp"
#include "components/math/geometry/corner.hpp"
#include "components/math/geometry/probed_shape.hpp"

namespace plumb::commissioning {

struct SquarenessOptions {
    struct Measured {
        Corner corner;
        std::string how;
    };
    // A file of probed points, which is not read yet.
    struct Points {
        std::string file;
        double unit = 1;    // mm
        ProbedShape shape;  // as far as the file has no column for it
        std::string own;    // text of the artifact's own uncertainty: an angle, or a length for a ring
    };

    // A beam on two motors, of the axis `drive`, at two places along the axis `across` that it carries.
    struct Gantry {
        Axis drive, across;
        double first, second;  // mm
    };

    SquarenessGiven given;
    std::optional<Gantry> gantry;
    TiltedMachine machine;  // without measurements
    std::string instance = "square";
    std::vector<Measured> measured;
    std::vector<Points> points;
    std::vector<std::string> tables;  // files to be checked, and nothing else
    std::string ini;                  // of LinuxCNC, which must not compensate the same axes
    bool seal = false;                // writes their seals
    bool json = false;                // for a screen
    bool corrections = false;         // of the states of the input
    std::string input;                // a document that describes the machine in the place of options
    std::string picture;              // file to be drawn
    ViewDirections directions;
    MachineFrame frame = MachineFrame::any;
};

// Declares the arguments of the command, which are parsed into `options`.
void declare_squareness(CLI::App& command, SquarenessOptions& options);

// Reads the texts into `options`, which has unit, reading, datum and correction already. Throws
// CLI::ValidationError with the place and the reason.
void take_squareness(const SquarenessGiven& given, SquarenessOptions& options);

// Throws std::runtime_error with the file and the reason.
SquarenessOptions::Measured measured_by(const SquarenessOptions::Points& points, const AxisChain& chain);

}  // namespace plumb::commissioning
