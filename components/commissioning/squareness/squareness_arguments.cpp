// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/squareness_arguments.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "components/commissioning/quantity_text.hpp"
#include "components/commissioning/squareness/squareness_wording.hpp"
#include "components/io/files/probed_points_file.hpp"
#include "components/math/geometry/square_readings.hpp"

namespace plumb::commissioning {
namespace {

using Words = std::vector<std::string>;

[[noreturn]] void refuse(const std::string& why) {
    throw std::invalid_argument(why);
}

std::string quoted(const std::string& text) {
    return '\'' + text + '\'';
}

std::string listed(const Words& words) {
    std::string result;
    for (const std::string& word : words) result += (result.empty() ? "" : ", ") + word;
    return result;
}

Axis axis_of(const std::string& text, const AxisChain& chain) {
    const std::string all = "XYZUVW";
    const std::size_t at = text.size() == 1 ? all.find(text[0]) : std::string::npos;
    if (at == std::string::npos) refuse(quoted(text) + " is no axis: there are X Y Z U V W");
    const auto axis = static_cast<Axis>(at);
    if (!chain.has(axis)) refuse("the chain has no axis " + text);
    return axis;
}

// Y+X, +X: an axis, and the end of X, Y or Z to which it leans.
Lean lean_of(const std::string& text) {
    const std::string all = "XYZ";
    const std::size_t at = text.size() == 2 ? all.find(text[1]) : std::string::npos;
    if (at == std::string::npos || (text[0] != '+' && text[0] != '-'))
        refuse(quoted(text) + " is no direction: there are +X -X +Y -Y +Z -Z");
    return {static_cast<Axis>(at), text[0] == '+' ? 1 : -1, 0};
}

std::pair<std::string, std::string> split(const std::string& text, char mark, const std::string& form) {
    const std::size_t at = text.find(mark);
    if (at == std::string::npos) refuse(quoted(text) + " is not " + form);
    return {text.substr(0, at), text.substr(at + 1)};
}

constexpr double least_length = 1e-6;  // mm, of an uncertainty

// Reads key=value,key=value,...
std::vector<std::pair<std::string, std::string>> fields_of(const std::string& text) {
    std::vector<std::pair<std::string, std::string>> fields;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ',');) fields.push_back(split(part, '=', "KEY=VALUE"));
    return fields;
}

class Fields {
public:
    Fields(const SquarenessGiven::Fields& given, const Words& keys) {
        for (const auto& [key, value] : given.fields) {
            if (std::find(keys.begin(), keys.end(), key) == keys.end())
                refuse("there is no " + quoted(key) + "; there are " + listed(keys));
            if (value.empty()) refuse(key + " has no value");
            if (!values_.emplace(key, value).second) refuse(key + " is there twice");
        }
    }

    bool has(const std::string& key) const { return values_.count(key) != 0; }

    std::string text(const std::string& key) const {
        if (!has(key)) refuse(key + " is missing");
        return values_.at(key);
    }

    // Returns read(value); an error names the key.
    template <class Read>
    auto read(const std::string& key, Read read_value) const {
        const std::string value = text(key);
        try {
            return read_value(value);
        } catch (const std::invalid_argument& error) {
            refuse(key + ": " + error.what());
        }
    }

    double length(const std::string& key) const {
        return read(key, [](const std::string& value) { return length_of(value); });
    }
    std::vector<double> lengths(const std::string& key) const { return read(key, lengths_of); }
    double angle(const std::string& key) const { return read(key, angle_of); }

    // Standard, of u, or of twice that, U.
    double uncertainty() const {
        if (has("u") == has("U"))
            refuse("one of u, the standard uncertainty, and U, which is twice that, is wanted");
        const double value = has("u") ? length("u") : length("U") / 2;
        if (!(value >= least_length))
            refuse((has("u") ? "u=" + text("u") : "U=" + text("U")) + " is less than anybody can measure");
        return value;
    }

    MeasuredObject object() const {
        const std::string value = text("object");
        if (value == "part") return MeasuredObject::part;
        if (value == "artifact") return MeasuredObject::artifact;
        refuse("object=" + value +
               " is neither part, which these axes have drawn, nor artifact, which is true and was measured "
               "with them");
    }

private:
    std::map<std::string, std::string> values_;
};

std::string object_name(MeasuredObject object) {
    return object == MeasuredObject::part ? "a part" : "an artifact";
}

double own_angle(const std::string& text) {
    const double angle = angle_of(text);
    if (!(angle >= 1e-9 && angle < 0.1))
        refuse(quoted(text) + " is no uncertainty: from 1e-9 to 0.1 rad is possible");
    return angle;
}

std::pair<Axis, Axis> plane_of(const Fields& fields, const AxisChain& chain) {
    const std::string plane = fields.text("plane");
    if (plane.size() != 2) refuse("plane=" + plane + " is not two axes such as XY");
    const Axis a = axis_of(plane.substr(0, 1), chain), b = axis_of(plane.substr(1), chain);
    if (parallel(a, b)) refuse("plane=" + plane + ": the axes are parallel and span no plane");
    return {a, b};
}

// A corner that another program or instrument gives: a ballbar, body diagonals.
SquarenessOptions::Measured opening_of(const SquarenessGiven::Fields& given, const AxisChain& chain) {
    const Fields fields(given, {"plane", "object", "angle", "u", "U"});
    const auto [a, b] = plane_of(fields, chain);
    Corner corner{a, b, fields.angle("angle"), 0};
    if (!(std::abs(corner.opening) < 0.1)) refuse("angle=" + fields.text("angle") + " is not below 0.1 rad");
    if (fields.has("u") == fields.has("U"))
        refuse("one of u, the standard uncertainty, and U, which is twice that, is wanted");
    corner.uncertainty = fields.has("u") ? fields.read("u", own_angle) : fields.read("U", own_angle) / 2;
    const MeasuredObject object = fields.object();
    if (object == MeasuredObject::artifact) corner.opening = -corner.opening;
    return {corner, "the opening of " + object_name(object)};
}

SquarenessOptions::Measured diagonals_of(const SquarenessGiven::Fields& given, const AxisChain& chain) {
    const Fields fields(given, {"plane", "object", "rising", "falling", "sides", "u", "U", "own", "own-u"});
    const auto [a, b] = plane_of(fields, chain);
    Diagonals d;
    d.rising = fields.length("rising");
    d.falling = fields.length("falling");
    if (fields.has("sides")) {
        const std::vector<double> sides = fields.lengths("sides");
        if (sides.size() != 2)
            refuse("sides=" + fields.text("sides") + " is not two lengths such as 400:300mm");
        d.a = sides[0];
        d.b = sides[1];
        if (!(d.a > 0 && d.b > 0)) refuse("sides=" + fields.text("sides") + ": a side is not longer than 0");
    }
    d.uncertainty = fields.uncertainty();
    const MeasuredObject object = fields.object();
    for (const char* key : {"own", "own-u"})
        if (object == MeasuredObject::part && fields.has(key))
            refuse(std::string(key) + " is of an artifact, and object=part");
    if (fields.has("own")) d.own_opening = fields.angle("own");
    if (fields.has("own-u")) d.own_uncertainty = fields.read("own-u", own_angle);
    std::string how = "diagonals of " + object_name(object);
    if (object == MeasuredObject::artifact && !fields.has("own-u")) how += ", taken as true";
    return {corner_from_diagonals(a, b, d, object), how};
}

SquarenessOptions::Measured square_of(const SquarenessGiven::Fields& given, const AxisChain& chain) {
    const Fields fields(given, {"move", "plunger", "at", "reads", "turned", "u", "U", "own-u"});
    SquareReadings square;
    square.moved = axis_of(fields.text("move"), chain);
    square.plunger = fields.read("plunger", [](const std::string& value) { return lean_of(value); });
    square.positions = fields.lengths("at");
    square.readings = fields.lengths("reads");
    if (fields.has("turned")) square.turned = fields.lengths("turned");
    square.uncertainty = fields.uncertainty();
    if (fields.has("own-u")) square.square_uncertainty = fields.read("own-u", own_angle);
    std::string how = "square and indicator";
    if (fields.has("turned"))
        how += ", square turned";
    else if (!fields.has("own-u"))
        how += ", the square taken as true";
    const Corner corner = corner_from_square(square);
    if (!(std::abs(corner.opening) < 0.1)) refuse("the readings rise too steeply: is each in its unit?");
    return {corner, how};
}

SquarenessOptions::Points points_of(const SquarenessGiven::Fields& given) {
    const Fields fields(given, {"file", "object", "unit", "u", "U", "own-u"});
    SquarenessOptions::Points points;
    points.file = fields.text("file");
    if (fields.has("unit")) {
        const std::string unit = fields.text("unit");
        if (unit != "mm" && unit != "in") refuse("unit=" + unit + " is neither mm nor in");
        points.unit = unit == "mm" ? 1 : 25.4;
    }
    points.shape.uncertainty = fields.uncertainty();
    points.shape.object = fields.object();
    if (fields.has("own-u")) {
        if (points.shape.object == MeasuredObject::part) refuse("own-u is of an artifact, and object=part");
        points.own = fields.text("own-u");
    }
    return points;
}

SquarenessQuantity quantity_of(const SquarenessGiven::Angle& given, const AxisChain& chain) {
    const auto& [where, name, value, uncertainty] = given;
    if (name.size() != 4 || name[0] != 'E' || name[2] != '0' || name[1] < 'A' || name[1] > 'C')
        refuse(quoted(name) + " is no quantity of ISO 230-1 such as EC0Y");
    SquarenessQuantity quantity{axis_of(name.substr(3), chain), name[1] - 'A', angle_of(value), {}};
    if (!uncertainty.empty()) quantity.uncertainty = own_angle(uncertainty);
    if (direction(quantity.axis) == quantity.rotation)
        refuse(name + " turns " + letters(quantity.axis) + " about itself: that is no lean");
    if (!(std::abs(quantity.angle) < 0.1)) refuse(quoted(value) + " is not an angle below 0.1 rad");
    return quantity;
}

// All axes of the chain: those that are named first, then X Y Z U V W.
std::vector<Axis> order_of(const std::string& text, const AxisChain& chain) {
    std::vector<Axis> order;
    std::istringstream names(text);
    for (std::string name; std::getline(names, name, ',');) {
        const Axis axis = axis_of(name, chain);
        if (std::find(order.begin(), order.end(), axis) != order.end()) refuse(name + " is named twice");
        order.push_back(axis);
    }
    for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W})
        if (chain.has(axis) && std::find(order.begin(), order.end(), axis) == order.end())
            order.push_back(axis);
    return order;
}

// Y=0:1200
SquarenessOptions::Gantry gantry_of(const std::string& text, const AxisChain& chain) {
    const std::size_t equals = text.find('='), colon = text.find(':');
    if (equals == std::string::npos || colon == std::string::npos || colon < equals)
        refuse("has no form as Y=0mm:1200mm");
    const Axis drive = axis_of(text.substr(0, equals), chain);
    const Axis* const end = chain.tool.end();
    const Axis* const its = std::find(chain.tool.begin(), end, drive);
    const Axis* const across = its == end ? end : std::find_if(its + 1, end, [&](Axis a) { return !parallel(a, drive); });
    if (across == end) refuse("names an axis that carries no beam on the tool's side of the chain");
    SquarenessOptions::Gantry result{drive, *across, length_of(text.substr(equals + 1, colon - equals - 1)),
                                     length_of(text.substr(colon + 1))};
    if (!(result.second - result.first >= 10)) refuse("has motors that are less than 10 mm apart, or in the wrong order");
    return result;
}

// Turns an error of a text into an error of the command line.
template <class Read>
void read(const std::string& where, const std::string& text, Read read_text) {
    try {
        read_text();
    } catch (const std::invalid_argument& error) {
        const std::string words = error.what();
        const bool named = text.empty() || words.find(text) != std::string::npos;
        throw CLI::ValidationError(where, (named ? "" : quoted(text) + ": ") + words);
    }
}

// The words of the options that may be given many times.
struct Arguments {
    SquarenessGiven given;
    Words leans, quantities, in_force, diagonals, squares, openings, points;
};

void add_once(const SquarenessQuantity& quantity, std::vector<SquarenessQuantity>& to) {
    for (const SquarenessQuantity& other : to)
        if (other.is_of(quantity.axis, quantity.rotation))
            refuse(squareness_name(quantity.axis, quantity.rotation) + " is set twice");
    to.push_back(quantity);
}

void read_tilts(const SquarenessGiven& given, TiltedMachine& machine) {
    std::map<Axis, std::vector<Lean>> leans;
    for (const SquarenessGiven::Angle& its : given.leans) {
        read(its.where, its.text(), [&] {
            const std::size_t sign = its.name.find_first_of("+-");
            if (sign == std::string::npos)
                refuse(quoted(its.name) + " is not an axis and a direction, such as Y+X");
            const Axis axis = axis_of(its.name.substr(0, sign), machine.chain);
            Lean lean = lean_of(its.name.substr(sign));
            lean.angle = angle_of(its.angle);
            leans[axis].push_back(lean);
            plumb::squareness(axis, leans[axis]);  // throws
            const Eigen::Vector3d angles = plumb::squareness(axis, {lean});
            const int rotation = 3 - direction(axis) - direction(lean.towards);
            SquarenessQuantity quantity{axis, rotation, angles[rotation], {}};
            if (!its.uncertainty.empty()) quantity.uncertainty = own_angle(its.uncertainty);
            add_once(quantity, machine.known);
        });
    }
    for (const SquarenessGiven::Angle& its : given.quantities)
        read(its.where, its.text(), [&] { add_once(quantity_of(its, machine.chain), machine.known); });
    for (const SquarenessGiven::Angle& its : given.in_force)
        read(its.where, its.text(), [&] { add_once(quantity_of(its, machine.chain), machine.in_force); });
}

// Other usual notations in ours: with primes, brackets, blanks, a spindle such as (C) or C1, without hyphens,
// or from the tool to the work. Empty if the letters are no chain.
std::string usual_chain(const std::string& text) {
    std::string letters;
    for (const char c : text)
        if (std::isalpha(static_cast<unsigned char>(c))) letters += c;
    const auto count = [&](char c) { return std::count(letters.begin(), letters.end(), c); };
    if (letters.empty() || count('b') != 1 || count('t') != 1 || count('w') > 1) return "";
    if (letters.front() == 't') std::reverse(letters.begin(), letters.end());
    std::string result;
    for (const char c : letters) {
        if (!result.empty()) result += c == 'b' ? '.' : '-';
        result += c;
    }
    return result;
}

void read_chain(const std::string& text, TiltedMachine& machine) {
    machine.chain_text = text;
    try {
        machine.chain = AxisChainReader::read_linear(text);
        return;
    } catch (const std::invalid_argument&) {
        const std::string usual = usual_chain(text);
        if (usual.empty() || usual == text) throw;
        try {
            machine.chain = AxisChainReader::read_linear(usual);
        } catch (const std::invalid_argument& error) {
            refuse("read as " + usual + ": " + error.what());
        }
        machine.chain_text = usual;
    }
}

// Each of the words of an option.
template <class Each>
void split_words(const std::string& option, const Words& words, Each each) {
    for (const std::string& text : words) read(option, text, [&] { each(text); });
}

SquarenessGiven given_by(const Arguments& arguments) {
    SquarenessGiven given = arguments.given;
    const auto angles = [](const std::string& option, const Words& words, const std::string& form,
                           std::vector<SquarenessGiven::Angle>& to) {
        split_words(option, words, [&](const std::string& text) {
            const auto [name, angle] = split(text, '=', form);
            to.push_back({option, name, angle, ""});
        });
    };
    const std::string quantity = "NAME=ANGLE, such as EC0Y=-12.5arcsec";
    angles("--lean", arguments.leans, "AXIS and direction=ANGLE, such as Y+X=0.02mm/300mm", given.leans);
    angles("--iso", arguments.quantities, quantity, given.quantities);
    angles("--in-force", arguments.in_force, quantity, given.in_force);
    const auto fields = [](const std::string& option, const Words& words,
                           std::vector<SquarenessGiven::Fields>& to) {
        split_words(option, words, [&](const std::string& text) {
            to.push_back({option, fields_of(text), text});
        });
    };
    fields("--diagonals", arguments.diagonals, given.diagonals);
    fields("--square", arguments.squares, given.squares);
    fields("--opening", arguments.openings, given.openings);
    fields("--points", arguments.points, given.points);
    return given;
}

}  // namespace

SquarenessOptions::Measured measured_by(const SquarenessOptions::Points& points, const AxisChain& chain) {
    ProbedPointsFile file = read_probed_points(points.file, points.unit);
    ProbedShape shape = points.shape;
    shape.a = file.shape.a;
    shape.b = file.shape.b;
    shape.ring = file.shape.ring;
    shape.points = file.shape.points;
    const auto refuse_file = [&](const std::string& why) {
        throw std::runtime_error(points.file + ": " + why);
    };
    for (const Axis axis : {shape.a, shape.b})
        if (!chain.has(axis)) refuse_file("the chain has no axis " + letters(axis));
    const bool turned = std::any_of(shape.points.begin(), shape.points.end(),
                                    [&](const auto& p) { return p.turned != shape.points[0].turned; });
    if (turned && shape.object == MeasuredObject::part)
        refuse_file("an artifact is turned, not a part, and object=part");
    if (!points.own.empty())
        shape.own_uncertainty = shape.ring ? length_of(points.own) : own_angle(points.own);
    if (shape.ring && shape.own_uncertainty && !(*shape.own_uncertainty >= least_length))
        refuse_file("own-u=" + points.own + " is less than anybody can measure");
    std::string how = std::to_string(shape.points.size()) + " points " +
                      (shape.ring ? "around a ring" : "on the faces of " + object_name(shape.object));
    if (shape.ring && shape.object == MeasuredObject::part) how += " that was cut";
    if (turned)
        how += ", turned";
    else if (shape.object == MeasuredObject::artifact && !shape.own_uncertainty)
        how += ", taken as true";
    try {
        const ProbedCorner found = corner_from_shape(shape);
        if (found.corner.scatter > 1.5)
            how += "; line " + std::to_string(file.lines[found.worst]) + " lies furthest off, by " +
                   formatted("%+.2g mm", found.distance);
        return {found.corner, how};
    } catch (const ProbedMisfit& misfit) {
        throw std::runtime_error(points.file + ": line " + std::to_string(file.lines[misfit.fitted.worst]) +
                                 ": the points do not lie on such a shape; this one is " +
                                 formatted("%+.3g mm", misfit.fitted.distance) + " off, and all scatter " +
                                 formatted("%.3g", misfit.fitted.corner.scatter) +
                                 " times u: check normal, and the unit of u");
    } catch (const std::invalid_argument& error) {
        throw std::runtime_error(points.file + ": " + error.what());
    }
}

void take_squareness(const SquarenessGiven& given, SquarenessOptions& options) {
    options.given = given;
    TiltedMachine& machine = options.machine;
    read(given.chain.where, "", [&] { read_chain(given.chain.text, machine); });
    read(given.datum.where, given.datum.text,
         [&] { machine.order = order_of(given.datum.text, machine.chain); });
    if (!given.gantry.text.empty())
        read(given.gantry.where, given.gantry.text,
             [&] { options.gantry = gantry_of(given.gantry.text, machine.chain); });
    read(given.travel.where, given.travel.text, [&] {
        machine.travel =
            given.travel.text.empty() ? (machine.inch ? 12 * 25.4 : 300) : length_of(given.travel.text);
        if (!(machine.travel > 0)) refuse("is not longer than 0");
    });
    read(given.directions.where, given.directions.text,
         [&] { options.directions = ViewDirections(given.directions.text); });
    read_tilts(given, machine);
    for (const SquarenessGiven::Fields& its : given.diagonals)
        read(its.where, its.text, [&] { options.measured.push_back(diagonals_of(its, machine.chain)); });
    for (const SquarenessGiven::Fields& its : given.squares)
        read(its.where, its.text, [&] { options.measured.push_back(square_of(its, machine.chain)); });
    for (const SquarenessGiven::Fields& its : given.openings)
        read(its.where, its.text, [&] { options.measured.push_back(opening_of(its, machine.chain)); });
    for (const SquarenessGiven::Fields& its : given.points)
        read(its.where, its.text, [&] { options.points.push_back(points_of(its)); });
}

void declare_squareness(CLI::App& command, SquarenessOptions& options) {
    const auto arguments = std::make_shared<Arguments>();
    const auto add_list = [&](const std::string& name, Words& words, const std::string& type,
                              const std::string& text) {
        command.add_option(name, words, text)->allow_extra_args(false)->type_name(type);
    };
    command
        .add_option("--chain", arguments->given.chain.text,
                    "The axes from the work over the bed to the tool, in the notation of ISO 10791 without "
                    "primes: w-Z.b-X-Y-C-t. By default w-X-Y.b-Z-C-t. Notations such as [w-Z'-b-X-Y-(C)-t] "
                    "and bXY(C)t "
                    "are understood.")
        ->type_name("CHAIN");
    add_list("--lean", arguments->leans, "TILT",
             "An axis, the direction towards which its + end leans, and the angle: Y+X=0.02mm/300mm. May be "
             "given many times, for each axis and line once.");
    add_list("--iso", arguments->quantities, "NAME=ANGLE",
             "A quantity of ISO 230-1, with its sign: EC0Y=-13.75arcsec. May be given many times.");
    add_list(
        "--diagonals", arguments->diagonals, "FIELDS",
        "Two axes, by the diagonals of a square or rectangle. May be given many times, as the next three.");
    add_list("--square", arguments->squares, "FIELDS",
             "Two axes, by square and indicator: at two heights, or along a travel.");
    add_list("--opening", arguments->openings, "FIELDS",
             "Two axes, by the opening of their corner, as plumb volume circle and diagonals print it.");
    add_list("--points", arguments->points, "FIELDS",
             "Two axes, by points of a square, a ring or a polygon, in a CSV file.");
    add_list("--in-force", arguments->in_force, "NAME=ANGLE",
             "A setting that was in force while you measured: EC0Y=-80urad. Your measurement is added to it. "
             "May be given many times: give all settings that are not 0.");
    CLI::Option* const input =
        command
            .add_option("--input", options.input,
                        "A JSON document with the machine and all its leans and measurements, or an output "
                        "of --json; - is the standard input. It takes the place of the other options.")
            ->type_name("FILE");
    command
        .add_flag("--corrections", options.corrections,
                  "Prints as JSON the corrections of the states that the input lists, for a screen.")
        ->needs(input)
        ->group("");
    command.add_flag("--json", options.json, "Prints the result as JSON, for other programs.");
    command
        .add_option(
            "--picture", options.picture,
            "Draws the machine with its leans into this file, which ends in .svg or .png. A PNG needs "
            "rsvg-convert.")
        ->check(
            [](const std::string& file) {
                const std::size_t dot = file.rfind('.');
                const std::string end = dot == std::string::npos ? "" : file.substr(dot);
                return end == ".svg" || end == ".png" ? std::string()
                                                      : quoted(file) + " does not end in .svg or .png";
            },
            "")
        ->type_name("FILE");
    command
        .add_option("--directions", arguments->given.directions.text,
                    "Where the + ends of the axes point, as you stand before the machine: right, left, back, "
                    "front, up or down. By default X=right,Y=back,Z=up. Only the picture uses it.")
        ->type_name("X=SIDE,...");
    command
        .add_option("--datum", arguments->given.datum.text,
                    "Order of the datums: the first axis has the true direction, the second one is measured "
                    "against it, and so on. By default X,Y,Z and the parallel axis: squareness of Y to X is "
                    "EC0Y. Only measurements use it.")
        ->type_name("AXIS,...");
    command
        .add_option("--gantry", arguments->given.gantry.text,
                    "A beam on two motors of an axis, and their places along the beam: Y=0mm:1200mm. Prints "
                    "the change of HOME_OFFSET that makes the beam square.")
        ->type_name("AXIS=FIRST:SECOND");
    const auto choice = [&](const std::string& name, auto& target, const auto& values,
                            const std::string& type, const std::string& text) {
        command
            .add_option_function<std::string>(
                name,
                [name, &target, values](const std::string& value) {
                    for (const auto& [word, meaning] : values) {
                        if (value != word) continue;
                        target = meaning;
                        return;
                    }
                    throw CLI::ValidationError(
                        name, quoted(value) + " is neither " + values[0].first + " nor " + values[1].first);
                },
                text)
            ->type_name(type);
    };
    choice(
        "--reading", options.machine.reading,
        std::vector<std::pair<std::string, TiltReading>>{{"component", TiltReading::component},
                                                         {"axis-direction", TiltReading::axis_direction}},
        "READING",
        "component (by default): all that a tilted axis carries turns with it; or axis-direction: tool or "
        "work turn with it, but the axes that it carries keep their directions, apart from parallel axes.");
    choice(
        "--against", options.machine.against,
        std::vector<std::pair<std::string, TiltDatum>>{{"rail", TiltDatum::rail}, {"bed", TiltDatum::bed}},
        "WHAT",
        "Reference for the tilt of an axis on a parallel one: rail (by default), which carries it, or bed. "
        "Measurements are converted.");
    choice("--correction", options.machine.measured_with_correction,
           std::vector<std::pair<std::string, bool>>{{"on", true}, {"off", false}}, "STATE",
           "State of the correction while you measured. on (by default): your tilts and measurements are "
           "added to --in-force. off: they take its place, and the other angles in force stay.");
    choice("--frame", options.frame,
           std::vector<std::pair<std::string, MachineFrame>>{{"column", MachineFrame::column},
                                                             {"portal", MachineFrame::portal}},
           "FRAME",
           "Frame of the machine in the picture: column or portal. By default the usual frame of the chain.");
    command
        .add_option("--travel", arguments->given.travel.text,
                    "Length of the test move; by default 300mm, or 12in with --unit inch.")
        ->type_name("LENGTH");
    choice("--unit", options.machine.inch,
           std::vector<std::pair<std::string, bool>>{{"mm", false}, {"inch", true}}, "UNIT",
           "Unit of the machine: mm (by default) or inch.");
    command
        .add_option_function<std::string>(
            "--instance",
            [&options](const std::string& name) {
                const auto good = [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_'; };
                if (name.empty() || name.size() > 24 || !std::all_of(name.begin(), name.end(), good))
                    throw CLI::ValidationError("--instance", quoted(name) + " is no name for HAL");
                options.instance = name;
            },
            "Name of the component's instance in the lines for the .hal file. By default square.")
        ->type_name("NAME");
    CLI::Option* const table =
        command
            .add_option("--table", options.tables,
                        "Checks a file of error tables as the component does, and prints its machine, date, "
                        "temperature and seal. Nothing else is printed. May be given many times.")
            ->allow_extra_args(false)
            ->type_name("FILE");
    command
        .add_flag("--seal", options.seal,
                  "Writes the seal of the present content into each file of --table. Check the file before.")
        ->needs(table);
    command
        .add_option("--ini", options.ini,
                    "Refuses a table with the scale of an axis that this INI file of LinuxCNC compensates by "
                    "BACKLASH or COMP_FILE.")
        ->type_name("FILE")
        ->needs(table);
    for (CLI::Option* const other : command.get_options())
        if (other != input && !other->get_lnames().empty()) {
            const std::string& name = other->get_lnames().front();
            if (name != "json" && name != "corrections" && name != "picture" && name != "instance" &&
                name != "help")
                input->excludes(other);
        }
    command.final_callback([arguments, &options] { take_squareness(given_by(*arguments), options); });
}

}  // namespace plumb::commissioning
