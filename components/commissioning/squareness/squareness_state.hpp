// SPDX-License-Identifier: GPL-2.0-or-later
// All leans that a chain can have, and the corners between its axes: measured, in force, before and after.
#pragma once

#include "components/commissioning/error_list.hpp"
#include "components/commissioning/squareness/squareness_advice.hpp"
#include "components/commissioning/squareness/squareness_of_chain.hpp"
#include "components/math/geometry/axis_chain.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace plumb::commissioning {

// Two directions of an axis, and the quantity that both are.
struct LeanState {
    Axis axis = Axis::Y;
    int rotation = 2;
    TiltEffect effect;
    std::string useless;  // a sentence, if the lean alone corrects nothing on this chain
    std::optional<SquarenessQuantity> measured, in_force, settled;  // an uncertainty is standard
    double before = 0;  // rad, the part of `settled` that the settings in force leave
    std::string words;  // before and after; empty unless something is settled

    // To the end of X, Y or Z.
    Axis towards() const noexcept { return static_cast<Axis>(3 - direction(axis) - rotation); }
    // Of the quantity, if the axis leans to the + end.
    int sign() const noexcept;
};

// Two axes that are not parallel.
struct CornerState {
    enum class Basis { none, in_force, given, measured };
    Axis a = Axis::X, b = Axis::Y;
    Basis basis = Basis::none;
    double uncorrected = 0;             // rad, by how much the angle of the + ends is more than 90 deg
    double before = 0;                  // rad, with the settings in force; after, with the new ones, it is 0
    std::optional<double> uncertainty;  // rad, standard, of what remains
    std::string words;                  // before and after
};

struct SquarenessState {
    std::vector<LeanState> leans;  // of each axis, from the bed outwards: first the work's, then the tool's
    std::vector<CornerState> corners;
    Eigen::Matrix3d slopes_before = Eigen::Matrix3d::Identity();  // travel of the tip with those in force
    std::string words;  // of the corner that is least certain, and which are not measured
};

SquarenessState state_of(const TiltedMachine& machine, const SquarenessAdvice& advice);

// The list of errors with its corners stated.
ErrorList errors_of(const TiltedMachine& machine, const SquarenessState& state);

// Why a lean alone corrects nothing; empty if it does.
std::string useless_because(const TiltedMachine& machine, Axis axis, int rotation);

}  // namespace plumb::commissioning
