// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/squareness_advice.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "components/math/kinematic_chain.hpp"
#include "hal/host/squareness_wording.hpp"

namespace plumb::host {
namespace {

using Quantities = std::vector<SquarenessQuantity>;

constexpr double inch = 25.4;                  // mm
constexpr double largest_angle = 0.1;          // rad, of all there is
constexpr double usual_largest_angle = 0.002;  // rad, which the component takes by default

std::string name_of(const SquarenessQuantity& q) {
    return squareness_name(q.axis, q.rotation);
}

// The axis against which a quantity is seen.
Axis base_of(const SquarenessQuantity& q) {
    return static_cast<Axis>(3 - direction(q.axis) - q.rotation);
}

Quantities quantities_of(const TiltedMachine& machine, const std::vector<Corner>& corners) {
    const SquarenessOfChain solver(machine.chain, machine.reading, machine.against, machine.order);
    Quantities quantities = solver.quantities(corners, machine.known);
    std::stable_sort(quantities.begin(), quantities.end(), [](const auto& one, const auto& other) {
        return std::make_pair(one.axis, one.rotation) < std::make_pair(other.axis, other.rotation);
    });
    for (const SquarenessQuantity& q : quantities) {
        for (const SquarenessQuantity& other : machine.known)
            if (q.uncertainty && q.is_of(other.axis, other.rotation))
                throw std::invalid_argument(name_of(q) +
                                            " is set and follows from measurements, too: leave one out");
        if (!(std::abs(q.angle) < largest_angle))
            throw std::invalid_argument(name_of(q) + " would be " + formatted("%.4g", q.angle) +
                                        " rad: an angle is below 0.1 rad");
    }
    return quantities;
}

std::vector<SquarenessAdvice::Setting> settings_of(const TiltedMachine& machine,
                                                   const Quantities& quantities) {
    std::vector<SquarenessAdvice::Setting> settings;
    const auto add = [&](const std::string& pin, const std::string& value, const std::string& comment) {
        settings.push_back({pin, value, comment, true});
    };
    if (machine.inch) {  // the defaults are numbers of millimetres
        add("max-correction", formatted("%.4g", 1 / inch), "in, which is 1 mm");
        add("max-rate", formatted("%.4g", 0.1 / inch), "in/s, which is 0.1 mm/s");
        add("max-speed", formatted("%.4g", 1000 / inch), "in/s, which is 1000 mm/s");
    }
    double largest = 0;
    for (const SquarenessQuantity& q : quantities) largest = std::max(largest, std::abs(q.angle));
    if (largest > usual_largest_angle)
        add("max-angle", formatted("%.3g", std::ceil(largest * 1e3) / 1e3), "rad, for the largest angle");
    const bool component = machine.reading == TiltReading::component;
    add("axis-direction", component ? "0" : "1",
        component ? "reading: component" : "reading: axis direction");
    if (machine.chain.stacked()) {
        const bool rail = machine.against == TiltDatum::rail;
        add("to-bed", rail ? "0" : "1", rail ? "tilts against the rail" : "tilts against the bed");
    }
    for (const SquarenessQuantity& q : quantities)
        add(lower_case(name_of(q)), q.angle == 0 ? "0" : formatted("%.6g", q.angle),
            letters(q.axis) + (q.angle == 0
                                   ? " does not lean"
                                   : " leans to " + name(lean_of(q)) + " by " + arcsec(std::abs(q.angle))));
    std::set<Axis> leaning;
    for (const SquarenessQuantity& q : quantities) {
        if (q.angle == 0 || !leaning.insert(q.axis).second) continue;
        const std::string end = machine.chain.tool.has(q.axis) ? "spindle" : "table";
        settings.push_back({lower_case(letters(q.axis)) + "-tool-follows", "0",
                            "only if the " + end + " was set up square though " + letters(q.axis) + " leans",
                            false});
    }
    return settings;
}

KinematicChain chain_of(const TiltedMachine& machine, const Quantities& quantities) {
    KinematicChain::Settings settings;
    settings.axes = machine.chain;
    settings.reading = machine.reading;
    settings.datum = machine.against;
    for (const SquarenessQuantity& q : quantities)
        settings.tilts[static_cast<std::size_t>(coordinate(q.axis))].angles[q.rotation] = q.angle;
    return KinematicChain(settings);
}

// Of two quantities that the same square shows, that of the axis that was held against the datum.
SquarenessQuantity held_one(const SquarenessQuantity& q, const Quantities& quantities,
                            const std::vector<Axis>& order) {
    const auto place = [&](Axis axis) { return std::find(order.begin(), order.end(), axis); };
    for (const SquarenessQuantity& other : quantities)
        if (q.uncertainty && other.axis == base_of(q) && base_of(other) == q.axis &&
            place(other.axis) > place(q.axis))
            return other;
    return q;
}

void add_test_moves(const TiltedMachine& machine, const std::vector<Corner>& corners,
                    SquarenessAdvice& advice) {
    const KinematicChain chain = chain_of(machine, advice.quantities);
    std::set<std::pair<Axis, Axis>> shown;
    for (const SquarenessQuantity& quantity : advice.quantities) {
        const SquarenessQuantity q = held_one(quantity, advice.quantities, machine.order);
        const Axis base = base_of(q);
        if (q.angle == 0 || !shown.insert({std::min(q.axis, base), std::max(q.axis, base)}).second) continue;
        const double reading = indicator_on_square(chain, q.axis, base, machine.travel);
        if (std::abs(reading) < 1e-9 * machine.travel) {
            if (!q.uncertainty)
                advice.unseen.push_back(name_of(q) + ": " + letters(q.axis) + " and " + letters(base) +
                                        " turn together and stay square; no square shows it.");
            continue;
        }
        SquarenessAdvice::TestMove move{q, base, reading > 0 ? 1 : -1, machine.travel, std::abs(reading), {}};
        for (const Corner& corner : corners)
            if (corner.is_of(q.axis, base)) move.uncertainty = corner.uncertainty * machine.travel;
        advice.moves.push_back(move);
    }
}

std::vector<std::string> notes_on(const Quantities& quantities, const std::vector<Corner>& corners) {
    std::vector<std::string> notes;
    for (const SquarenessQuantity& q : quantities)
        if (q.uncertainty && std::abs(q.angle) < 2 * *q.uncertainty)
            notes.push_back(name_of(q) +
                            " is less than its uncertainty with k=2: not even its sign is certain.");
    for (const SquarenessQuantity& q : quantities)
        if (std::abs(q.angle) > usual_largest_angle)
            notes.push_back(name_of(q) +
                            " is more than the component takes by default, 0.002 rad: max-angle is set. See "
                            "that max-correction suffices for the travel.");
    for (const Corner& corner : corners) {
        std::vector<std::string> both;
        for (const SquarenessQuantity& q : quantities)
            if (q.uncertainty && ((corner.a == q.axis && parallel(corner.b, base_of(q))) ||
                                  (corner.b == q.axis && parallel(corner.a, base_of(q)))))
                both.push_back(name_of(q));
        if (both.size() > 1)
            notes.push_back(both[0] + " and " + both[1] +
                            " belong together: one of the two axes carries the other, and what it turns that "
                            "by is taken back.");
    }
    return notes;
}

}  // namespace

Lean lean_of(const SquarenessQuantity& quantity) {
    const std::vector<Lean> all =
        leans(quantity.axis, quantity.angle * Eigen::Vector3d::Unit(quantity.rotation));
    return all.empty() ? Lean{} : all.front();
}

SquarenessAdvice advice_on(const TiltedMachine& machine) {
    const std::vector<Corner> corners = each_once(machine.measured);
    SquarenessAdvice advice;
    advice.quantities = quantities_of(machine, corners);
    advice.options = "chain=" + machine.chain_text + (machine.inch ? " unit=inch" : "");
    advice.settings = settings_of(machine, advice.quantities);
    add_test_moves(machine, corners, advice);
    advice.notes = notes_on(advice.quantities, corners);
    return advice;
}

}  // namespace plumb::host
