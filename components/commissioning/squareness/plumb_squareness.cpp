// SPDX-License-Identifier: GPL-2.0-or-later
// plumb-squareness: turns tilts or measurements into the settings of the component squareness.
#include "components/commissioning/squareness/squareness_arguments.hpp"
#include "components/commissioning/squareness/squareness_manual.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "components/commissioning/picture_file.hpp"
#include "components/commissioning/squareness/machine_drawing.hpp"
#include "components/commissioning/squareness/squareness_advice.hpp"
#include "components/commissioning/squareness/squareness_corrections.hpp"
#include "components/commissioning/squareness/squareness_document.hpp"
#include "components/commissioning/squareness/squareness_state.hpp"
#include "components/commissioning/squareness/squareness_wording.hpp"
#include "components/io/files/error_table_file.hpp"
#include "components/io/files/error_table_seal.hpp"
#include "components/io/files/ini_compensation.hpp"
#include "hal/command_line.hpp"
#include "hal/markup.hpp"
#include "hal/program_end.hpp"
#include "hal/regular_file.hpp"

namespace plumb::commissioning {
namespace {

void paragraph(const std::string& text, const std::string& indent = "") {
    std::string lines = hal::wrapped(text);
    for (std::size_t at = 0; (at = lines.find('\n', at)) != std::string::npos; at += indent.size() + 1)
        lines.replace(at, 1, '\n' + indent);
    std::cout << indent << lines << '\n';
}

void print_chain(const TiltedMachine& machine) {
    const auto carried = [](const AxisBranch& branch, const std::string& what) {
        std::string names;
        for (const Axis axis : branch) names += (names.empty() ? "" : ", then ") + letters(axis);
        if (names.empty()) return "nothing moves the " + what;
        return names + (branch.size == 1 ? " carries the " : " carry the ") + what;
    };
    std::cout << "Chain " << machine.chain_text << '\n';
    paragraph("From the bed outwards: " + carried(machine.chain.work, "work") + "; " +
                  carried(machine.chain.tool, "tool") + '.',
              "  ");
    paragraph(machine.reading == TiltReading::component
                  ? "Reading: component; all that a tilted axis carries turns with it."
                  : "Reading: axis direction; tool or work turn with a tilted axis, and of the axes that it "
                    "carries "
                    "only those parallel to it.",
              "  ");
    if (machine.chain.stacked())
        paragraph(machine.against == TiltDatum::rail
                      ? "The tilt of an axis on a parallel one is against the axis that carries it."
                      : "The tilt of an axis on a parallel one is against the bed.",
                  "  ");
}

// The name and the direction of every possible lean.
void print_directions(const TiltedMachine& machine) {
    const AxisChain& chain = machine.chain;
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
                const int rotation = 3 - direction(axis) - direction(towards);
                const std::string useless = useless_because(machine, axis, rotation);
                if (!useless.empty()) paragraph("Corrects nothing: " + useless, "      ");
            }
        }
    }
    std::cout << "\nGive leans by --lean, quantities by --iso, or measurements; see plumb-squareness(1).\n";
}

void print_measured(const TiltedMachine& machine, const std::vector<SquarenessOptions::Measured>& all) {
    std::cout << "\nMeasured\n";
    for (const auto& [corner, how] : all) {
        const auto place = [&](Axis axis) {
            return std::find(machine.order.begin(), machine.order.end(), axis) - machine.order.begin();
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

void print_corners(const TiltedMachine& machine, const SquarenessAdvice& advice) {
    std::cout << "\nSquareness before and after\n";
    const SquarenessState state = state_of(machine, advice);
    for (const CornerState& corner : state.corners)
        paragraph(letters(corner.a) + " to " + letters(corner.b) + ": " + corner.words + '.', "  ");
    const ErrorList list = errors_of(machine, state);
    std::cout << '\n' << list.text();
    if (!list.sentence().empty())
        paragraph(list.sentence() + " plumb volume uncertainty states U of the work space from this list.", "  ");
}

void print_hal(const std::string& instance, const SquarenessAdvice& advice) {
    std::cout << "\nWhere squareness is loaded\n  loadrt squareness names=" << instance << ' '
              << advice.options << "\n\nBehind it, in the file of settings\n";
    for (const SquarenessAdvice::Setting& setting : advice.settings) {
        const std::string line =
            (setting.in_force ? "  setp " : "  # setp ") + instance + '.' + setting.pin + ' ' + setting.value;
        std::cout << line << std::string(line.size() < 36 ? 36 - line.size() : 1, ' ') << "# "
                  << setting.comment << '\n';
    }
}

void print_test_moves(bool inch, const SquarenessAdvice& advice) {
    if (advice.moves.empty() && advice.unseen.empty()) return;
    const auto length = [&](double mm) {
        if (mm == 0) return std::string(inch ? "0 in" : "0 um");
        return inch ? formatted("%+.5f in", mm / 25.4) : formatted("%+.1f um", mm * 1e3);
    };
    std::cout << "\nTest move, which verifies the sign\n";
    if (!advice.moves.empty()) {
        paragraph(
            "Set up a square. Align one leg with the base axis: move the base axis, and read the indicator. "
            "The other leg lies along the axis of the test move. With the indicator in the spindle, touch "
            "this leg, with the plunger pointing as below; the indicator counts up as the plunger is pressed "
            "in. Set it to 0, and move: once without correction, once with it.",
            "  ");
        if (std::any_of(advice.moves.begin(), advice.moves.end(), [](const auto& m) { return !m.base; }))
            paragraph(
                "If the base is the table, two axes turn together, and no square shows it: touch the table "
                "itself, or a face of a body that stands true on it.",
                "  ");
        std::cout << "  sign of base    plunger  move                without      with    all wrong\n";
    }
    for (const SquarenessAdvice::TestMove& move : advice.moves) {
        const std::string travel = letters(move.moved) + formatted(inch ? " by %g in" : " by %g mm",
                                                                   move.travel / (inch ? 25.4 : 1));
        std::cout << formatted("  %-8s%-8s%-9s%-14s%13s%10s%13s",
                               squareness_name(move.quantity.axis, move.quantity.rotation).c_str(),
                               (move.base ? letters(*move.base) : "table").c_str(),
                               name(move.plunger).c_str(), travel.c_str(), length(move.rise).c_str(),
                               length(0).c_str(), length(move.rise_by_wrong_signs()).c_str())
                  << '\n';
        if (move.single.size() > 1)
            for (const auto& wrong : move.single)
                std::cout << formatted(
                    "%64s%13s\n",
                    ("only " + squareness_name(wrong.quantity.axis, wrong.quantity.rotation) + " wrong")
                        .c_str(),
                    length(wrong.rise).c_str());
        if (move.uncertainty)
            std::cout << formatted("%54s\n", ("k=2: +/- " + length(2 * *move.uncertainty).substr(1)).c_str());
    }
    for (const std::string& text : advice.unseen) paragraph(text, "  ");
}

// The beam of a gantry as homed is a lean of the axis along it; the motors can turn it square instead.
void print_gantry(const SquarenessOptions& options, const SquarenessAdvice& advice) {
    const auto& [drive, across, first, second] = *options.gantry;
    const int rotation = 3 - direction(drive) - direction(across);
    const int sign = (direction(drive) - direction(across) + 3) % 3 == 1 ? 1 : -1;
    const std::string beam = squareness_name(across, rotation);
    std::cout << "\nThe beam along " << letter(across) << ", on two motors of " << letter(drive) << '\n';
    const auto its = std::find_if(advice.settled.begin(), advice.settled.end(),
                                  [&](const auto& q) { return q.is_of(across, rotation); });
    if (its == advice.settled.end()) {
        paragraph("The beam is " + beam + ", which was not measured. With --datum " + letters(drive) + ',' +
                      letters(across) + " a square shows it.",
                  "  ");
        return;
    }
    const double unit = options.machine.inch ? 25.4 : 1, change = sign * its->angle * (second - first) / unit;
    paragraph("Add " + formatted("%+.*f", options.machine.inch ? 5 : 4, change) +
                  (its->uncertainty ? formatted(" +- %.*f (k=2)", options.machine.inch ? 5 : 4,
                                                2 * *its->uncertainty * (second - first) / unit)
                                    : " +- unknown") +
                  (options.machine.inch ? " in" : " mm") + " to HOME_OFFSET of the joint at " +
                  letters(across) + formatted(" %g", second / unit) + ", home again, and leave " + beam +
                  " at 0. Or set " + beam + " as below, and leave HOME_OFFSET. Never do both.",
              "  ");
    paragraph("Not seen: the scatter of the home switches, a beam that turns along " + letters(drive) +
                  ", and the force in a beam that is turned: an error of 100 um on 20 N/um is 2 kN.",
              "  ");
}

// Throws std::runtime_error with file, line and reason.
void print_tables(const SquarenessOptions& options) {
    const ErrorTableFiles read = read_error_tables({options.tables.begin(), options.tables.end()});
    for (const auto& [axis, table] : read.tables)
        if (!options.ini.empty() && table.scale_measured()) IniCompensation(options.ini).refuse(axis);
    const auto stated = [](const std::string& fact) { return fact.empty() ? "not stated" : fact; };
    for (const error_table_file::Facts& its : read.files)
        std::cout << its.file << "\n  axes         " << its.axes << "\n  rows         " << its.rows
                  << "\n  machine      " << stated(its.machine) << "\n  date         " << stated(its.date)
                  << "\n  temperature  " << stated(its.temperature) << "\n  seal         "
                  << (its.seal.empty()
                          ? "none; check the table, then run\n    " + error_table_file::seal_command(its.file)
                          : its.seal)
                  << '\n';
    for (const auto& [axis, table] : read.tables)
        std::cout << formatted("%c from %g to %g %s\n", axis, table.first(), table.last(),
                               error_table_file::is_rotary(axis) ? "deg" : "mm");
}

// Throws std::runtime_error with the file and the reason.
void draw(const SquarenessOptions& options, const TiltedMachine& machine, const SquarenessAdvice& advice) {
    const std::filesystem::path file = options.picture;
    const std::string svg =
        MachineDrawing{machine.chain_text, machine.chain, options.directions, options.frame, advice.settled}
            .svg();
    if (file.extension() == ".svg") {
        write_file(file, svg);
        return;
    }
    const std::filesystem::path source = file.string() + ".svg";
    write_file(source, svg);
    const bool drawn = to_png(source, file);
    std::filesystem::remove(source);
    if (!drawn)
        throw std::runtime_error(file.string() +
                                 ": rsvg-convert draws no PNG: install librsvg2-bin, or let "
                                 "the name end in .svg");
}

// "-" is the standard input. Throws std::runtime_error with the file, the place and the reason.
std::string text_of(const std::string& input) {
    if (input == "-") return {std::istreambuf_iterator<char>(std::cin), {}};
    return hal::RegularFile(input, O_RDONLY).read();
}

SquarenessOptions read_input(const SquarenessOptions& arguments) {
    const std::string text = text_of(arguments.input);
    try {
        SquarenessOptions options = read_squareness_document(text);
        options.json = arguments.json;
        options.picture = arguments.picture;
        options.instance = arguments.instance;
        return options;
    } catch (const std::runtime_error& error) {
        throw std::runtime_error((arguments.input == "-" ? "standard input" : arguments.input) + ": " +
                                 error.what());
    }
}

// Prints settings, the lines for the .hal file and the test moves. Returns 0. Throws std::runtime_error and
// std::invalid_argument.
int squareness(const SquarenessOptions& arguments) {
    if (arguments.corrections) {
        std::cout << squareness_corrections(text_of(arguments.input)) << '\n';
        return 0;
    }
    const SquarenessOptions options = arguments.input.empty() ? arguments : read_input(arguments);
    if (!options.tables.empty()) {
        if (options.seal)
            for (const std::string& file : options.tables) seal_error_table(file);
        print_tables(options);
        return 0;
    }
    std::vector<SquarenessOptions::Measured> measured = options.measured;
    for (const SquarenessOptions::Points& points : options.points)
        measured.push_back(measured_by(points, options.machine.chain));
    TiltedMachine machine = options.machine;
    for (const SquarenessOptions::Measured& one : measured) {
        machine.measured.push_back(one.corner);
        machine.instruments.push_back(one.how);
    }
    const SquarenessAdvice advice = advice_on(machine);
    if (!options.picture.empty()) draw(options, machine, advice);
    if (options.json) {
        std::cout << squareness_document(options, machine, advice) << '\n';
        return 0;
    }
    print_chain(machine);
    if (advice.quantities.empty()) {
        print_directions(machine);
        return 0;
    }
    if (!measured.empty()) print_measured(machine, measured);
    print_quantities(advice.quantities);
    print_corners(machine, advice);
    if (options.gantry) print_gantry(options, advice);
    print_hal(options.instance, advice);
    print_test_moves(machine.inch, advice);
    for (const std::string& note : advice.notes) {
        std::cout << '\n';
        paragraph("Note: " + note);
    }
    return 0;
}

}  // namespace
}  // namespace plumb::commissioning

static int carry_out(int argc, char** argv) {
    using namespace plumb::commissioning;
    CLI::App app("turns tilts or measurements into squareness settings", "plumb squareness");
    SquarenessOptions options;
    declare_squareness(app, options);
    plumb::hal::begin_command_line(app, squareness_page);
    return plumb::hal::carry_out(app, argc, argv, [&] { return squareness(options); });
}

int main(int argc, char** argv) {
    return plumb::ended("plumb squareness", [&] { return carry_out(argc, argv); });
}
