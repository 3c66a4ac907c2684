// SPDX-License-Identifier: GPL-2.0-or-later
// Turns tilted axes into the settings of `squareness`, the moves that verify their signs, and notes. It
// decides for the command line and for screens; they ask and show.
#pragma once

#include "components/commissioning/squareness/squareness_of_chain.hpp"
#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/corner.hpp"
#include "components/math/geometry/kinematic_chain.hpp"
#include "components/math/geometry/tilt.hpp"

#include <optional>
#include <string>
#include <vector>

namespace plumb::commissioning {

struct TiltedMachine {
    std::string chain_text = "w-X-Y.b-Z-C-t";
    AxisChain chain;  // chain_text, parsed
    bool inch = false;
    TiltReading reading = TiltReading::component;
    TiltDatum against = TiltDatum::rail;
    std::vector<Axis> order;  // of all axes of the chain: each is true, or held against those before it
    double travel = 300;      // mm, of the test moves
    std::vector<SquarenessQuantity> known;  // an uncertainty is the stated one
    std::vector<Corner> measured;
    std::vector<std::string> instruments;  // of each in `measured`; may be left out
    // The component's settings. If the correction was on while the tilts above were measured, these are what
    // remained and add to the settings; otherwise they take the place of the same settings.
    std::vector<SquarenessQuantity> in_force;
    bool measured_with_correction = true;
};

struct SquarenessAdvice {
    struct Setting {
        std::string pin, value;  // for example ec0y, -8e-05
        std::string comment;
        bool in_force = true;  // false: only under the condition in the comment
    };
    // An indicator in the spindle reads `rise` more after an axis has moved. It touches a square whose base
    // was trued along another axis, or a face of the table if the two axes turn together.
    struct TestMove {
        SquarenessQuantity quantity;  // whose sign it shows
        Axis moved = Axis::Y;
        std::optional<Axis> base = Axis::X;  // none: the table
        Lean plunger{Axis::X, 1, 0};         // the direction in which it points
        double travel = 0;                   // mm
        double rise = 0;                     // mm, without correction; 0 with it
        std::optional<double> uncertainty;   // mm, standard, of the rise

        // With all settings of the wrong sign.
        double rise_by_wrong_signs() const noexcept { return 2 * rise; }

        struct WrongSign {
            SquarenessQuantity quantity;
            double rise = 0;  // mm, if this setting alone has the wrong sign
        };
        std::vector<WrongSign> single;  // of all quantities that this move shows
    };

    std::vector<SquarenessQuantity> quantities;  // those that are known, and those that follow
    std::vector<SquarenessQuantity> settled;     // the same together with those in force
    // What each independent uncertainty contributes to them: its standard deviation, in each quantity.
    std::vector<std::vector<SquarenessQuantity>> deviations;
    Eigen::Matrix3d slopes = Eigen::Matrix3d::Identity();  // columns: travel of the tip for 1 of X, Y and Z
    std::string options;                                   // of the line that loads the component
    std::vector<Setting> settings;
    std::vector<TestMove> moves;
    std::vector<std::string> unseen;  // sentences: tilts that no test move shows
    std::vector<std::string> notes;   // sentences
};

// Throws std::invalid_argument if measurements contradict each other or a known tilt, or if no machine can
// be so.
SquarenessAdvice advice_on(const TiltedMachine& machine);

// The chain with these tilts.
KinematicChain chain_of(const TiltedMachine& machine, const std::vector<SquarenessQuantity>& quantities);

// The lean that a quantity is.
Lean lean_of(const SquarenessQuantity& quantity);

}  // namespace plumb::commissioning
