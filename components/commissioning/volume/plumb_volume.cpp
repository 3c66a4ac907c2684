// SPDX-License-Identifier: GPL-2.0-or-later
// plumb-volume: measures errors of axes, and states how sure their correction is.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "components/commissioning/picture_file.hpp"
#include "components/commissioning/quantity_text.hpp"
#include "components/commissioning/volume/volume_files.hpp"
#include "components/commissioning/volume/volume_manual.hpp"
#include "components/commissioning/volume/volume_of.hpp"
#include "components/commissioning/volume/volume_readings.hpp"
#include "components/io/files/comp_file.hpp"
#include "components/io/files/control_files.hpp"
#include "components/io/files/ini_compensation.hpp"
#include "components/io/files/rtl_file.hpp"
#include "components/math/blocks/pi.hpp"
#include "components/math/geometry/circle_test.hpp"
#include "hal/command_line.hpp"
#include "hal/markup.hpp"
#include "hal/program_end.hpp"

namespace plumb::commissioning {
namespace {

template <typename... Values>
std::string formatted(const char* format, Values... values) {
    char text[400];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

// To this part of a unit, and never -0.
double rounded(double value, double parts) {
    return std::round(value * parts) / parts + 0.0;
}
std::string um(double mm) {
    return formatted("%.2f um", rounded(mm * 1000, 100));
}
std::string with_u(double value, double standard) {
    return um(value) + formatted(" +- %.2f um", 2 * standard * 1000);
}

void say(const std::string& text) {
    std::cout << hal::wrapped(text) << '\n';
}

void check_axis(const std::string& axis) {
    if (axis.size() != 1 || error_table_file::linear_axes.find(axis[0]) == std::string_view::npos)
        throw std::invalid_argument("--axis: " + csv::quoted(axis) + " is none of X Y Z U V W");
}
std::string scale_error(const std::string& axis) {
    return std::string("E") + "XYZ"[error_table_file::linear_axes.find(axis[0]) % 3] + axis;
}

void put(const std::string& file, const std::string& text) {
    if (file.empty()) {
        std::cout << text;
        return;
    }
    write_file(file, text);
    std::cout << "Written: " << file << '\n';
}

// The uncertainty of a scale: of its rows, and of the laser's own scale. Nothing without the latter, for
// repeating does not show it.
std::string scale_lines(const std::string& axis, double u, const std::string& scale_u) {
    if (scale_u.empty()) return "";
    const std::string error = scale_error(axis);
    return "# u: " + error + ' ' + csv::decimal(u) + "\n# u-common: " + error + ' ' +
           csv::decimal(angle_of(scale_u)) + " per " + axis + '\n';
}
constexpr const char* scale_is_unknown =
    "The scale has no uncertainty, so it counts as unknown. Give the uncertainty of the laser: --scale-u "
    "0.8um/m.";

// --- reversal ---

struct ReversalOptions {
    std::string file, axis, own, reading, scale_u, output, into, ini, date = date_of_today();
    bool scale = false, recording = false, json = false, leads = false;
    int places = 7;
};

double length(const std::string& option, const std::string& text, double none = 0) {
    if (text.empty()) return none;
    try {
        return length_of(text);
    } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(option + ": " + error.what());
    }
}

// Not below 0, and less than 1 mm; `given`: above 0.
double small_length(const std::string& option, const std::string& text, bool given = false) {
    const double value = length(option, text);
    if (!(value >= 0 && value < 1) || (given && value == 0))
        throw std::invalid_argument(option + ": " + csv::quoted(text) + " is not " +
                                    (given ? "above 0" : "0 or more") + " and below 1 mm");
    return value;
}

// Refuses rows that squareness takes in no table.
void check_rows(const std::string& file, const DirectionRows& rows, std::size_t error) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::string why = direction_rows::misfit(rows, i, error);
        if (!why.empty())
            throw std::runtime_error(file + ": position " + csv::decimal(rows[i].position) + " mm: " + why +
                                     "; is each value in its unit?");
    }
}

DirectionRows reversal_rows(const ReversalOptions& its, const ReversalResult& result) {
    DirectionRows rows;
    for (const ReversalRow& row : result.rows) {
        const double mean = its.scale ? row.mean : 0;
        rows.push_back({row.position, mean + row.half, mean - row.half});
    }
    return rows;
}

// The text of an error table with this result. With --into it is the text of that file, with these columns
// replaced.
std::string reversal_table(const ReversalOptions& its, const ReversalResult& result) {
    DirectionRows rows = reversal_rows(its, result);
    double u = 0;
    for (const ReversalRow& row : result.rows) u = std::max(u, row.uncertainty);
    if (rows.size() == 1) {
        const DirectionRow one = rows.front();
        rows = {{one.position - 1, one.up, one.down}, {one.position + 1, one.up, one.down}};
    }
    const std::string error = scale_error(its.axis);
    std::string head = "# u: " + error + "+ " + csv::decimal(u) + '\n';
    if (its.scale) head += scale_lines(its.axis, u, its.scale_u);
    head += "# repeatability: " + error + ' ' + csv::decimal(result.repeatability) +
            "\n# by: " + (its.recording ? "motor against scale" : "readings from both sides") + '\n';
    return its.into.empty() ? direction_rows::table_text(its.axis[0], error, rows, date_line(its.date) + head)
                            : table_with_reversal(its.into, its.axis[0], error, rows, head, its.date);
}

int reversal(const ReversalOptions& its) {
    check_axis(its.axis);
    date_line(its.date);
    const double reading = small_length("--reading-u", its.reading), own = small_length("--own-u", its.own);
    if (!its.ini.empty()) IniCompensation(its.ini).refuse(its.axis[0]);
    const std::vector<BothWays> places =
        its.recording ? read_recording(its.file, its.places, 0.002) : read_readings(its.file);
    ReversalResult result;
    try {
        result = reversal_of(places, reading, own);
    } catch (const std::invalid_argument& error) {
        throw std::runtime_error(its.file + ": " + error.what());
    }
    if (!its.leads)
        for (const ReversalRow& row : result.rows)
            if (row.half > 2 * row.uncertainty && result.lost_motion < -2 * result.uncertainty)
                throw std::runtime_error(its.file + ": position " + csv::decimal(row.position) +
                                         " mm: the lost motion is " + um(-2 * row.half) +
                                         ", so the table would lead. Are the columns up and down swapped, or "
                                         "does the indicator count down as " +
                                         its.axis +
                                         " moves to its + end? A table would double the error. If BACKLASH "
                                         "is in force and too large, give --leads");
    check_rows(its.file, reversal_rows(its, result), 0);
    const std::string table = its.output.empty() ? "" : reversal_table(its, result);
    double most = -1e9, least = 1e9;
    for (const ReversalRow& row : result.rows) {
        most = std::max(most, -2 * row.half);
        least = std::min(least, -2 * row.half);
    }
    if (its.json) {
        nlohmann::ordered_json json = {{"axis", its.axis},
                                       {"lost_motion", result.lost_motion},
                                       {"U", 2 * result.uncertainty},
                                       {"repeatability", result.repeatability},
                                       {"drift", result.drift}};
        for (const ReversalRow& row : result.rows)
            json["rows"].push_back(
                {{"position", row.position}, {"lost_motion", -2 * row.half}, {"U", 4 * row.uncertainty}});
        std::cout << json.dump(1) << '\n';
    } else {
        std::cout << "Lost motion of " << its.axis << ": " << with_u(result.lost_motion, result.uncertainty)
                  << " (k = 2), from " << um(least) << " to " << um(most) << " along the travel\n"
                  << "Repeatability: " << um(result.repeatability) << ", one standard deviation\n\n"
                  << "  position mm   lost motion um    U um\n";
        for (const ReversalRow& row : result.rows)
            std::cout << formatted("%13.3f%17.2f%8.2f\n", row.position, -2000 * row.half,
                                   4000 * row.uncertainty);
        std::cout << '\n';
        if (result.drift != 0)
            say("The readings drift by " + um(result.drift) +
                " from one run to the next, and the uncertainty contains it. Let the machine warm up, and "
                "read again.");
        if (its.scale && its.scale_u.empty()) say(scale_is_unknown);
        say("Not seen: " + std::string(its.scale ? "" : "the scale of the axis, ") +
            "errors beside the line that was measured, and lost motion under cutting force.");
        const CircleTurn turn{most, DirectionOfMotion::usual_distance, DirectionOfMotion::usual_acceleration};
        if (most > 0)
            say(formatted("On a circle of R50 this leaves %.1f um at F1000 and %.1f um at F3000 where ",
                          turn.kept(1000 / 60.0, 50) * 1000, turn.kept(3000 / 60.0, 50) * 1000) +
                its.axis + " turns, with the defaults of squareness; plumb volume turn computes others.");
        say("Test move: with the table in force, move " + its.axis +
            " to a place from either side. The indicator reads the same within U.");
    }
    if (!table.empty() && its.json)
        write_file(its.output, table);
    else if (!table.empty())
        put(its.output, table);
    return 0;
}

// --- turn ---

struct TurnOptions {
    std::string lost, distance, allowed;
    double acceleration = DirectionOfMotion::usual_acceleration, feed = 0, radius = 0;
};

int turn(const TurnOptions& its) {
    const auto within = [](const std::string& option, const std::string& text, double most, double none) {
        const double value = length(option, text, none);
        if (!(value > 0 && value <= most))
            throw std::invalid_argument(option + ": " + csv::quoted(text) + " is not above 0 and up to " +
                                        csv::decimal(most * 1000) + " um");
        return value;
    };
    const CircleTurn turn{within("--lost-motion", its.lost, 0.2, 0),
                          within("--distance", its.distance, 0.1, DirectionOfMotion::usual_distance),
                          its.acceleration};
    const double allowed = within("--allowed", its.allowed, 1, turn.lost / 4);
    if (its.feed > 0) {
        const double kept = turn.kept(its.feed / 60, its.radius);
        std::cout << formatted(
                         "F%g on R%g keeps %s of the lost motion of %s where the axis turns, outwards.\n",
                         its.feed, its.radius, um(kept).c_str(), um(turn.lost).c_str())
                  << "Circular deviation G: " << um(turn.lost) << " without correction, " << um(kept)
                  << " with it.\n";
        if (its.feed * its.feed / 3600 / its.radius > its.acceleration / 2)
            say("The turn comes late: the square of the speed over the radius is above half of "
                "reversal-acceleration. The largest "
                "distance from the mean circle can be more than without correction, over a short arc. Finish "
                "this circle slower, or "
                "raise reversal-acceleration with offset-acceleration of the stages.");
    }
    std::cout << "Largest feed for at most " << um(allowed) << ", mm/min:\n";
    for (const double radius : {10.0, 25.0, 50.0, 100.0, 150.0}) {
        const double feed = std::floor(turn.speed_for(allowed, radius) * 60);
        std::cout << (feed > 0 ? formatted("  R%-5g F%.0f\n", radius, feed)
                               : formatted("  R%-5g none: reversal-distance alone keeps more\n", radius));
    }
    say("For a drive that follows at once: corrected-velocity as its feed-forward. A drive that lags by 33 "
        "ms keeps up to twice as much.");
    return 0;
}

// The option that takes a measured corner.
std::string opening_option(const std::string& plane, double opening, double u) {
    return formatted(
        "  plumb squareness --chain CHAIN --opening plane=%s,object=part,angle=%.4gurad,u=%.3gurad\n",
        plane.c_str(), opening * 1e6, std::max(u * 1e6, 0.001));
}

// --- circle ---

struct CircleOptions {
    std::vector<std::string> files;
    bool json = false;
};

int circle(const CircleOptions& its) {
    std::vector<CircularPath> paths;
    BallbarFile first;
    for (const std::string& file : its.files) {
        const BallbarFile one = read_ballbar(file);
        if (!paths.empty() &&
            (one.plane != first.plane || one.radius != first.radius || one.feed != first.feed))
            throw std::runtime_error(file + ": plane, radius or feed differs from " + its.files.front());
        if (paths.empty()) first = one;
        paths.push_back(one.path);
    }
    CircleResult r;
    try {
        r = circle_result({first.radius, first.feed / 60}, paths);
    } catch (const std::invalid_argument& error) {
        throw std::runtime_error(its.files.front() + ": " + error.what());
    }
    const std::string a(1, first.plane[0]), b(1, first.plane[1]);
    if (its.json) {
        const auto estimate = [](const Estimate& e) {
            return nlohmann::ordered_json{{"value", e.value}, {"U", 2 * e.uncertainty}};
        };
        nlohmann::ordered_json json = {{"plane", first.plane},
                                       {"both_directions", r.both_directions},
                                       {"opening", estimate(r.opening)},
                                       {"scale_difference", estimate(r.scale_difference)},
                                       {"lost_motion_" + a, estimate(r.lost_motion_a)},
                                       {"lost_motion_" + b, estimate(r.lost_motion_b)}};
        if (r.both_directions) {
            json["across_" + a] = estimate(r.across_a);
            json["lag"] = estimate(r.lag);
        }
        if (r.both_directions) json["D"] = r.d;
        json.update({{"radius_deviation", r.radius_deviation},
                     {"noise", r.noise},
                     {"G_cw", r.g_clockwise},
                     {"G_ccw", r.g_counter},
                     {"G_b", r.g_both},
                     {"F_most", r.f_most},
                     {"F_least", r.f_least}});
        for (const CircularPath& path :
             paths) {  // deg, and mm beyond the nominal circle about its own centre
            nlohmann::ordered_json points;
            for (std::size_t i = 0; i < path.angles.size(); ++i) {
                const double t = path.angles[i];
                points.push_back({t * 180 / pi, path.radii[i] - first.radius - r.centre_a * std::cos(t) -
                                                    r.centre_b * std::sin(t)});
            }
            json["paths"].push_back({{"clockwise", path.clockwise}, {"points", points}});
        }
        std::cout << json.dump(1) << '\n';
        return 0;
    }
    const auto line = [](const std::string& name, const Estimate& e, double unit, const char* of) {
        std::cout << formatted("  %-34s%10.3f +- %.3f %s\n", name.c_str(), rounded(e.value * unit, 1000),
                               2 * e.uncertainty * unit, of);
    };
    std::cout << "Plane " << first.plane << ", R " << csv::decimal(first.radius) << " mm, F "
              << csv::decimal(first.feed) << " mm/min\n";
    if (r.g_counter > 0) std::cout << "  G, counter-clockwise              " << um(r.g_counter) << '\n';
    if (r.g_clockwise > 0) std::cout << "  G, clockwise                      " << um(r.g_clockwise) << '\n';
    if (r.both_directions) std::cout << "  G(b), both directions             " << um(r.g_both) << '\n';
    std::cout << "  F                                 " << um(r.f_least) << " to " << um(r.f_most) << '\n';
    if (r.both_directions) std::cout << "  D, mean radius less nominal       " << um(r.d) << '\n';
    line("opening of the corner" + std::string(r.both_directions ? "" : ", with lag"), r.opening, 1e6,
         "urad");
    line("scale of " + a + " less scale of " + b, r.scale_difference, 1e6, "um/m");
    line("lost motion of " + a, r.lost_motion_a, 1000, "um");
    line("lost motion of " + b, r.lost_motion_b, 1000, "um");
    if (r.both_directions) {
        line("play of " + a + " across, E" + b + a + "+", r.across_a, 1000, "um");
        line("servo lag of " + a + " less " + b, r.lag, 1000, "ms");
    }
    std::cout << "  noise                             " << um(r.noise) << '\n';
    say(std::string("Not seen: equal scales of both axes (the length of the bar is in the mean radius), "
                    "pitch and yaw at "
                    "this height apart from scale, and all errors along the third axis.") +
        (r.both_directions
             ? ""
             : " One direction only: opening and servo lag are one sum; 0.4 ms at F2000 and R150 "
               "look like 89 urad."));
    for (const CircularPath& path : paths)
        if (path.clockwise && path.angles.back() > path.angles.front())
            say("The angles of the clockwise path rise. They are read as places on the circle, from the + "
                "end of " +
                a + " to the + end of " + b + ", not as angles along the path.");
    if (r.both_directions)
        std::cout << "Enter this opening with the chain of your machine:\n"
                  << opening_option(first.plane, r.opening.value, r.opening.uncertainty);
    else
        say("Measure the other direction, too: then the opening is without the lag, and plumb squareness "
            "takes it.");
    return 0;
}

// --- diagonals ---

struct DiagonalOptions {
    std::vector<double> box;
    std::vector<std::string> deviations;
    std::string u;
};

int diagonals(const DiagonalOptions& its) {
    BoxDiagonals box{its.box[0], its.box[1], its.box[2], {}, small_length("--u", its.u, true)};
    for (std::size_t i = 0; i < 4; ++i) box.deviations[i] = length("--deviations", its.deviations[i]);
    const BoxResult r = box_from_diagonals(box);
    const auto line = [](const char* name, double value, double u, const char* unit) {
        std::cout << formatted("  %-22s%10.2f +- %.2f %s\n", name, value * 1e6, 2 * u * 1e6, unit);
    };
    std::cout << "Openings of the corners (+: more than 90 deg)\n";
    line("X to Y", r.xy, r.u_xy, "urad");
    line("X to Z", r.xz, r.u_xz, "urad");
    line("Y to Z", r.yz, r.u_yz, "urad");
    line("mean scale", r.scale, r.u_scale, "um/m");
    say("Not seen: the scale of each axis, only their sum, weighted by the squares of the sides; "
        "straightness, pitch and yaw. "
        "Equal diagonals do not prove a good volume. Steps along a diagonal check a table and never fill "
        "one.");
    std::cout << "Enter these openings with the chain of your machine:\n"
              << opening_option("XY", r.xy, r.u_xy) << opening_option("XZ", r.xz, r.u_xz)
              << opening_option("YZ", r.yz, r.u_yz);
    say("plumb volume uncertainty predicts the diagonals before and after correction, and compares steps.");
    return 0;
}

// --- straightedge, block ---

struct StraightedgeOptions {
    std::string file, error, u, output, date = date_of_today();
};

int straightedge(const StraightedgeOptions& its) {
    const std::string& e = its.error;
    if (e.size() != 3 || e[0] != 'E' || std::string("XYZ").find(e[1]) == std::string::npos ||
        error_table_file::linear_axes.find(e[2]) == std::string_view::npos ||
        error_table_file::linear_axes.find(e[2]) % 3 == error_table_file::linear_axes.find(e[1]))
        throw std::invalid_argument("--error: " + csv::quoted(e) + " is no straightness, as EYX");
    date_line(its.date);
    const double u = small_length("--u", its.u, true);
    std::vector<double> positions, before, turned;
    for (const StraightedgeRow& row : read_straightedge(its.file)) {
        positions.push_back(row.position);
        before.push_back(row.before);
        turned.push_back(row.turned);
    }
    const Straightness r = straightness_of(positions, before, turned);
    DirectionRows rows;
    for (std::size_t i = 0; i < positions.size(); ++i)
        rows.push_back({positions[i], r.errors[i], r.errors[i]});
    check_rows(its.file, rows, error_index(e));
    std::cout << "Straightness " << e << ": " << um(r.range) << ", U of each value "
              << um(2 * u / std::sqrt(2)) << " (k = 2)\nThe straightedge itself: " << um(r.range_of_edge)
              << '\n';
    say("Not seen: the slope of the axis (its squareness), and twist of the edge between both readings.");
    if (its.output.empty()) return 0;
    put(its.output,
        direction_rows::table_text(e[2], e, rows,
                                   date_line(its.date) + "# u: " + e + ' ' + csv::decimal(u / std::sqrt(2)) +
                                       "\n# by: straightedge\n"));
    return 0;
}

struct BlockOptions {
    double bore = 0, boss = 0, measured = 0, ball = 0;
    std::string pre_travel, u_pre_travel, u_size, u;
};

int block(const BlockOptions& its) {
    if ((its.bore > 0) == (its.boss > 0)) throw std::invalid_argument("give either --bore or --boss");
    if (!(its.measured > 0 && its.ball > 0)) throw std::invalid_argument("--measured and --ball are above 0");
    const double p = small_length("--pre-travel", its.pre_travel);
    const double lost = its.bore > 0 ? its.measured - (its.bore - its.ball) - 2 * p
                                     : its.boss + its.ball - 2 * p - its.measured;
    if (!(std::abs(lost) <= 0.2))
        throw std::invalid_argument("a lost motion of " + um(lost) + " is beyond 200 um: check the sizes");
    const double up = small_length("--pre-travel-u", its.u_pre_travel),
                 us = small_length("--size-u", its.u_size), u = small_length("--u", its.u);
    const double U = 2 * std::sqrt(4 * up * up + us * us + 2 * u * u);
    std::cout << "Lost motion: " << um(lost);
    if (up > 0 && u > 0)
        std::cout << " +- " << um(U) << " (k = 2)\n";
    else
        std::cout << " +- unknown: " << (u > 0 ? "the pre-travel" : "a reading") << " has no uncertainty\n";
    if (lost < -U) say("The lost motion is negative: check the sizes, the ball and the pre-travel.");
    say("Not seen: lost motion apart from the pre-travel of the probe, which an axis with a scale at the "
        "load shows; the "
        "scale of the axis over the block.");
    return 0;
}

// --- files of others ---

struct FileOptions {
    std::string kind, file, axis, output, date, unit, error, scale_u;
    std::optional<int> type;
    std::optional<double> zero;
    bool negate = false;
};

constexpr int trims = 1;  // COMP_FILE_TYPE

double millimetres(const FileOptions& its) {
    return its.unit == "inch" ? 25.4 : 1;
}

// The error that a file is read or written for.
std::string error_of(const FileOptions& its) {
    return its.error.empty() ? scale_error(its.axis) : its.error;
}

// Refuses an option of another kind of file.
void check_options(const FileOptions& its) {
    const bool comp = its.kind == "linuxcnc", rtl = its.kind == "rtl";
    check_axis(its.axis);
    date_line(its.date);
    if (!comp && its.type) throw std::invalid_argument("--type is for a COMP_FILE of LinuxCNC");
    if (!its.scale_u.empty() && (!rtl || error_of(its) != scale_error(its.axis)))
        throw std::invalid_argument("--scale-u is for the scale in an .rtl");
    if (comp && !its.error.empty())
        throw std::invalid_argument("--error: a COMP_FILE has the scale of its axis alone");
    const bool known =
        comp  ? its.unit == "mm" || its.unit == "inch"
        : rtl ? its.unit == "um" || its.unit == "urad" || its.unit == "mrad" || its.unit == "arcsec"
              : its.unit == "mm";
    if (!its.unit.empty() && !known)
        throw std::invalid_argument("--unit: " + csv::quoted(its.unit) + " is none of " +
                                    (comp  ? "mm and inch, the units of a COMP_FILE"
                                     : rtl ? "um, urad, mrad and arcsec, the units of readings in an .rtl"
                                           : "mm: the file has mm and rad"));
    if (its.error.empty()) {
        if (rtl && !its.unit.empty() && its.unit != "um")
            throw std::invalid_argument("--unit: " + csv::quoted(its.unit) + " is no unit of the scale " +
                                        scale_error(its.axis) + ": give --error, as EB" + its.axis);
        return;
    }
    const std::vector<std::string> names = error_table_file::error_names(its.axis[0]);
    if (std::find(names.begin(), names.end(), its.error) == names.end())
        throw std::invalid_argument("--error: " + csv::quoted(its.error) + " is no error of " + its.axis +
                                    ", as " + names.front());
    const bool angle = error_index(its.error) >= 3;
    if (angle && (its.kind == "heidenhain" || its.kind == "cec"))
        throw std::invalid_argument("--error: " + csv::quoted(its.error) +
                                    " is an angle, and this file has lengths alone");
    if (rtl && (its.unit.empty() || (its.unit == "um") == angle))
        throw std::invalid_argument("--error: give the unit of " + its.error + " by --unit, " +
                                    (angle ? "urad, mrad or arcsec" : "um"));
}

int import(const FileOptions& its) {
    check_options(its);
    const std::string text = csv::text_of(its.file), error = error_of(its);
    const bool angle = error_index(error) >= 3;
    DirectionRows rows;
    const std::string date = its.date.empty() ? date_of_file(its.file) : its.date;
    std::string head = "# imported from " + its.kind + '\n' + date_line(date);
    if (its.kind == "linuxcnc") {
        rows = comp_file::read(its.file, text, its.type.value_or(trims), millimetres(its));
    } else if (its.kind == "isg") {
        rows = isg_file::read(its.file, text, error);
    } else if (its.kind == "heidenhain") {
        rows = heidenhain_file::read(its.file, text, error);
    } else if (its.kind == "cec") {
        rows = cec_file::read(its.file, text, error);
    } else {
        std::optional<double> size;
        if (!its.error.empty())
            size = its.unit == "um"     ? 1e-3
                   : its.unit == "urad" ? 1e-6
                   : its.unit == "mrad" ? 1e-3
                                        : angle_from_arcsec(1);
        std::vector<BothWays> places = rtl_file::read(its.file, text, size);
        const bool no_down =
            std::all_of(places.begin(), places.end(), [](const BothWays& at) { return at.down.empty(); });
        const bool no_up =
            std::all_of(places.begin(), places.end(), [](const BothWays& at) { return at.up.empty(); });
        ReversalResult r;
        try {
            r = no_down || no_up ? one_way_of(places, 1e-9) : reversal_of(places, 1e-9);
        } catch (const std::invalid_argument& refusal) {
            throw std::runtime_error(its.file + ": " + refusal.what());
        }
        double u = 0;
        for (const ReversalRow& row : r.rows) {
            rows.push_back({row.position, row.mean + row.half, row.mean - row.half});
            u = std::max(u, row.uncertainty);
        }
        const bool scale = error == scale_error(its.axis);
        if (r.freedom > 0 && r.repeatability > 0) {
            if (!no_down && !no_up) head += "# u: " + error + "+ " + csv::decimal(u) + '\n';
            head += scale ? scale_lines(its.axis, u, its.scale_u) + "# repeatability: " + error + ' ' +
                                csv::decimal(r.repeatability) + '\n'
                          : "# u: " + error + ' ' + csv::decimal(u) + '\n';
        }
        std::ostream& out = its.output.empty() ? std::cerr : std::cout;
        if (no_down || no_up) out << "All runs go the same way: the lost motion is unknown.\n";
        if (scale && its.scale_u.empty()) out << hal::wrapped(scale_is_unknown) << '\n';
    }
    check_rows(its.file, rows, error_index(error));
    if (its.negate)
        for (DirectionRow& row : rows) row = {row.position, -row.up, -row.down};
    if (its.zero) rows = direction_rows::zeroed(rows, *its.zero);
    const std::string table = direction_rows::table_text(its.axis[0], error, rows, head);
    const DirectionRow& last = *std::max_element(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
        return std::abs(a.up) < std::abs(b.up);
    });
    put(its.output, table);
    std::ostream& out = its.output.empty() ? std::cerr : std::cout;
    std::string sign = "Sign: " + error + " is actual less nominal. At " + csv::decimal(last.position) +
                       " mm, reached in + direction, " + its.axis;
    if (angle)
        sign += formatted(" turns by %.2f urad about ", last.up * 1e6) + "XYZ"[error[1] - 'A'] +
                ", positive by the right hand.";
    else if (error == scale_error(its.axis))
        sign += " stands " + um(std::abs(last.up)) + (last.up < 0 ? " short of" : " beyond") +
                " its nominal place, towards its " + (last.up < 0 ? "-" : "+") + " end.";
    else
        sign += " stands " + um(std::abs(last.up)) + " off to the " + (last.up < 0 ? "-" : "+") + " end of " +
                error[1] + '.';
    out << hal::wrapped(sign + " Check it with a laser, " + (angle ? "a level" : "a gauge block") +
                        " or an indicator: move there without correction; if the error has the other sign, "
                        "import with --negate.")
        << '\n';
    if (its.date.empty() && !date.empty())
        out << hal::wrapped(
                   "Date: " + date +
                   ", of the last change of the file. If the axis was measured earlier, give --date.")
            << '\n';
    if (its.kind == "linuxcnc")
        out << hal::wrapped(
                   "Delete COMP_FILE and BACKLASH of this joint from the INI file before the table is in "
                   "force. LinuxCNC is linear between the lines; squareness is smooth.")
            << '\n';
    return 0;
}

int export_to(const FileOptions& its) {
    check_options(its);
    const std::string wanted = error_of(its);
    if (its.kind == "rtl" && wanted != scale_error(its.axis))
        throw std::invalid_argument("--error: an .rtl is written for the scale of its axis alone");
    TableError error = read_table_error(its.file, wanted);
    if (its.zero) error.rows = direction_rows::zeroed(error.rows, *its.zero);
    if (its.negate)
        for (DirectionRow& row : error.rows) row = {row.position, -row.up, -row.down};
    std::string lost;
    if (its.kind == "isg" && std::any_of(error.rows.begin(), error.rows.end(),
                                         [](const DirectionRow& row) { return row.up != row.down; }))
        lost += " the difference by direction;";
    if (its.kind == "cec") {
        const std::size_t before = error.rows.size();
        error.rows = cec_file::even(error.rows);
        if (error.rows.size() != before)
            lost += " the uneven places, for " + std::to_string(error.rows.size()) + " even steps;";
    }
    put(its.output, its.kind == "linuxcnc"
                        ? comp_file::text(error.rows, its.type.value_or(trims), millimetres(its))
                    : its.kind == "isg"        ? isg_file::text(error.rows, wanted)
                    : its.kind == "heidenhain" ? heidenhain_file::text(error.rows, wanted)
                    : its.kind == "cec"        ? cec_file::text(error.rows, wanted)
                                               : rtl_file::text(error.rows));
    const std::vector<UncertainTable> tables = read_uncertain_tables({its.file});
    for (const UncertainTable& table : tables)
        for (const std::string& name : table.columns)
            if (name.substr(0, 3) != wanted) lost += ' ' + name;
    if (!lost.empty()) std::cerr << "Not in the file, which holds " << wanted << ':' << lost << '\n';
    if (its.kind != "linuxcnc" && its.kind != "rtl")
        std::cerr << "The control's own sign is not stated in public: check with one move, and else write "
                     "again with --negate.\n";
    return 0;
}

// --- uncertainty ---

// Of each error: its unit, u, and rows of position, and of the error after motion to the + and to the - end.
nlohmann::ordered_json table_json(const UncertainTable& table) {
    nlohmann::ordered_json json;
    for (const std::string& column : table.columns) {
        if (column.back() == '-') continue;
        const std::string error = column.substr(0, 3);
        const bool directed = column.size() == 4;
        const std::size_t e = error_index(error);
        nlohmann::ordered_json rows;
        for (std::size_t i = 0; i < table.mean.size(); ++i) {
            const double mean = table.mean[i].errors[e], half = directed ? table.half[i].errors[e] : 0;
            rows.push_back({table.mean[i].position, mean + half, mean - half});
        }
        const auto u = table.u.find(directed && table.u.count(error) == 0 ? column : error);
        json[error] = {
            {"unit", e < 3 ? "mm" : "rad"},
            {"directed", directed},
            {"u", u == table.u.end() ? nlohmann::ordered_json() : nlohmann::ordered_json(u->second)},
            {"rows", rows}};
    }
    return json;
}

void print_diagonals(const std::vector<DiagonalState>& all, bool known) {
    std::cout << "\nBody diagonals, as predicted   length mm  before um  after um    U um\n";
    for (const DiagonalState& one : all)
        std::cout << formatted(
            "  %-28s%10.1f%11.2f%10.2f%8s\n", one.name.c_str(), one.length,
            rounded(one.end.without * 1000, 100), rounded(one.end.rest * 1000, 100),
            one.end.U > 0 ? formatted(known ? "%.2f" : ">%.2f", one.end.U * 1000).c_str() : "?");
    for (const DiagonalState& one : all) {
        if (one.steps.empty()) continue;
        std::cout << "\nSteps along " << one.name << "   at mm  measured um  before um  after um    U um\n";
        std::size_t before = 0, after = 0;
        for (const auto& [distance, measured, predicted] : one.steps) {
            std::cout << formatted("%24.1f%13.2f%11.2f%10.2f%8.2f\n", distance, measured * 1000,
                                   rounded(predicted.without * 1000, 100),
                                   rounded(predicted.rest * 1000, 100), predicted.U * 1000);
            before += std::abs(measured - predicted.without) <= predicted.U;
            after += std::abs(measured - predicted.rest) <= predicted.U;
        }
        say("The steps fit the machine without correction at " + std::to_string(before) +
            " and with correction at " + std::to_string(after) + " of " + std::to_string(one.steps.size()) +
            " places, within U. The laser's own uncertainty is not in this U. Not seen: errors across the "
            "diagonal. The alignment of laser and mirror enters, so steps check a table, and never fill "
            "one.");
    }
    std::cout << '\n';
}

// The line of the whole. It states no 0: a part that is known to remain and rounds to 0 is left out.
std::string after_correction(double rest, const PlaceUncertainty& worst, bool known, const std::string& at,
                             const std::vector<Share>& shares) {
    if (!(worst.U > 0)) return "After correction: U is unknown, for no error has an uncertainty.";
    std::string text = "After correction: ";
    if (rest >= 0.05e-3) text += formatted("%.1f um are known and stay, ", rest * 1000);
    text += (known ? "+- " : "at least +- ") +
            formatted(worst.U < 1e-2 ? "%.2g um (k = 2) over " : "%.0f um (k = 2) over ", worst.U * 1000) +
            formatted("%.2g m, ", worst.distance / 1000) + at + '.';
    if (!shares.empty())
        text += formatted(" Largest share: %s, %.0f %%.", shares[0].name.c_str(), 100 * shares[0].part);
    return text;
}

int uncertainty(const VolumeOptions& its) {
    const VolumeQuestion question = question_of(its);
    const VolumeUncertainty r = uncertainty_of(question.measured, question.reference, question.places,
                                               its.draws, static_cast<std::uint64_t>(its.seed));
    const PlaceUncertainty& worst = r.places[r.worst];
    const VolumePlace& place = question.places[r.worst];
    double rest = 0;
    double unknown = 0;
    for (const PlaceUncertainty& one : r.places) {
        rest = std::max(rest, one.rest.norm());
        unknown = std::max(unknown, one.unknown);
    }
    const bool known = question.list.unknown().empty();
    const std::vector<DiagonalState> diagonals = diagonals_of(question, its);
    if (its.json) {
        nlohmann::ordered_json json = {
            {"draws", its.draws},
            {"seed", its.seed},
            {"rest", rest},
            {"U", worst.U > 0 ? nlohmann::ordered_json(worst.U) : nlohmann::ordered_json()},
            {"at_least", !known},
            {"over", worst.distance},
            {"unknown_direction", unknown},
            {"tool", place.name},
            {"worst_at", {place.position[0], place.position[1], place.position[2]}},
            {"errors", question.list.json()}};
        for (std::size_t i = 0; i < r.places.size(); ++i) {
            const auto& q = question.places[i].position;
            const auto& b = r.places[i].by_axis;
            json["places"].push_back({{"at", {q[0], q[1], q[2]}},
                                      {"tool", question.places[i].name},
                                      {"U", r.places[i].U},
                                      {"U_axis", {b[0], b[1], b[2]}},
                                      {"rest", r.places[i].rest.norm()},
                                      {"unknown_direction", r.places[i].unknown}});
        }
        for (const Share& share : r.shares)
            json["shares"].push_back({{"of", share.name}, {"part", share.part}});
        for (const DiagonalState& one : diagonals) {
            nlohmann::ordered_json steps = nlohmann::ordered_json::array();
            for (const auto& step : one.steps)
                steps.push_back({{"distance", step.distance},
                                 {"measured", step.measured},
                                 {"without", step.predicted.without},
                                 {"rest", step.predicted.rest},
                                 {"U", step.predicted.U}});
            json["diagonals"].push_back({{"name", one.name},
                                         {"length", one.length},
                                         {"without", one.end.without},
                                         {"rest", one.end.rest},
                                         {"U", one.end.U > 0 ? nlohmann::ordered_json(one.end.U) : nullptr},
                                         {"steps", steps}});
        }
        json["tables"] = nlohmann::ordered_json::object();
        for (const UncertainTable& table : question.tables)
            json["tables"][std::string(1, table.axis)] = table_json(table);
        json["notes"] = nlohmann::ordered_json::array();
        for (const VolumeQuestion::Note& note : question.notes)
            json["notes"].push_back({{"kind", note.kind},
                                     {"of", note.of},
                                     {"first", note.first},
                                     {"second", note.second},
                                     {"text", note.text}});
        std::cout << json.dump(1) << '\n';
        return 0;
    }
    // A share that nothing is known of is no 0.
    const auto cell = [](double mm) { return mm < 5e-6 ? std::string("-") : formatted("%.2f", mm * 1000); };
    std::cout << "      X       Y       Z  tool        rest um    U um    U X    U Y    U Z\n";
    for (std::size_t i = 0; i < r.places.size(); ++i) {
        const auto& q = question.places[i].position;
        const PlaceUncertainty& one = r.places[i];
        std::cout << formatted("%7.0f %7.0f %7.0f  %-10s%9s %7s%7s%7s%7s\n", q[0], q[1], q[2],
                               question.places[i].name.c_str(), cell(one.rest.norm()).c_str(),
                               cell(one.U).c_str(), cell(one.by_axis[0]).c_str(),
                               cell(one.by_axis[1]).c_str(), cell(one.by_axis[2]).c_str());
    }
    if (!r.shares.empty()) std::cout << "\nShares of the worst place\n";
    for (const Share& share : r.shares)
        if (share.part >= 0.005)
            std::cout << formatted("  %-28s%4.0f %%\n", share.name.c_str(), 100 * share.part);
    print_diagonals(diagonals, known);
    const std::string at = formatted("worst at X %.0f Y %.0f Z %.0f with %s", place.position[0],
                                     place.position[1], place.position[2], place.name.c_str());
    std::cout << question.list.text() << '\n';
    say(after_correction(rest, worst, known, at, r.shares) + (known ? "" : " " + question.list.sentence()));
    if (unknown > 0)
        say(
            formatted("While a direction of motion is not known: %s%.2g um, with up to %.1f um of lost "
                      "motion. This ends "
                      "when each axis has moved by its lost motion after the start, and after machine on.",
                      known ? "+- " : "at least +- ", (worst.U + unknown) * 1000, unknown * 1000));
    for (const VolumeQuestion::Note& note : question.notes) say(note.text);
    std::cout << its.draws << " machines drawn, seed " << its.seed << ".\n";
    say("Not corrected, and not in U: the orientation of the tool, the spindle, cutting force, the mass of "
        "the work, contour "
        "error.");
    return 0;
}

}  // namespace
}  // namespace plumb::commissioning

static int carry_out(int argc, char** argv) {
    using namespace plumb::commissioning;
    CLI::App app("measures errors of axes, and states how sure their correction is", "plumb volume");
    app.require_subcommand(1);

    ReversalOptions r;
    CLI::App* const reversing = app.add_subcommand("reversal", "Makes a table of lost motion from readings.");
    reversing->add_option("READINGS", r.file, "Readings, as CSV.")->required();
    reversing->add_option("--axis", r.axis, "Axis, as X.")->required();
    reversing->add_option("--own-u", r.own, "Standard uncertainty of the indicator's hysteresis, as 0.2um.");
    reversing->add_option("--reading-u", r.reading,
                          "Standard uncertainty of a reading, if each was taken once.");
    reversing->add_flag("--scale", r.scale, "Keeps the mean of both directions, too.");
    reversing->add_option("--scale-u", r.scale_u,
                          "Standard uncertainty of the laser's or scale's own scale, as 0.8um/m.");
    reversing->add_flag("--leads", r.leads, "Takes a table that leads: BACKLASH is in force and too large.");
    reversing->add_flag("--recording", r.recording, "The file has the columns motor,load over any motion.");
    reversing->add_option("--places", r.places, "Parts of the travel of a recording.")
        ->check(CLI::Range(1, 200));
    reversing->add_option("--output", r.output, "Writes the table into this file.");
    reversing->add_option("--into", r.into, "A table of the axis that the result is put into.");
    reversing->add_option("--ini", r.ini, "Refuses an axis that this INI file of LinuxCNC compensates.");
    reversing->add_option("--date", r.date, "Date of the measurement; default: today.");
    reversing->add_flag("--json", r.json, "Prints JSON.");

    TurnOptions t;
    CLI::App* const turning = app.add_subcommand(
        "turn", "Predicts the error that lost motion leaves on a circle, and the largest feed.");
    turning->add_option("--lost-motion", t.lost, "Lost motion, as 10um.")->required();
    CLI::Option* const feed =
        turning->add_option("--feed", t.feed, "Feed, mm/min.")->check(CLI::Range(1.0, 1e6));
    CLI::Option* const radius =
        turning->add_option("--radius", t.radius, "Radius, mm.")->check(CLI::Range(0.1, 1e5));
    feed->needs(radius);
    radius->needs(feed);
    turning->add_option("--acceleration", t.acceleration, "reversal-acceleration, mm/s2; default: 125.")
        ->check(CLI::Range(0.001, 1e5));
    turning->add_option("--distance", t.distance, "reversal-distance, as 0.5um, the default.");
    turning->add_option("--allowed", t.allowed,
                        "Deviation that is acceptable, as 2um; default: a quarter of the lost motion.");

    CircleOptions c;
    CLI::App* const circling = app.add_subcommand("circle", "Separates the errors that a ballbar shows.");
    circling->add_option("PATHS", c.files, "One file, or one for each direction.")
        ->required()
        ->expected(1, 2);
    circling->add_flag("--json", c.json, "Prints JSON.");

    DiagonalOptions d;
    CLI::App* const diagonal =
        app.add_subcommand("diagonals", "Gives the corners that four body diagonals show.");
    diagonal->add_option("--box", d.box, "Sides along X, Y and Z in mm, as 800,600,500.")
        ->required()
        ->delimiter(',')
        ->expected(3);
    diagonal->add_option("--deviations", d.deviations, "Of PPP,NPP,PNP,NNP, as 3um,-5um,2um,1um.")
        ->required()
        ->delimiter(',')
        ->expected(4);
    diagonal->add_option("--u", d.u, "Standard uncertainty of a deviation, as 1um.")->required();

    StraightedgeOptions s;
    CLI::App* const edge =
        app.add_subcommand("straightedge", "Makes a table of straightness from an edge that is turned over.");
    edge->add_option("READINGS", s.file, "Readings, as CSV.")->required();
    edge->add_option("--error", s.error, "The error, as EYX.")->required();
    edge->add_option("--u", s.u, "Standard uncertainty of a reading, as 0.5um.")->required();
    edge->add_option("--date", s.date, "Date of the measurement; default: today.");
    edge->add_option("--output", s.output, "Writes the table into this file.");

    BlockOptions b;
    CLI::App* const blocking =
        app.add_subcommand("block", "Gives lost motion from a probe and a block or bore.");
    blocking->add_option("--bore", b.bore, "Diameter of the gauge bore, mm.");
    blocking->add_option("--boss", b.boss, "Width of the block, mm.");
    blocking->add_option("--measured", b.measured, "Distance between the touches, mm.")->required();
    blocking->add_option("--ball", b.ball, "Diameter of the ball, mm.")->required();
    blocking->add_option("--pre-travel", b.pre_travel, "Pre-travel of the probe, as 4um.")->required();
    blocking->add_option("--pre-travel-u", b.u_pre_travel, "Its standard uncertainty.");
    blocking->add_option("--size-u", b.u_size, "Standard uncertainty of bore or block.");
    blocking->add_option("--u", b.u, "Standard uncertainty of a touch.");

    FileOptions f;
    const auto file_options = [&f](CLI::App* command) {
        command->add_option("--axis", f.axis, "Axis, as X.")->required();
        command->add_option("--type", f.type, "COMP_FILE_TYPE: 0 places, 1 trims, the default.")
            ->check(CLI::Range(0, 1));
        command->add_option(
            "--unit", f.unit,
            "Of a COMP_FILE, mm or inch; of the readings in an .rtl, um, urad, mrad or arcsec.");
        command->add_option(
            "--error", f.error,
            "Error in the file, as EBX; of an .rtl with its --unit; default: the scale, EXX.");
        command->add_option("--zero", f.zero, "The error is 0 at this position.");
        command->add_flag("--negate", f.negate, "Turns the sign of the errors.");
        command->add_option("--output", f.output, "Writes into this file.");
    };
    CLI::App* const importing = app.add_subcommand("import", "Makes a table from a file of another control.");
    importing->add_option("FILE", f.file, "The file.")->required();
    importing->add_option("--date", f.date,
                          "Date of the measurement; default: of the last change of the file.");
    importing->add_option("--scale-u", f.scale_u,
                          "Standard uncertainty of the laser's own scale, as 0.8um/m, for an .rtl.");
    importing->add_option("--from", f.kind, "linuxcnc, rtl, isg, heidenhain or cec.")
        ->required()
        ->check(CLI::IsMember({"linuxcnc", "rtl", "isg", "heidenhain", "cec"}));
    file_options(importing);
    CLI::App* const exporting = app.add_subcommand("export", "Writes a table for another control.");
    exporting->add_option("TABLE", f.file, "The table.")->required();
    exporting->add_option("--to", f.kind, "linuxcnc, rtl, isg, heidenhain or cec.")
        ->required()
        ->check(CLI::IsMember({"linuxcnc", "rtl", "isg", "heidenhain", "cec"}));
    file_options(exporting);

    VolumeOptions v;
    CLI::App* const sure = app.add_subcommand("uncertainty", "States how sure the corrected volume is.");
    sure->add_option("--chain", v.chain, "Chain of axes, as w-X.b-Y-Z-t.")->required();
    sure->add_option("--box", v.box,
                     "Work space, as X=0:800,Y=0:600,Z=-500:0, and the place of a clamped axis, as W=300.")
        ->required();
    sure->add_option("--reference", v.reference,
                     "Place where the work is zeroed, as X=0,Y=0,Z=0; default: the lowest corner.");
    sure->add_option("--tool", v.tools,
                     "Tool from the gauge point to the tip, mm, as T3=0,0,-200. May be given many times.");
    sure->add_option("--tilt", v.tilts,
                     "A tilt in force, as EC0Y=-80urad,u=4urad,drift=2urad,date=2026-11-20,by=square; drift "
                     "is u for a year. "
                     "May be given many times.");
    sure->add_option("--common", v.commons, "One cause of several angles, as NAME,EC0Y=1,EC0X=0.5,u=3urad.");
    sure->add_option("--table", v.tables, "A table in force. May be given many times.");
    sure->add_option("--assume", v.assumed,
                     "States errors that were not measured: iso-10791, or a file of lines error,u,source. "
                     "May be given many times.");
    sure->add_option("--repeatability", v.repeatability, "Of an axis, as X=0.5um. May be given many times.");
    sure->add_option("--tool-u", v.tool_u, "Standard uncertainty of the length of the tool.");
    sure->add_option("--pivot", v.pivots, "Pivot of an axis, as Y=300. May be given many times.");
    sure->add_option("--today", v.today,
                     "Date, as 2026-11-26, for the age of tables; default: of the clock.");
    sure->add_option("--temperature", v.temperature, "Temperature of the machine now, as 24degC.");
    sure->add_option("--steps", v.steps,
                     "Steps of a laser along a diagonal, as PPP=steps.csv. May be given many times.");
    sure->add_option("--max-correction", v.max_correction, "Bound of the correction in force, mm.");
    sure->add_option("--draws", v.draws, "Machines that are drawn.")->check(CLI::Range(100, 100000));
    sure->add_option("--seed", v.seed, "Seed of the draws.")->check(CLI::Range(0, 2147483647));
    sure->add_flag("--json", v.json, "Prints JSON.");

    plumb::hal::begin_command_line(app, volume_page);
    return plumb::hal::carry_out(app, argc, argv, [&] {
        if (*reversing) return reversal(r);
        if (*turning) return turn(t);
        if (*circling) return circle(c);
        if (*diagonal) return diagonals(d);
        if (*edge) return straightedge(s);
        if (*blocking) return block(b);
        if (*importing) return import(f);
        if (*exporting) return export_to(f);
        return uncertainty(v);
    });
}

int main(int argc, char** argv) {
    return plumb::ended("plumb volume", [&] { return carry_out(argc, argv); });
}
