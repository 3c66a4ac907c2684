// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/squareness_advice.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "components/commissioning/squareness/squareness_wording.hpp"

namespace plumb::commissioning {
namespace {

using Quantities = std::vector<SquarenessQuantity>;

constexpr double largest_angle = 0.1;          // rad, settings and measurements together
constexpr double usual_largest_angle = 0.002;  // rad, the component's default of max-angle
constexpr double blunder = 10;                 // times the uncertainty: a wrong sign or unit, not a scatter

std::string name_of(const SquarenessQuantity& q) {
    return squareness_name(q.axis, q.rotation);
}

// The axis against which a quantity is seen.
Axis base_of(const SquarenessQuantity& q) {
    return static_cast<Axis>(3 - direction(q.axis) - q.rotation);
}

bool has(const Quantities& quantities, const SquarenessQuantity& q) {
    return std::any_of(quantities.begin(), quantities.end(),
                       [&](const auto& other) { return other.is_of(q.axis, q.rotation); });
}

void sort(Quantities& quantities) {
    std::stable_sort(quantities.begin(), quantities.end(), [](const auto& one, const auto& other) {
        return std::make_pair(one.axis, one.rotation) < std::make_pair(other.axis, other.rotation);
    });
}

// Known quantities without their stated uncertainties, and those that follow with their own.
Quantities solved(const TiltedMachine& machine, const std::vector<Corner>& corners, Quantities known) {
    for (SquarenessQuantity& q : known) q.uncertainty.reset();
    return SquarenessOfChain(machine.chain, machine.reading, machine.against, machine.order)
        .quantities(corners, known);
}

// Newton's method: the corners of several mrad multiply to some 10 urad, which a linear solution leaves out.
// If the corners contradict the known tilts, no step helps, and the linear solution shows by how much.
Quantities exact(const TiltedMachine& machine, const std::vector<Corner>& corners) {
    const Quantities linear = solved(machine, corners, machine.known);
    std::vector<Corner> aims = corners;
    for (int step = 0; step < 20; ++step) {
        const Quantities quantities = solved(machine, aims, machine.known);
        const KinematicChain chain = chain_of(machine, quantities);
        double largest = 0;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const double rest = corners[i].opening - opening_of(chain, corners[i].a, corners[i].b);
            aims[i].opening += rest;
            largest = std::max(largest, std::abs(rest));
        }
        if (largest < 1e-12) return quantities;
    }
    return linear;
}

Quantities quantities_of(const TiltedMachine& machine, const std::vector<Corner>& corners) {
    Quantities quantities = exact(machine, corners);
    sort(quantities);
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
    add("max-speed", "[TRAJ]MAX_LINEAR_VELOCITY", "of the INI file: no axis is faster");
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

// Adds each angle to the one in force. Angles in force that were not measured stay.
Quantities added_to_force(const TiltedMachine& machine, const Quantities& quantities) {
    Quantities sums = machine.in_force;
    for (const SquarenessQuantity& q : quantities) {
        const auto same = std::find_if(sums.begin(), sums.end(),
                                       [&](const auto& sum) { return sum.is_of(q.axis, q.rotation); });
        if (same == sums.end()) {
            sums.push_back(q);
        } else {
            same->angle += q.angle;
            same->uncertainty = q.uncertainty;
        }
    }
    sort(sums);
    for (const SquarenessQuantity& sum : sums)
        if (!(std::abs(sum.angle) < largest_angle))
            throw std::invalid_argument(name_of(sum) + " would be " + formatted("%.4g", sum.angle) +
                                        " rad with the angle in force: an angle is below 0.1 rad");
    return sums;
}

// One square shows two quantities; this is the one of the axis that was held against the datum.
SquarenessQuantity held_one(const SquarenessQuantity& q, const Quantities& quantities,
                            const std::vector<Axis>& order) {
    const auto place = [&](Axis axis) { return std::find(order.begin(), order.end(), axis); };
    for (const SquarenessQuantity& other : quantities)
        if ((q.uncertainty || other.uncertainty) && other.axis == base_of(q) && base_of(other) == q.axis &&
            place(other.axis) > place(q.axis))
            return other;
    return q;
}

// Throws std::invalid_argument unless the machine has the measured corners, apart from terms of second
// order.
void hold_against(const KinematicChain& chain, const std::vector<Corner>& corners,
                  const Quantities& quantities) {
    double largest = 0;
    for (const SquarenessQuantity& q : quantities) largest = std::max(largest, std::abs(q.angle));
    const double second_order = 4 * largest * largest;
    const auto opening = [](double angle) {
        return "90 deg " + std::string(angle < 0 ? "- " : "+ ") + arcsec(std::abs(angle));
    };
    for (const Corner& corner : corners) {
        const double is = opening_of(chain, corner.a, corner.b);
        if (!(std::abs(is - corner.opening) < 1e-7 + second_order))
            throw std::invalid_argument(
                "settings and measurements contradict each other: " + letters(corner.a) + " and " +
                letters(corner.b) + " would be at " + opening(is) + ", but were measured at " +
                opening(corner.opening) + ": leave one out");
    }
}

// What an indicator reads for each setting that alone has the wrong sign: its tilt remains twice, no other
// one.
template <class Indicator>
std::vector<SquarenessAdvice::TestMove::WrongSign> single_wrong_signs(const TiltedMachine& machine,
                                                                      const Quantities& quantities,
                                                                      double visible, Indicator rise) {
    std::vector<SquarenessAdvice::TestMove::WrongSign> result;
    for (SquarenessQuantity q : quantities) {
        q.angle *= 2;
        const double reading = rise(chain_of(machine, {q}));
        q.angle /= 2;
        if (std::abs(reading) >= visible) result.push_back({q, reading});
    }
    return result;
}

void add_test_moves(const KinematicChain& chain, const TiltedMachine& machine,
                    const std::vector<Corner>& corners, SquarenessAdvice& advice) {
    const double travel = machine.travel, visible = 1e-9 * travel;
    std::set<std::pair<Axis, Axis>> shown;
    for (const SquarenessQuantity& quantity : advice.quantities) {
        const SquarenessQuantity q = held_one(quantity, advice.quantities, machine.order);
        const Axis base = base_of(q), along = static_cast<Axis>(direction(q.axis));
        if (q.angle == 0 || !shown.insert({std::min(q.axis, base), std::max(q.axis, base)}).second) continue;
        const double on_square = indicator_on_square(chain, q.axis, base, travel);
        if (std::abs(on_square) >= visible) {
            SquarenessAdvice::TestMove move{
                q, q.axis, base, {base, on_square > 0 ? 1 : -1, 0}, travel, std::abs(on_square), {}, {}};
            for (const Corner& corner : corners)
                if (corner.is_of(q.axis, base)) move.uncertainty = corner.uncertainty * travel;
            const int sign = on_square > 0 ? 1 : -1;
            move.single =
                single_wrong_signs(machine, advice.quantities, visible, [&](const KinematicChain& wrong) {
                    return sign * indicator_on_square(wrong, q.axis, base, travel);
                });
            advice.moves.push_back(move);
            continue;
        }
        if (q.uncertainty) continue;
        const double on_table = indicator_on_table(chain, base, along, travel);
        if (std::abs(on_table) >= visible) {
            const int sign = along == Axis::Z || on_table < 0 ? -1 : 1;  // a table is touched from above
            SquarenessAdvice::TestMove move{q, base, {}, {along, sign, 0}, travel, sign * on_table, {}, {}};
            move.single =
                single_wrong_signs(machine, advice.quantities, visible, [&](const KinematicChain& wrong) {
                    return sign * indicator_on_table(wrong, base, along, travel);
                });
            advice.moves.push_back(move);
        } else {
            advice.unseen.push_back(name_of(q) + ": " + letters(q.axis) + " and " + letters(base) +
                                    " turn together, and the work with them: no indicator shows it, and it "
                                    "corrects next to nothing. If a square showed that " +
                                    letters(q.axis) + " leans, give its readings by --square instead.");
        }
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
            notes.push_back(
                both[0] + " and " + both[1] +
                " belong together: one of the two axes carries the other; the second angle cancels "
                "its effect on the other.");
    }
    return notes;
}

// Throws std::invalid_argument if two measurements of a corner cannot both be right.
void compare(const std::vector<Corner>& measured) {
    const auto text = [](double angle) { return formatted("%+.2f arcsec", arcsec_from_angle(angle)); };
    for (std::size_t i = 0; i < measured.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) {
            const Corner &one = measured[k], &other = measured[i];
            const double both = std::hypot(one.uncertainty, other.uncertainty);
            if (!one.is_of(other.a, other.b) || std::abs(one.opening - other.opening) <= blunder * both)
                continue;
            throw std::invalid_argument(
                "two measurements of " + letters(one.a) + " and " + letters(one.b) +
                " contradict each other: 90 deg " + text(one.opening) + " and 90 deg " + text(other.opening) +
                formatted(", %.0f times their uncertainty", std::abs(one.opening - other.opening) / both) +
                " apart: is a sign or a unit wrong? Leave one out");
        }
}

// The settings in force that neither a tilt nor a measurement replaces.
Quantities kept_of(const TiltedMachine& machine, const std::vector<Corner>& corners) {
    const Quantities found = solved(machine, corners, machine.known);
    Quantities kept;
    for (const SquarenessQuantity& q : machine.in_force)
        if (!has(found, q)) kept.push_back(q);
    return kept;
}

std::vector<Quantities> deviations_of(const TiltedMachine& machine, std::vector<Corner> corners) {
    std::vector<Quantities> all;
    std::vector<double> deviations;
    for (Corner& corner : corners) {
        corner.opening = 0;
        deviations.push_back(corner.uncertainty);
    }
    Quantities known = machine.known;
    for (SquarenessQuantity& q : known) q.angle = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        corners[i].opening = deviations[i];
        all.push_back(solved(machine, corners, known));
        corners[i].opening = 0;
    }
    for (SquarenessQuantity& q : known) {
        if (!q.uncertainty) continue;
        q.angle = *q.uncertainty;
        all.push_back(solved(machine, corners, known));
        q.angle = 0;
    }
    if (machine.measured_with_correction)  // otherwise they are among the known ones
        for (SquarenessQuantity q : kept_of(machine, corners)) {
            if (!q.uncertainty) continue;
            q.angle = *q.uncertainty;
            all.push_back({q});
        }
    return all;
}

}  // namespace

KinematicChain chain_of(const TiltedMachine& machine, const Quantities& quantities) {
    KinematicChain::Settings settings;
    settings.axes = machine.chain;
    settings.reading = machine.reading;
    settings.datum = machine.against;
    for (const SquarenessQuantity& q : quantities)
        settings.tilts[static_cast<std::size_t>(coordinate(q.axis))].angles[q.rotation] = q.angle;
    return KinematicChain(settings);
}

Lean lean_of(const SquarenessQuantity& quantity) {
    const std::vector<Lean> all =
        leans(quantity.axis, quantity.angle * Eigen::Vector3d::Unit(quantity.rotation));
    return all.empty() ? Lean{} : all.front();
}

SquarenessAdvice advice_on(const TiltedMachine& given) {
    compare(given.measured);
    const std::vector<Corner> corners = each_once(given.measured);
    TiltedMachine machine = given;
    if (!machine.measured_with_correction)
        for (const SquarenessQuantity& q : kept_of(given, corners)) machine.known.push_back(q);
    SquarenessAdvice advice;
    advice.quantities = quantities_of(machine, corners);
    const KinematicChain chain = chain_of(machine, advice.quantities);
    hold_against(chain, corners, advice.quantities);
    advice.options = "chain=" + machine.chain_text + (machine.inch ? " unit=inch" : "");
    advice.settled =
        machine.measured_with_correction ? added_to_force(machine, advice.quantities) : advice.quantities;
    advice.deviations = deviations_of(machine, corners);
    advice.settings = settings_of(machine, advice.settled);
    advice.slopes = chain.tip(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes.leftCols<3>();
    add_test_moves(chain, machine, corners, advice);
    advice.notes = notes_on(advice.quantities, corners);
    if (machine.measured_with_correction)
        for (const SquarenessQuantity& is : machine.in_force)
            for (const SquarenessQuantity& sum : advice.settled)
                if (sum.is_of(is.axis, is.rotation) && sum.angle != is.angle)
                    advice.notes.push_back(name_of(is) + ": " + arcsec(is.angle) + " is in force, and " +
                                           arcsec(sum.angle - is.angle) + " remained: the line sets " +
                                           arcsec(sum.angle) +
                                           ". The test move compares the lines in force with these.");
    return advice;
}

}  // namespace plumb::commissioning
