// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/squareness_corrections.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/geometry/tip_correction.hpp"

namespace plumb::commissioning {
namespace {

using Json = nlohmann::ordered_json;

// The inputs of the component by their names; one that is not there is 0.
class State {
public:
    explicit State(const Json& pins) : pins_(pins) {
        if (!pins.is_object()) throw std::runtime_error("states: it is no object { }");
    }

    double number(const std::string& pin) const {
        const auto its = pins_.find(pin);
        if (its == pins_.end()) return 0;
        if (its->is_boolean()) return its->get<bool>();
        if (!its->is_number()) throw std::runtime_error(pin + ": it is no number");
        return its->get<double>();
    }
    bool on(const std::string& pin) const { return number(pin) != 0; }
    // Of X, Y and Z.
    Eigen::Vector3d vector(const std::string& stem) const {
        return {number("x-" + stem), number("y-" + stem), number("z-" + stem)};
    }
    // The tilts EA0, EB0 and EC0 of an axis, or its places EX0, EY0 and EZ0.
    Eigen::Vector3d errors(const std::string& names, const std::string& axis) const {
        Eigen::Vector3d result;
        for (int i = 0; i < 3; ++i)
            result[i] = number(std::string("e") + names[static_cast<std::size_t>(i)] + "0" + axis);
        return result;
    }
    Eigen::Vector3d tilts(const std::string& axis) const {
        const double most = number("max-angle");
        return errors("abc", axis).unaryExpr([most](double angle) { return bounded(angle, most); });
    }

private:
    const Json& pins_;
};

std::string pin_letter(Axis axis) {
    return std::string(1, static_cast<char>(std::tolower(letter(axis))));
}

RotaryPlace place_of(const State& its, Axis axis, bool carries_work) {
    const std::string name = pin_letter(axis);
    RotaryPlace place{
        {its.number(name + "-x-pivot"), its.number(name + "-y-pivot"), its.number(name + "-z-pivot")},
        its.errors("xyz", name),
        its.tilts(name)};
    if (carries_work) place.angles[direction(axis)] *= -1;  // as its angle
    return place;
}

Json correction_of(const AxisChain& chain, const State& its) {
    KinematicChain::Settings s;
    s.axes = chain;
    s.reading = its.on("axis-direction") ? TiltReading::axis_direction : TiltReading::component;
    s.datum = its.on("to-bed") ? TiltDatum::bed : TiltDatum::rail;
    AxisPosition q = AxisPosition::Zero();
    for (const AxisBranch* branch : {&chain.work, &chain.tool}) {
        for (const Axis axis : *branch) {
            const std::string name = pin_letter(axis);
            s.tilts[static_cast<std::size_t>(coordinate(axis))] = {its.tilts(name),
                                                                   its.on(name + "-tool-follows")};
            q[coordinate(axis)] = its.number(name + "-position") - its.number(name + "-pivot");
        }
        for (const Axis axis : branch->members)
            if (rotary(axis))
                s.places[static_cast<std::size_t>(direction(axis))] =
                    place_of(its, axis, branch == &chain.work);
    }
    TipCorrection correction(s, -its.vector("reference-tool-offset"));
    if (correction.chain().has_rotary())
        for (const Axis axis : {Axis::A, Axis::B, Axis::C}) {
            const std::string name = pin_letter(axis);
            if (chain.has(axis))
                correction.chain().set_angle(
                    axis, (its.on(name + "-reversed") ? -1 : 1) * its.number(name + "-position"));
        }
    const double turn = std::remainder(its.number("radial-direction"), 360) * (pi / 180),
                 radius = its.number("radial-offset") / (its.on("radial-is-diameter") ? 2 : 1);
    const Eigen::Vector3d tool =
        radius * Eigen::Vector3d(std::cos(turn), std::sin(turn), 0) - its.vector("tool-offset");

    const auto along = chain.parallel_axis();
    const bool shares = along && its.on("parallel-axis-corrects"),
               active = its.on("enable") && its.on("all-homed");
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    TipCorrection::Share share{0, 0};
    for (int step = 0; step < 3; ++step) {
        if (shares) share = correction.share(*along, q, share.offset);
        offset = correction.at(q, tool, offset, share).offset;
    }
    const double most = active ? its.number("max-correction") : 0;
    Json result{
        {"X", bounded(offset[0], most)}, {"Y", bounded(offset[1], most)}, {"Z", bounded(offset[2], most)}};
    if (along) result[std::string(1, letter(*along))] = shares ? bounded(share.offset, most) : 0.0;
    return result;
}

}  // namespace

std::string squareness_corrections(std::string_view document) {
    Json given;
    try {
        given = Json::parse(document.begin(), document.end());
    } catch (const Json::exception& error) {
        throw std::runtime_error(std::string("no JSON: ") + error.what());
    }
    if (!given.is_object() || !given.value("states", Json()).is_array())
        throw std::runtime_error("states: there is no list of them");
    const AxisChain chain = AxisChainReader::read(given.value("chain", ""), given.value("rotary", ""));
    Json corrections = Json::array();
    for (const Json& state : given["states"]) corrections.push_back(correction_of(chain, State(state)));
    return Json{{"corrections", corrections}}.dump();
}

}  // namespace plumb::commissioning
