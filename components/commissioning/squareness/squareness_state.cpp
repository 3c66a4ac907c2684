// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/squareness_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/commissioning/squareness/squareness_of_chain.hpp"
#include "components/commissioning/squareness/squareness_wording.hpp"

namespace plumb::commissioning {
namespace {

using Quantities = std::vector<SquarenessQuantity>;
using Basis = CornerState::Basis;

constexpr const char* without_straightness = ", straightness not included";

std::optional<SquarenessQuantity> found(const Quantities& quantities, Axis axis, int rotation) {
    for (const SquarenessQuantity& q : quantities)
        if (q.is_of(axis, rotation)) return q;
    return {};
}

double deviation_of(const SquarenessAdvice& advice, Axis axis, int rotation) {
    double variance = 0;
    for (const Quantities& deviation : advice.deviations)
        if (const auto q = found(deviation, axis, rotation)) variance += q->angle * q->angle;
    return std::sqrt(variance);
}

// A length over 1 m, or 1 ft, that an angle opens.
struct OverLength {
    bool inch;

    std::string value(double angle) const {
        const std::string text = inch ? formatted("%+.5f", angle * 12) : formatted("%+.1f", angle * 1e6);
        return text.find_first_of("123456789") == std::string::npos ? "0" : text;
    }
    // Never less than it is: two digits, rounded up.
    std::string uncertainty(double angle) const {
        const double length = angle * (inch ? 12 : 1e6);
        if (!(length > 0)) return "0";
        const double digit = std::pow(10, std::floor(std::log10(length)) - 1);
        const double rounded = std::ceil(length / digit - 1e-6) * digit;
        return inch ? formatted("%.7g", rounded) : formatted("%.6g", rounded);
    }
    std::string unit() const { return inch ? " in over 1 ft" : " um over 1 m"; }
};

std::string words_of(double before, std::optional<double> uncertainty, Basis basis, const OverLength& over) {
    const std::string words = "before: " + over.value(before) + over.unit() + "; after: 0";
    if (uncertainty)
        return words + " \u00b1 " + over.uncertainty(2 * *uncertainty) + over.unit() + without_straightness;
    return words + over.unit() + " if the " + (basis == Basis::given ? "given angle" : "angle in force") +
           " is right" + without_straightness;
}

std::vector<LeanState> leans_of(const TiltedMachine& machine, const SquarenessAdvice& advice,
                                const OverLength& over) {
    std::vector<LeanState> leans;
    for (const AxisBranch& branch : {machine.chain.work, machine.chain.tool})
        for (const Axis axis : branch)
            for (const Axis towards : {Axis::X, Axis::Y, Axis::Z}) {
                if (parallel(axis, towards)) continue;
                const int rotation = 3 - direction(axis) - direction(towards);
                LeanState lean;
                lean.axis = axis;
                lean.rotation = rotation;
                lean.effect = effect_of_tilt(machine.chain, machine.reading, machine.against, axis, rotation);
                lean.useless = useless_because(machine, axis, rotation);
                lean.in_force = found(machine.in_force, axis, rotation);
                lean.settled = found(advice.settled, axis, rotation);
                const auto known = found(machine.known, axis, rotation);
                const auto quantity = found(advice.quantities, axis, rotation);
                if (known)
                    lean.measured = known;
                else if (quantity && quantity->uncertainty)
                    lean.measured = quantity;
                if (lean.measured && lean.measured->uncertainty)
                    lean.measured->uncertainty = deviation_of(advice, axis, rotation);
                if (lean.settled) {
                    const auto& source = lean.measured ? lean.measured : lean.in_force;
                    if (source) lean.settled->uncertainty = source->uncertainty;
                }
                if (lean.settled) {
                    lean.before = lean.settled->angle - (lean.in_force ? lean.in_force->angle : 0);
                    lean.words = words_of(lean.before, lean.settled->uncertainty,
                                          lean.measured ? Basis::given : Basis::in_force, over);
                }
                leans.push_back(lean);
            }
    return leans;
}

// The corner was measured, or a lean of one of its own axes is given or in force and opens it.
Basis basis_of(const TiltedMachine& machine, const std::vector<LeanState>& leans, CornerState& corner) {
    for (const Corner& measured : machine.measured)
        if (measured.is_of(corner.a, corner.b)) return Basis::measured;
    Basis basis = Basis::none;
    for (const LeanState& lean : leans) {
        if (lean.effect.opening(corner.a, corner.b) == 0) continue;
        if (lean.axis != corner.a && lean.axis != corner.b) continue;
        if (found(machine.known, lean.axis, lean.rotation))
            basis = std::max(basis, Basis::given);
        else if (lean.in_force && (lean.in_force->angle != 0 || lean.in_force->uncertainty))
            basis = std::max(basis, Basis::in_force);
    }
    return basis;
}

// Whether each lean that opens the corner has an uncertainty.
bool is_certain(const std::vector<LeanState>& leans, const CornerState& corner) {
    if (corner.basis == Basis::measured) return true;
    return std::all_of(leans.begin(), leans.end(), [&](const LeanState& lean) {
        return lean.effect.opening(corner.a, corner.b) == 0 || !lean.settled || lean.settled->uncertainty ||
               (lean.settled->angle == 0 && !lean.measured);
    });
}

std::string names_of(const CornerState& corner) {
    return letters(corner.a) + letters(corner.b);
}

// Of the corner that is least certain; then those that nothing is known of.
std::string summary(const std::vector<CornerState>& corners) {
    const CornerState* worst = nullptr;
    std::string open;
    const auto doubt = [](const CornerState& corner) {
        return corner.uncertainty.value_or(std::numeric_limits<double>::infinity());
    };
    for (const CornerState& corner : corners) {
        if (corner.basis == Basis::none)
            open += (open.empty() ? "not measured: " : ", ") + names_of(corner);
        else if (!worst || doubt(corner) > doubt(*worst))
            worst = &corner;
    }
    if (!worst) return open;
    return names_of(*worst) + ' ' + worst->words + (open.empty() ? "" : "; ") + open;
}

}  // namespace

int LeanState::sign() const noexcept {
    return turning(axis, {towards(), 1, 0})[rotation] > 0 ? 1 : -1;
}

std::string useless_because(const TiltedMachine& machine, Axis axis, int rotation) {
    const TiltEffect effect = effect_of_tilt(machine.chain, machine.reading, machine.against, axis, rotation);
    if (effect.shows_in_travel()) return "";
    const Axis base = static_cast<Axis>(3 - direction(axis) - rotation);
    const AxisBranch& branch = machine.chain.tool.has(axis) ? machine.chain.tool : machine.chain.work;
    std::string carried;
    for (const Axis* each = std::find(branch.begin(), branch.end(), axis) + 1; each < branch.end(); ++each)
        carried += (carried.empty() ? "" : ", ") + letters(*each);
    carried += carried.empty() ? "" : " and ";
    carried += machine.chain.tool.has(axis) ? "the tool" : "the work";
    return letters(axis) + " turns " + carried + " with it: the angles between the axes stay, and a " +
           "correction moves no axis" + (effect.shows_in_tool() ? " but for the offset of a tool" : "") +
           ". If a square of " + letters(axis) + " and " + letters(base) +
           " showed a lean, give its readings as a measurement.";
}

SquarenessState state_of(const TiltedMachine& machine, const SquarenessAdvice& advice) {
    SquarenessState state;
    const KinematicChain truth = chain_of(machine, advice.settled);
    const KinematicChain corrected = chain_of(machine, machine.in_force);
    const OverLength over{machine.inch};
    state.leans = leans_of(machine, advice, over);
    for (std::size_t late = 0; late < machine.order.size(); ++late)
        for (std::size_t early = 0; early < late; ++early) {
            CornerState corner;
            corner.a = machine.order[early];
            corner.b = machine.order[late];
            if (parallel(corner.a, corner.b)) continue;
            corner.basis = basis_of(machine, state.leans, corner);
            corner.uncorrected = opening_of(truth, corner.a, corner.b);
            corner.before = corner.uncorrected - opening_of(corrected, corner.a, corner.b);
            double variance = 0;
            for (const Quantities& deviation : advice.deviations)
                variance += std::pow(opening_of(chain_of(machine, deviation), corner.a, corner.b), 2);
            if (corner.basis != Basis::none && is_certain(state.leans, corner))
                corner.uncertainty = std::sqrt(variance);
            corner.words = corner.basis == Basis::none
                               ? "not measured"
                               : words_of(corner.before, corner.uncertainty, corner.basis, over);
            state.corners.push_back(corner);
        }
    const auto slopes = [](const KinematicChain& chain) {
        return Eigen::Matrix3d(chain.tip(AxisPosition::Zero(), Eigen::Vector3d::Zero()).slopes.leftCols<3>());
    };
    state.slopes_before = slopes(truth) - slopes(corrected) + Eigen::Matrix3d::Identity();
    state.words = summary(state.corners);
    return state;
}

ErrorList errors_of(const TiltedMachine& machine, const SquarenessState& state) {
    ErrorList list(machine.chain);
    for (const CornerState& corner : state.corners) {
        if (corner.basis == Basis::none) continue;
        std::string name = names_of(corner), how;
        if (name[0] > name[1]) std::swap(name[0], name[1]);
        for (std::size_t i = 0; i < machine.instruments.size(); ++i)
            if (machine.measured[i].is_of(corner.a, corner.b))
                how += (how.empty() ? "" : "; ") + machine.instruments[i];
        if (how.empty() && corner.basis == Basis::measured) how = "a measurement";
        if (how.empty()) how = corner.basis == Basis::given ? "an angle that you gave" : "the angle in force";
        ErrorList::set(list.line(ErrorLine::Kind::corner, name), ErrorLine::State::measured,
                       corner.uncertainty.value_or(0), how);
    }
    return list;
}

}  // namespace plumb::commissioning
