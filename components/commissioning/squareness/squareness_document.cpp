// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/squareness_document.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <vector>

#include "components/commissioning/squareness/squareness_wording.hpp"

namespace plumb::commissioning {
namespace {

using Json = nlohmann::ordered_json;

Json input_of(const SquarenessOptions& options) {
    const SquarenessGiven& given = options.given;
    const TiltedMachine& machine = options.machine;
    Json input{{"chain", machine.chain_text},
               {"unit", machine.inch ? "inch" : "mm"},
               {"reading", machine.reading == TiltReading::component ? "component" : "axis-direction"},
               {"against", machine.against == TiltDatum::rail ? "rail" : "bed"}};
    std::string datum;
    for (const Axis axis : machine.order) datum += (datum.empty() ? "" : ",") + letters(axis);
    input["datum"] = datum;
    input["travel"] = machine.travel;
    input["directions"] = options.directions.text();
    input["frame"] = name_of(options.frame);
    input["correction"] = machine.measured_with_correction ? "on" : "off";
    const auto angle = [](const char* name, const SquarenessGiven::Angle& its) {
        Json one{{name, its.name}, {"angle", its.angle}};
        if (!its.uncertainty.empty()) one["u"] = its.uncertainty;
        return one;
    };
    for (const char* const list : {"leans", "in_force", "measurements"}) input[list] = Json::array();
    for (const auto& its : given.leans) input["leans"].push_back(angle("lean", its));
    for (const auto& its : given.quantities) input["leans"].push_back(angle("name", its));
    for (const auto& its : given.in_force) input["in_force"].push_back(angle("name", its));
    const auto add = [&](const char* by, const std::vector<SquarenessGiven::Fields>& all) {
        for (const auto& its : all) {
            Json one{{"by", by}};
            for (const auto& [key, value] : its.fields) one[key] = value;
            input["measurements"].push_back(one);
        }
    };
    add("square", given.squares);
    add("diagonals", given.diagonals);
    add("opening", given.openings);
    add("points", given.points);
    return input;
}

Json quantities_json(const std::vector<SquarenessQuantity>& quantities) {
    Json all = Json::array();
    for (const SquarenessQuantity& q : quantities) {
        Json one{{"name", squareness_name(q.axis, q.rotation)}, {"angle", q.angle}};
        if (q.angle != 0) one["leans"] = name(lean_of(q));
        if (q.uncertainty) one["uncertainty"] = *q.uncertainty;
        all.push_back(one);
    }
    return all;
}

Json angle_json(const std::optional<SquarenessQuantity>& q) {
    if (!q) return nullptr;
    const double slope = slope_from_angle(q->angle);
    Json one{{"angle", q->angle},           {"leans", q->angle == 0 ? Json() : Json(name(lean_of(*q)))},
             {"um_per_m", slope * 1e6},     {"arcsec", arcsec_from_angle(q->angle)},
             {"mm_per_300mm", slope * 300}, {"in_per_ft", slope * 12}};
    one["U"] = q->uncertainty ? Json(2 * *q->uncertainty) : Json();
    return one;
}

Json lean_json(const LeanState& lean) {
    const Lean plus{lean.towards(), 1, 0}, minus{lean.towards(), -1, 0};
    const std::string quantity = squareness_name(lean.axis, lean.rotation);
    Json one{{"name", quantity},
             {"pin", lower_case(quantity)},
             {"axis", letters(lean.axis)},
             {"directions", {name(plus), name(minus)}},
             {"signs", {lean.sign(), -lean.sign()}},
             {"corrects", Json::array()},
             {"corrects_tool", Json::array()},
             {"can_correct", lean.useless.empty()},
             {"why_not", lean.useless.empty() ? Json() : Json(lean.useless)},
             {"measured", angle_json(lean.measured)},
             {"in_force", angle_json(lean.in_force)},
             {"settled", angle_json(lean.settled)},
             {"before", lean.settled ? Json(lean.before) : Json()},
             {"words", lean.words}};
    const auto effect = [&](const char* key, const char* of, const std::string& cause, int row,
                            double factor) {
        if (factor != 0)
            one[key].push_back({{of, cause}, {"error", std::string(1, "XYZ"[row])}, {"factor", factor}});
    };
    for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W})
        for (int row = 0; row < 3; ++row)
            if (coordinate(axis) < 3 || axis == lean.axis)
                effect("corrects", "moved", letters(axis), row, lean.effect.travel(row, coordinate(axis)));
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            effect("corrects_tool", "tool", std::string(1, "XYZ"[column]), row,
                   lean.effect.tool(row, column));
    return one;
}

Json corner_json(const CornerState& corner) {
    static constexpr const char* basis[] = {"none", "in force", "given", "measured"};
    return {{"axes", letters(corner.a) + letters(corner.b)},
            {"basis", basis[static_cast<int>(corner.basis)]},
            {"uncorrected", corner.uncorrected},
            {"before", corner.before},
            {"after", corner.basis == CornerState::Basis::none ? Json() : Json(0)},
            {"U", corner.uncertainty ? Json(2 * *corner.uncertainty) : Json()},
            {"words", corner.words}};
}

Json matrix_json(const Eigen::Matrix3d& matrix) {
    Json columns = Json::array();
    for (int column = 0; column < 3; ++column)
        columns.push_back({matrix(0, column), matrix(1, column), matrix(2, column)});
    return columns;
}

Json move_json(const SquarenessAdvice::TestMove& move) {
    Json one{{"quantity", squareness_name(move.quantity.axis, move.quantity.rotation)},
             {"moved", letters(move.moved)},
             {"base", move.base ? letters(*move.base) : ""},
             {"plunger", name(move.plunger)},
             {"travel", move.travel},
             {"rise", move.rise},
             {"wrong", Json::object()}};
    if (move.uncertainty) one["uncertainty"] = *move.uncertainty;
    for (const auto& wrong : move.single)
        one["wrong"][squareness_name(wrong.quantity.axis, wrong.quantity.rotation)] = wrong.rise;
    return one;
}

}  // namespace

std::string squareness_document(const SquarenessOptions& options, const TiltedMachine& machine,
                                const SquarenessAdvice& advice) {
    Json result{{"input", input_of(options)},
                {"chain", machine.chain_text},
                {"directions", options.directions.text()},
                {"quantities", quantities_json(advice.quantities)},
                {"settled", quantities_json(advice.settled)},
                {"deviations", Json::array()},
                {"settings", Json::array()},
                {"moves", Json::array()},
                {"unseen", advice.unseen},
                {"notes", advice.notes}};
    for (const auto& cause : advice.deviations) {
        Json its = Json::object();
        for (const SquarenessQuantity& q : cause)
            if (q.angle != 0) its[squareness_name(q.axis, q.rotation)] = q.angle;
        result["deviations"].push_back(its);
    }
    for (const auto* branch : {&machine.chain.work, &machine.chain.tool}) {
        std::string axes;
        for (const Axis axis : *branch) axes += letter(axis);
        result[branch == &machine.chain.work ? "work" : "tool"] = axes;
    }
    for (const SquarenessAdvice::Setting& setting : advice.settings)
        if (setting.in_force) result["settings"].push_back({{"pin", setting.pin}, {"value", setting.value}});
    for (const SquarenessAdvice::TestMove& move : advice.moves) result["moves"].push_back(move_json(move));
    result["slopes"] = matrix_json(advice.slopes);
    const SquarenessState state = state_of(machine, advice);
    result["slopes_before"] = matrix_json(state.slopes_before);
    for (const char* const list : {"leans", "corners"}) result[list] = Json::array();
    for (const LeanState& lean : state.leans) result["leans"].push_back(lean_json(lean));
    for (const CornerState& corner : state.corners) result["corners"].push_back(corner_json(corner));
    result["words"] = state.words;
    result["errors"] = errors_of(machine, state).json();
    return result.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace plumb::commissioning
