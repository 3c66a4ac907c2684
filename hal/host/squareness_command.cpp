// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/squareness_command.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <stdexcept>

#include "components/io/probed_points_file.hpp"
#include "components/math/kinematic_chain.hpp"
#include "components/math/quantity_text.hpp"
#include "components/math/square_readings.hpp"
#include "hal/markup.hpp"

namespace plumb::host {
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

template <class... Numbers>
std::string formatted(const char* format, Numbers... numbers) {
    char text[160];
    std::snprintf(text, sizeof text, format, numbers...);
    return text;
}

std::string letters(Axis axis) {
    return std::string(1, letter(axis));
}

// --- reading the command line ---

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

// key=value,key=value,...
class Fields {
public:
    Fields(const std::string& text, const Words& keys) {
        std::istringstream parts(text);
        for (std::string part; std::getline(parts, part, ',');) {
            const auto [key, value] = split(part, '=', "KEY=VALUE");
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

    // What `read` makes of the value.
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

SquarenessOptions::Measured diagonals_of(const std::string& text, const AxisChain& chain) {
    const Fields fields(text, {"plane", "object", "rising", "falling", "sides", "u", "U", "own", "own-u"});
    const std::string plane = fields.text("plane");
    if (plane.size() != 2) refuse("plane=" + plane + " is not two axes such as XY");
    const Axis a = axis_of(plane.substr(0, 1), chain), b = axis_of(plane.substr(1), chain);
    if (parallel(a, b)) refuse("plane=" + plane + ": the axes are parallel and span no plane");
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

SquarenessOptions::Measured square_of(const std::string& text, const AxisChain& chain) {
    const Fields fields(text, {"move", "plunger", "at", "reads", "turned", "u", "U", "own-u"});
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

SquarenessOptions::Points points_of(const std::string& text) {
    const Fields fields(text, {"file", "object", "unit", "u", "U", "own-u"});
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

SquarenessQuantity quantity_of(const std::string& text, const AxisChain& chain) {
    const auto [name, value] = split(text, '=', "NAME=ANGLE, such as EC0Y=-12.5arcsec");
    if (name.size() != 4 || name[0] != 'E' || name[2] != '0' || name[1] < 'A' || name[1] > 'C')
        refuse(quoted(name) + " is no quantity of ISO 230-1 such as EC0Y");
    SquarenessQuantity quantity{axis_of(name.substr(3), chain), name[1] - 'A', angle_of(value), {}};
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

// Turns into an error of the command line what a text cannot be.
template <class Read>
void read(const std::string& option, const std::string& text, Read read_text) {
    try {
        read_text();
    } catch (const std::invalid_argument& error) {
        const std::string words = error.what();
        const bool told = text.empty() || words.find(text) != std::string::npos;
        throw CLI::ValidationError(option, (told ? "" : quoted(text) + ": ") + words);
    }
}

struct Arguments {
    std::string chain = "w-X-Y.b-Z-C-t";
    Words leans, quantities, diagonals, squares, points;
    std::string datum, travel;
};

void read_tilts(const Arguments& arguments, SquarenessOptions& options) {
    std::map<Axis, std::vector<Lean>> leans;
    for (const std::string& text : arguments.leans) {
        read("--lean", text, [&] {
            const auto [where, value] =
                split(text, '=', "AXIS and direction=ANGLE, such as Y+X=0.02mm/300mm");
            const std::size_t sign = where.find_first_of("+-");
            if (sign == std::string::npos)
                refuse(quoted(where) + " is not an axis and a direction, such as Y+X");
            const Axis axis = axis_of(where.substr(0, sign), options.chain);
            Lean lean = lean_of(where.substr(sign));
            lean.angle = angle_of(value);
            leans[axis].push_back(lean);
            plumb::squareness(axis, leans[axis]);  // throws
            const Eigen::Vector3d angles = plumb::squareness(axis, {lean});
            const int rotation = 3 - direction(axis) - direction(lean.towards);
            options.settings.push_back({axis, rotation, angles[rotation], {}});
        });
    }
    for (const std::string& text : arguments.quantities) {
        read("--iso", text, [&] {
            const SquarenessQuantity quantity = quantity_of(text, options.chain);
            for (const SquarenessQuantity& other : options.settings)
                if (other.is_of(quantity.axis, quantity.rotation))
                    refuse(squareness_name(quantity.axis, quantity.rotation) + " is set twice");
            options.settings.push_back(quantity);
        });
    }
}

void read_all(const Arguments& arguments, SquarenessOptions& options) {
    read("--chain", "", [&] { options.chain = AxisChainReader::read(arguments.chain); });
    options.chain_text = arguments.chain;
    read("--datum", arguments.datum, [&] { options.order = order_of(arguments.datum, options.chain); });
    read("--travel", arguments.travel, [&] {
        options.travel =
            arguments.travel.empty() ? (options.inch ? 12 * 25.4 : 300) : length_of(arguments.travel);
        if (!(options.travel > 0)) refuse("is not longer than 0");
    });
    read_tilts(arguments, options);
    for (const std::string& text : arguments.diagonals)
        read("--diagonals", text, [&] { options.measured.push_back(diagonals_of(text, options.chain)); });
    for (const std::string& text : arguments.squares)
        read("--square", text, [&] { options.measured.push_back(square_of(text, options.chain)); });
    for (const std::string& text : arguments.points)
        read("--points", text, [&] { options.points.push_back(points_of(text)); });
}

// --- computing ---

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
        const ProbedCorner found = ProbedShapeFit::corner(shape);
        if (found.corner.scatter > 1.5)
            how += "; line " + std::to_string(file.lines[found.worst]) + " lies furthest off, by " +
                   formatted("%+.2g mm", found.distance);
        return {found.corner, how};
    } catch (const ProbedMisfit& misfit) {
        throw std::runtime_error(points.file + ": line " + std::to_string(file.lines[misfit.fitted.worst]) +
                                 ": the points do not lie on such a shape; this one is " +
                                 formatted("%+.3g mm", misfit.fitted.distance) + " off, and all scatter " +
                                 formatted("%.3g", misfit.fitted.corner.scatter) +
                                 " times as much as u says: is normal right, and u in its unit?");
    } catch (const std::invalid_argument& error) {
        throw std::runtime_error(points.file + ": " + error.what());
    }
}

// Each corner once.
std::vector<Corner> corners_of(const std::vector<SquarenessOptions::Measured>& measured) {
    std::vector<std::vector<Corner>> groups;
    for (const auto& one : measured) {
        const auto same = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
            return group.front().is_of(one.corner.a, one.corner.b);
        });
        if (same == groups.end())
            groups.push_back({one.corner});
        else
            same->push_back(one.corner);
    }
    std::vector<Corner> corners;
    for (const auto& group : groups) corners.push_back(group.size() == 1 ? group.front() : mean_of(group));
    return corners;
}

KinematicChain machine_of(const SquarenessOptions& options,
                          const std::vector<SquarenessQuantity>& quantities) {
    KinematicChain::Settings settings;
    settings.axes = options.chain;
    settings.reading = options.reading;
    settings.datum = options.against;
    for (const SquarenessQuantity& q : quantities)
        settings.tilts[static_cast<std::size_t>(coordinate(q.axis))].angles[q.rotation] = q.angle;
    return KinematicChain(settings);
}

Lean lean_of(const SquarenessQuantity& quantity) {
    const std::vector<Lean> all =
        leans(quantity.axis, quantity.angle * Eigen::Vector3d::Unit(quantity.rotation));
    return all.empty() ? Lean{} : all.front();
}

bool has_rider(const AxisChain& chain) {
    for (const AxisBranch& branch : {chain.work, chain.tool})
        for (const Axis rail : branch)
            for (const Axis rider : branch)
                if (rail != rider && parallel(rail, rider)) return true;
    return false;
}

// --- printing ---

void paragraph(const std::string& text, const std::string& indent = "") {
    std::string lines = hal::wrapped(text);
    for (std::size_t at = 0; (at = lines.find('\n', at)) != std::string::npos; at += indent.size() + 1)
        lines.replace(at, 1, '\n' + indent);
    std::cout << indent << lines << '\n';
}

void print_chain(const SquarenessOptions& options) {
    const auto carried = [](const AxisBranch& branch, const std::string& what) {
        std::string names;
        for (const Axis axis : branch) names += (names.empty() ? "" : ", then ") + letters(axis);
        if (names.empty()) return "nothing moves the " + what;
        return names + (branch.size == 1 ? " carries the " : " carry the ") + what;
    };
    std::cout << "Chain " << options.chain_text << '\n';
    paragraph("From the bed outwards: " + carried(options.chain.work, "work") + "; " +
                  carried(options.chain.tool, "tool") + '.',
              "  ");
    paragraph(options.reading == TiltReading::component
                  ? "Reading: component; all that a tilted axis carries turns with it."
                  : "Reading: axis direction; of what a tilted axis carries, tool or work turn with it, and "
                    "axes only where they are parallel to it.",
              "  ");
    if (has_rider(options.chain))
        paragraph(options.against == TiltDatum::rail
                      ? "Of two parallel axes, the tilt of the outer one is against the one that carries it."
                      : "Of two parallel axes, the tilt of the outer one is against the bed.",
                  "  ");
}

// The direction of every lean that there is, and what it is called.
void print_directions(const AxisChain& chain) {
    std::cout << "\nHow its axes may lean, and which quantity of ISO 230-1 that is:\n";
    for (const AxisBranch& branch : {chain.work, chain.tool}) {
        for (const Axis axis : branch) {
            for (const Axis towards : {Axis::X, Axis::Y, Axis::Z}) {
                if (parallel(axis, towards)) continue;
                std::cout << "  --lean ";
                for (const int sign : {1, -1}) {
                    const Lean lean{towards, sign, 0};
                    const int rotation = 3 - direction(axis) - direction(towards);
                    std::cout << letter(axis) << name(lean) << "=ANGLE  " << squareness_name(axis, rotation)
                              << (turning(axis, lean)[rotation] > 0 ? " is +" : " is -")
                              << (sign > 0 ? "     or  " : "\n");
                }
            }
        }
    }
    std::cout << "\nGive leans by --lean, quantities by --iso, or measurements; see plumb-squareness(1).\n";
}

std::string arcsec(double angle, const char* format = "%.2f") {
    return formatted(format, arcsec_from_angle(angle)) + " arcsec";
}

void print_measured(const SquarenessOptions& options, const std::vector<SquarenessOptions::Measured>& all) {
    std::cout << "\nMeasured\n";
    for (const auto& [corner, how] : all) {
        const auto place = [&](Axis axis) {
            return std::find(options.order.begin(), options.order.end(), axis) - options.order.begin();
        };
        const bool first = place(corner.a) < place(corner.b);
        const Axis datum = first ? corner.a : corner.b, held = first ? corner.b : corner.a;
        std::string text = letters(held) + " to " + letters(datum) + " (the datum) by " + how +
                           ": the + ends are at 90 deg " + (corner.opening < 0 ? "- " : "+ ") +
                           arcsec(std::abs(corner.opening)) + ", standard uncertainty " +
                           arcsec(corner.uncertainty) + ", " + arcsec(2 * corner.uncertainty) + " with k=2";
        if (corner.scatter > 1)
            text += formatted("; widened %.2g-fold, as the readings scatter", corner.scatter);
        paragraph(text + '.', "  ");
    }
}

void print_row(const std::string& title, double angle, const std::string& end) {
    const double slope = slope_from_angle(angle);
    std::cout << formatted("  %-6s%12.4e%9.2f%10.5f%10.2f%10.4f%10.5f", title.c_str(), angle,
                           arcsec_from_angle(angle), arcsec_from_angle(angle) / 3600, slope * 1e6,
                           slope * 300, slope * 12)
              << end << '\n';
}

void print_quantities(const std::vector<SquarenessQuantity>& quantities) {
    std::cout << "\nAngles         rad   arcsec       deg      um/m  mm/300mm     in/ft  leans\n";
    bool uncertain = false;
    for (const SquarenessQuantity& q : quantities) {
        print_row(squareness_name(q.axis, q.rotation), q.angle,
                  "  " + letters(q.axis) + (q.angle == 0 ? " does not" : " to " + name(lean_of(q))));
        if (!q.uncertainty) continue;
        uncertain = true;
        print_row("  k=1", *q.uncertainty, "");
        print_row("  k=2", 2 * *q.uncertainty, "");
    }
    if (uncertain)
        std::cout << "  k=1 is the standard uncertainty, k=2 twice that: about 95 of 100 lie within.\n";
}

void print_hal(const SquarenessOptions& options, const std::vector<SquarenessQuantity>& quantities) {
    const std::string& name = options.instance;
    std::cout << "\nFor the .hal file\n  loadrt squareness names=" << name << " chain=" << options.chain_text
              << (options.inch ? " unit=inch" : "") << '\n';
    const auto print = [&](const std::string& begin, const std::string& pin, const std::string& value,
                           const std::string& comment) {
        const std::string line = begin + "setp " + name + '.' + pin + ' ' + value;
        std::cout << line << std::string(line.size() < 36 ? 36 - line.size() : 1, ' ') << "# " << comment
                  << '\n';
    };
    const auto setp = [&](const std::string& pin, const std::string& value, const std::string& comment) {
        print("  ", pin, value, comment);
    };
    const auto commented = [&](const std::string& pin, const std::string& value, const std::string& comment) {
        print("  # ", pin, value, comment);
    };
    const bool component = options.reading == TiltReading::component;
    setp("axis-direction", component ? "0" : "1",
         component ? "reading: component" : "reading: axis direction");
    if (has_rider(options.chain)) {
        const bool rail = options.against == TiltDatum::rail;
        setp("to-bed", rail ? "0" : "1", rail ? "tilts against the rail" : "tilts against the bed");
    }
    for (const SquarenessQuantity& q : quantities) {
        std::string pin = squareness_name(q.axis, q.rotation);
        for (char& c : pin) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        setp(pin, q.angle == 0 ? "0" : formatted("%.6g", q.angle),
             letters(q.axis) + (q.angle == 0 ? " does not lean"
                                             : " leans to " + plumb::name(lean_of(q)) + " by " +
                                                   arcsec(std::abs(q.angle))));
    }
    std::set<Axis> leaning;
    for (const SquarenessQuantity& q : quantities) {
        if (q.angle == 0 || !leaning.insert(q.axis).second) continue;
        const bool tool = options.chain.tool.has(q.axis);
        commented(std::string(1, static_cast<char>(std::tolower(letter(q.axis)))) + "-tool-follows", "0",
                  std::string("only if the ") + (tool ? "spindle" : "table") + " was set up square though " +
                      letters(q.axis) + " leans");
    }
}

// The axis against which a quantity is seen.
Axis base_of(const SquarenessQuantity& q) {
    return static_cast<Axis>(3 - direction(q.axis) - q.rotation);
}

void print_test_moves(const SquarenessOptions& options, const std::vector<SquarenessQuantity>& quantities,
                      const std::vector<Corner>& corners) {
    const KinematicChain machine = machine_of(options, quantities);
    const auto length = [&](double mm) {
        if (mm == 0) return std::string(options.inch ? "0 in" : "0 um");
        return options.inch ? formatted("%+.5f in", mm / 25.4) : formatted("%+.1f um", mm * 1e3);
    };
    const auto later = [&](Axis one, Axis other) {
        const auto place = [&](Axis axis) {
            return std::find(options.order.begin(), options.order.end(), axis);
        };
        return place(one) > place(other);
    };
    std::set<std::pair<Axis, Axis>> shown;
    Words hidden;
    std::string rows;
    for (const SquarenessQuantity& quantity : quantities) {
        SquarenessQuantity q = quantity;
        for (const SquarenessQuantity& other :
             quantities)  // that of the axis that was held against the datum
            if (q.uncertainty && other.axis == base_of(q) && base_of(other) == q.axis &&
                later(other.axis, q.axis))
                q = other;
        const Axis base = base_of(q);
        if (q.angle == 0 || !shown.insert({std::min(q.axis, base), std::max(q.axis, base)}).second) continue;
        const std::string name = squareness_name(q.axis, q.rotation), moved = letters(q.axis);
        const double reading = indicator_on_square(machine, q.axis, base, options.travel);
        const double rise = std::abs(reading);
        if (rise < 1e-9 * options.travel) {
            if (!q.uncertainty)
                hidden.push_back(name + ": " + moved + " and " + letters(base) +
                                 " turn together and stay square; no square shows it.");
            continue;
        }
        const std::string travel = moved + formatted(options.inch ? " by %g in" : " by %g mm",
                                                     options.travel / (options.inch ? 25.4 : 1));
        const std::string plunger = (reading > 0 ? "+" : "-") + letters(base);
        rows +=
            formatted("  %-8s%-8s%-9s%-14s%13s%10s%13s", name.c_str(), letters(base).c_str(), plunger.c_str(),
                      travel.c_str(), length(rise).c_str(), length(0).c_str(), length(2 * rise).c_str()) +
            '\n';
        for (const Corner& corner : corners)
            if (corner.is_of(q.axis, base))
                rows += formatted(
                    "%54s\n",
                    ("k=2: +/- " + length(2 * corner.uncertainty * options.travel).substr(1)).c_str());
    }
    if (rows.empty() && hidden.empty()) return;
    std::cout << "\nTest move, which verifies the sign\n";
    if (!rows.empty()) {
        paragraph(
            "Set up a square: one leg along the base axis, trued with the indicator by moving that, the "
            "other along the axis that is to move. With the indicator in the spindle touch that one, the "
            "plunger pointing as told; it counts up as the plunger is pressed in. Set it to 0, and move: "
            "once without correction, once with it.",
            "  ");
        std::cout << "  sign of base    plunger  move                without      with   wrong sign\n"
                  << rows;
    }
    for (const std::string& text : hidden) paragraph(text, "  ");
}

void print_notes(const std::vector<SquarenessQuantity>& quantities, const std::vector<Corner>& corners) {
    Words notes;
    for (const SquarenessQuantity& q : quantities)
        if (q.uncertainty && std::abs(q.angle) < 2 * *q.uncertainty)
            notes.push_back(squareness_name(q.axis, q.rotation) +
                            " is less than its uncertainty with k=2: not even its sign is certain.");
    constexpr double max_angle = 0.002;  // of the component, by default
    for (const SquarenessQuantity& q : quantities)
        if (std::abs(q.angle) > max_angle)
            notes.push_back(squareness_name(q.axis, q.rotation) +
                            " is more than the component takes unless its max-angle is set: 0.002 rad.");
    for (const Corner& corner : corners) {
        Words both;
        for (const SquarenessQuantity& q : quantities)
            if (q.uncertainty && ((corner.a == q.axis && parallel(corner.b, base_of(q))) ||
                                  (corner.b == q.axis && parallel(corner.a, base_of(q)))))
                both.push_back(squareness_name(q.axis, q.rotation));
        if (both.size() > 1)
            notes.push_back(both[0] + " and " + both[1] +
                            " belong together: one of the two axes carries the other, and what it turns that "
                            "by is taken back.");
    }
    for (const std::string& note : notes) {
        std::cout << '\n';
        paragraph("Note: " + note);
    }
}

}  // namespace

void declare_squareness(CLI::App& command, SquarenessOptions& options) {
    const auto arguments = std::make_shared<Arguments>();
    const auto add_list = [&](const std::string& name, Words& words, const std::string& type,
                              const std::string& text) {
        command.add_option(name, words, text)->allow_extra_args(false)->type_name(type);
    };
    command
        .add_option("--chain", arguments->chain,
                    "The axes from the work over the bed to the tool, in the notation of ISO 10791 without "
                    "primes: w-Z.b-X-Y-C-t. By default w-X-Y.b-Z-C-t.")
        ->type_name("CHAIN");
    add_list("--lean", arguments->leans, "TILT",
             "An axis, the direction towards which its + end leans, and the angle: Y+X=0.02mm/300mm. May be "
             "given many times, for each axis and line once.");
    add_list("--iso", arguments->quantities, "NAME=ANGLE",
             "A quantity of ISO 230-1, with its sign: EC0Y=-13.75arcsec. May be given many times.");
    add_list(
        "--diagonals", arguments->diagonals, "FIELDS",
        "Two axes, by the diagonals of a square or rectangle. May be given many times, as the next two.");
    add_list("--square", arguments->squares, "FIELDS",
             "Two axes, by square and indicator: at two heights, or along a travel.");
    add_list("--points", arguments->points, "FIELDS",
             "Two axes, by points of a square, a ring or a polygon, in a CSV file.");
    command
        .add_option(
            "--datum", arguments->datum,
            "Which axis has the true direction; then which is held against that one, and so on. By default "
            "X,Y,Z and the parallel one: squareness of Y to X is EC0Y. Only measurements ask for it.")
        ->type_name("AXIS,...");
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
    choice("--reading", options.reading,
           std::vector<std::pair<std::string, TiltReading>>{{"component", TiltReading::component},
                                                            {"axis-direction", TiltReading::axis_direction}},
           "READING",
           "component (by default): all that a tilted axis carries turns with it; or axis-direction: tool or "
           "work turn with it, but the axes that it carries keep theirs, apart from parallel ones.");
    choice("--against", options.against,
           std::vector<std::pair<std::string, TiltDatum>>{{"rail", TiltDatum::rail}, {"bed", TiltDatum::bed}},
           "WHAT",
           "Against what the tilt of an axis is told that rides on a parallel one: rail (by default), which "
           "carries it, or bed. Measurements are converted.");
    command
        .add_option("--travel", arguments->travel,
                    "Of the test move. By default 300mm, or 12in with --unit inch.")
        ->type_name("LENGTH");
    choice("--unit", options.inch, std::vector<std::pair<std::string, bool>>{{"mm", false}, {"inch", true}},
           "UNIT", "Of the machine: mm (by default) or inch.");
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
    command.final_callback([arguments, &options] { read_all(*arguments, options); });
}

CommandPage squareness_page() {
    return {
        "plumb-squareness",
        "[--chain CHAIN] [tilts or measurements] [options]",
        {{"DESCRIPTION",
          R"(Turns what is known of the tilted axes of a machine into the settings of the component squareness. Known
is either how the axes lean and by how much, or the quantities of ISO 230-1, or what was measured with diagonals,
with square and indicator, or with a probe. In each case it prints all that belongs together: the chain of axes; the
direction in which each axis leans; the angle in rad, arcsec, deg and as length per length; and the
quantity of ISO 230-1 with its sign. Then come the lines for the .hal file, and for each pair of axes the one
move that shows, with square and indicator, whether the sign is right.

Without tilts and measurements it prints those that the chain can have.

An ANGLE is a number with a unit, rad, mrad, urad, deg, arcmin or arcsec, or a length per length: 60um/m, 0.06mm/m,
0.02mm/300mm, 0.001in/ft, 0.02/300. A LENGTH is a number with um, mm, cm, m, in, ft or thou. Numbers have a decimal
point.)"},
         {"SIGNS",
          R"(An axis leans towards D where its + end is off towards D. For an axis that carries the work that is the end
to which the tool goes, seen from the work; for a ram it is the end away from its nose. Of each line an axis leans to
one end only; both are refused.

  axis  leans to  is        axis  leans to  is        axis  leans to  is
  Y, V  +X        EC0Y -    Z, W  +X        EB0Z +    X, U  +Y        EC0X +
  Y, V  -X        EC0Y +    Z, W  -X        EB0Z -    X, U  -Y        EC0X -
  Y, V  +Z        EA0Y +    Z, W  +Y        EA0Z -    X, U  +Z        EB0X -
  Y, V  -Z        EA0Y -    Z, W  -Y        EA0Z +    X, U  -Z        EB0X +

A is about X, B about Y, C about Z, positive as a right hand turns: +C takes +X towards +Y. The last letter is that of the
axis: EC0V.)"},
         {"MEASURING",
          R"(A measurement tells by how much the angle between the + ends of two axes is more or less than 90 deg. As in
ISO 230-1, one of the two is the datum, and the other one leans: of X and Y it is Y, by EC0Y, unless --datum says
otherwise. Where one axis carries another, it turns that as well, as --reading and --against say; this is taken off. So one
measurement may give two angles, and an angle may follow from two.

Measure with the correction off, on a machine that has settled. Otherwise the result is what the correction has
left. A tilt holds for the travel over which it was measured: choose that of the work. Straightness enters into it.

Each measurement is a list of fields, KEY=VALUE,KEY=VALUE, without blanks. In all of them

  u=LENGTH         is the standard uncertainty of a single reading; or U=LENGTH is twice that
  own-u=ANGLE      is that of the artifact or square itself; without it, it is taken as true
  object=part      says that these axes have drawn the shape: they cut the part, or moved along a
                   path that a laser or a ballbar measured
  object=artifact  says that the shape is true, and that a probe on these axes measured it

The object decides over the sign: a part that is longer along a diagonal comes from axes to which an artifact seems shorter there.

Several measurements of the same two axes become their weighted mean. Where readings scatter more than was
stated, the uncertainty is widened by as much; it is never narrowed. So state u honestly: of a few readings the scatter says
little.)"},
         {"DIAGONALS",
          R"(Of a square or rectangle whose sides lie along the axes:

  --diagonals plane=XY,object=part,rising=565.709mm,falling=565.662mm,u=1um

rising is the diagonal from the corner at both - ends to the one at both + ends, falling the
other. Of a rectangle also sides=400:300mm, the first along the first axis of the plane. Of an artifact that is known to be
out of square also own=ANGLE, by which its corner at both - ends is more than 90 deg.)"},
         {"SQUARE AND INDICATOR",
          R"(Readings of the same leg at two heights, or at more places along a travel:

  --square move=Y,plunger=+X,at=0:300mm,reads=0:24um,turned=0:-20um,u=1um

One leg of the square lies along an axis, here X, trued by moving that. An indicator on the tool's side touches the other leg as
the axis move, here Y, runs along it. plunger is the direction in which its plunger points; at the positions of the axis; reads
what it reads there, more as the plunger is pressed in.

turned is read after turning the square by half a turn about the leg that is touched: touch the same face, now from
the other side, with the plunger pointing the other way, at the same positions. This cancels the square's own error.

Two readings are enough, more are better. Of a list without units, the last value has the unit for all.)"},
         {"PROBED POINTS",
          R"(Points on the faces of a square or polygon, or around a ring:

  --points file=square.csv,object=artifact,u=0.5um

unit=in if they are not in mm. The file's header names
its columns: the two axes of the plane; normal, the direction in which the face looks, in deg from the + end of the axis that
comes first in XYZUVW towards that of the other; and turned, by how many deg the artifact was turned before,
likewise. Without normal it is a ring. Lines that begin with # say nothing.

  X,Y,normal,turned
  152.013,-120.5,0,0
  152.010,120.5,0,0
  -120.5,151.998,90,0
  120.5,152.021,90,0

A program of LinuxCNC writes such a file with (LOGOPEN,square.csv), (LOG,X,Y,normal,turned), and (LOG,#5061,#5062,0,0) after each
G38.2 onto a face that looks to +X.

It takes two points on each of two faces that are neither parallel nor at 45 deg to the axes, or five around a ring; better many.
They need not be corrected for the ball of the probe. Probe the artifact again after turning it by 90 deg, and its own error is
told from that of the axes. own-u is an ANGLE, of the direction of a face; of a ring a LENGTH, of its ovality.)"},
         {"EXIT STATUS",
          R"(0 after success; 1 where a file cannot be taken, or what was measured contradicts what was set; 2 for a wrong
command line.)"},
         {"EXAMPLES",
          R"(A column that leans, as a square and an indicator tell:

  plumb squareness --chain w-Z.b-X-Y-C-t --lean Y+X=0.024mm/300mm --lean Y+Z=60um/m

The same, by its quantities:

  plumb squareness --chain w-Z.b-X-Y-C-t --iso EC0Y=-80urad --iso EA0Y=60urad

A column against the diagonals of a part, and, with a square that was turned, against Z as the datum:

  plumb squareness --chain w-Z.b-X-Y-C-t --datum X,Z,Y \
    --diagonals plane=XY,object=part,rising=565.708mm,falling=565.662mm,u=1um \
    --square move=Y,plunger=+Z,at=0:300mm,reads=0:20um,turned=0:-16um,u=1um)"}},
        ".BR plumb (1),\n.BR squareness (9),\n.BR plumb\\-bench (1),\n.BR halcmd (1)"};
}

int squareness(const SquarenessOptions& options) {
    std::vector<SquarenessOptions::Measured> measured = options.measured;
    for (const SquarenessOptions::Points& points : options.points)
        measured.push_back(measured_by(points, options.chain));
    const std::vector<Corner> corners = corners_of(measured);
    const SquarenessOfChain solver(options.chain, options.reading, options.against, options.order);
    std::vector<SquarenessQuantity> quantities = solver.quantities(corners, options.settings);
    std::stable_sort(quantities.begin(), quantities.end(), [](const auto& one, const auto& other) {
        return std::make_pair(one.axis, one.rotation) < std::make_pair(other.axis, other.rotation);
    });
    for (const SquarenessQuantity& q : quantities)
        for (const SquarenessQuantity& setting : options.settings)
            if (q.uncertainty && q.is_of(setting.axis, setting.rotation))
                throw std::runtime_error(squareness_name(q.axis, q.rotation) +
                                         " is set and follows from measurements, too: leave one out");
    print_chain(options);
    if (quantities.empty()) {
        print_directions(options.chain);
        return 0;
    }
    if (!measured.empty()) print_measured(options, measured);
    print_quantities(quantities);
    print_hal(options, quantities);
    print_test_moves(options, quantities, corners);
    print_notes(quantities, corners);
    return 0;
}

}  // namespace plumb::host
