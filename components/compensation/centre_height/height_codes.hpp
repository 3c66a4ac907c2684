// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>

namespace plumb {

// Why there is no height.
enum class Fault : std::int32_t {
    none,
    diameter,
    radius,
    doubled,
    inch,
    metric,
    beam,
    position,
    settings,
    too_few,
    travel,
    travel_differs,
    order,
    short_travel,
    long_travel,
    past_centre,
    air_cut,
    clearance,
    no_step,
    no_solution,
    implausible,
    no_load,
};
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::diameter: return "The diameter is not above 0. Measure and enter it again.";
        case Fault::radius: return "The entry is the radius, not the diameter. Enter the diameter.";
        case Fault::doubled: return "The entry is the diameter, not the radius. Enter the radius.";
        case Fault::inch: return "The entry is in inches. Enter it in the unit of the machine.";
        case Fault::metric: return "The entry is in millimetres. Enter it in the unit of the machine.";
        case Fault::beam: return "The work is not inside the beam, or more light is received than emitted.";
        case Fault::position: return "A position of X or Y is invalid.";
        case Fault::settings: return "A setting is out of its range, which the list of pins gives.";
        case Fault::too_few: return "The method needs more cuts.";
        case Fault::travel: return "The travel of X between the cuts is not above 0.";
        case Fault::travel_differs:
            return "The entered travel is not the travel of X. Enter it as a radius, not in diameter.";
        case Fault::order:
            return "The second cut did not go deeper. The diameters are swapped, or the tool did not cut.";
        case Fault::short_travel: return "The diameters differ by more than X has travelled.";
        case Fault::long_travel: return "The travel is larger than both radii together.";
        case Fault::past_centre:
            return "The tool has passed the axis of the work; the radius is the height itself. Travel less.";
        case Fault::air_cut: return "The tool removed nothing. Cut deeper.";
        case Fault::clearance: return "The tool rubs at this height: its clearance angle is too small.";
        case Fault::no_step: return "The method needs cuts at two positions of Y.";
        case Fault::no_solution: return "The cuts do not determine the height: move X and Y independently.";
        case Fault::implausible:
            return "The diameter does not follow from X of the tool. The tool did not cut, or its X or Y is "
                   "wrong by more than max-x-correction or max-move.";
        case Fault::no_load:
            return "The load of the spindle has shown no cut. Start the spindle, and cut deeper.";
        default: return nullptr;
    }
}

// Why Y may not move, although there is a height.
enum class Hold : std::int32_t {
    none,
    value_only,
    sign,
    insignificant,
    sigma,
    move,
    disagreement,
    at_rest,
    shim,
    sign_by_shim,
};
constexpr const char* sentence(Hold hold) {
    switch (hold) {
        case Hold::value_only: return "The function is not permitted: move Y by hand, or switch it on.";
        case Hold::sign:
            return "Two cuts do not show the sign. Cut with a step of Y, or set sign to 1 or -1.";
        case Hold::insignificant:
            return "The height is not known well enough: cut again. cuts-needed gives the number of cuts.";
        case Hold::sigma: return "The uncertainty of the height exceeds max-sigma.";
        case Hold::move: return "The move of Y exceeds max-move.";
        case Hold::at_rest: return "The height is that at rest. Y is corrected by the height under the cut.";
        case Hold::shim:
            return "This machine has no Y: raise the tool by y-move, with a shim. Below 0, lower it.";
        case Hold::sign_by_shim:
            return "Two cuts do not show the sign. Cut a third time with a shim below the tool, or set sign "
                   "to "
                   "1 or -1.";
        case Hold::disagreement:
            return "The cuts disagree by more than three sigmas: a burr, a chip or a slip. Cut more lands, "
                   "or begin again.";
        default: return nullptr;
    }
}

// Where the procedure is, as an instruction to the operator.
enum class State : std::int32_t { idle, cut, measure, known, refused, aborted };
constexpr const char* sentence(State state) {
    switch (state) {
        case State::cut: return "Cut the next land, and report the end of the cut.";
        case State::measure: return "Measure this cut, and enter the value.";
        case State::known: return "The height is known.";
        case State::refused: return "The cuts give no height; fault-code gives the cause. Begin again.";
        case State::aborted: return "The procedure is interrupted: resume it, or begin again.";
        default: return nullptr;
    }
}

// The answer for Y and X of the tool.
enum class Verdict : std::int32_t { none, on_centre, both, y, x, unsure, unchecked, held };
constexpr const char* sentence(Verdict verdict) {
    switch (verdict) {
        case Verdict::on_centre: return "The tool is on centre. Nothing to store.";
        case Verdict::both: return "Y and X of the tool are wrong. M454 stores both.";
        case Verdict::y: return "Y of the tool is wrong. M454 stores Y; X stays.";
        case Verdict::x: return "X of the tool is wrong. M454 stores X; Y stays.";
        case Verdict::unsure:
            return "Not known well enough: cut again. cuts-needed and remedy-code give the cuts.";
        case Verdict::unchecked:
            return "The tool seems on centre, but the cuts are not checked for air. Enter the diameter of "
                   "the "
                   "stock: M450 E.";
        case Verdict::held: return "Y or X is wrong, but nothing may be stored. hold-code gives the cause.";
        default: return nullptr;
    }
}

// The cuts that make an unknown height known.
enum class Remedy : std::int32_t { none, more_cuts, lands, finer, finer_two };
constexpr const char* sentence(Remedy remedy) {
    switch (remedy) {
        case Remedy::more_cuts: return "Cut more lands in the same order, cuts-needed in all.";
        case Remedy::lands: return "Begin again with two lands in the order 1 2 2 1, cuts-needed in all.";
        case Remedy::finer:
            return "16 cuts are not enough: take a larger land-step, a finer gauge or a larger tolerance.";
        case Remedy::finer_two:
            return "More cuts do not help. Take a finer gauge, a longer travel of X between the cuts, or a "
                   "larger tolerance.";
        default: return nullptr;
    }
}

enum class Method : std::int32_t { two_cuts, two_lands, y_step, any_cuts };

}  // namespace plumb
