// SPDX-License-Identifier: GPL-2.0-or-later
// By an operator's measurements on the simulated machine, `plumb squareness` finds its tilts; and the test
// move comes out as announced.
#include "tests/support/bench.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <array>
#include <cctype>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr double urad = 1e-6;

using Texts = std::vector<std::string>;
using Place = std::array<double, 3>;

std::string number(double value) {
    std::ostringstream text;
    text.precision(12);
    text << value;
    return text.str();
}

std::string advice(const Texts& arguments) {
    Texts words{build_folder() + "/bin/plumb", "squareness"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const Outcome outcome = run_program(words, "/");
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    return outcome.output;
}

// The value to which a line sets a pin of the component; NaN if none does.
double setting(const std::string& output, const std::string& pin) {
    const std::string begin = "\n  setp square." + pin + ' ';
    const std::size_t at = output.find(begin);
    return at == std::string::npos ? std::nan("") : std::stod(output.substr(at + begin.size()));
}

struct TestMove {
    std::string name;
    char base, moved;
    int sign;  // of the plunger's direction
    double travel, without, wrong;
};

std::vector<TestMove> test_moves(const std::string& output) {
    const std::string title = "all wrong\n";
    std::vector<TestMove> moves;
    std::istringstream lines(output.substr(output.find(title) + title.size()));
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        TestMove move;
        std::string plunger, moved, by, with, unit;
        if (words >> move.name >> move.base >> plunger >> moved >> by >> move.travel >> unit >>
            move.without >> unit >> with >> unit >> move.wrong) {
            move.moved = moved[0];
            move.sign = plunger[0] == '-' ? -1 : 1;
            EXPECT_EQ(plunger[1], move.base);
            EXPECT_EQ(with, "0");
            moves.push_back(move);
        }
    }
    return moves;
}

// The machine with its instruments, and the two hands at it.
struct SquarenessRecipe : testing::Test {
    static constexpr double ball = 1.5;  // mm, radius
    Bench bench;
    std::map<char, double> at{{'x', 100}, {'y', 150}, {'z', -120}, {'w', 200}};
    bool corrected = false;

    SquarenessRecipe() {
        bench.command("loadrt sim_portal names=machine");
        bench.command("addf machine.update servo-thread");
        bench.set("machine.servo-gain", 6000);
        bench.set("machine.tool-length", 200);
        bench.set("machine.ball-radius", ball);
        bench.run(0.001);
    }

    void go() {
        for (const auto& [axis, position] : at) {
            const std::string name(1, axis);
            if (corrected) {
                bench.set(name + "-position", position);
            } else {
                bench.set("machine." + name + "-nominal", position);
                bench.set("machine." + name + "-position-cmd", position);
            }
        }
        bench.run(corrected ? 1 : 0.01);  // the position jumps: the correction comes by its ramp
    }

    Place tip() {
        return {bench.get("machine.truth-x-tip"), bench.get("machine.truth-y-tip"),
                bench.get("machine.truth-z-tip")};
    }

    static std::size_t direction(char axis) { return axis == 'w' ? 2 : static_cast<std::size_t>(axis - 'x'); }

    void put_box(const Place& lowest, const Place& size) {
        const char* const sizes[] = {"width", "depth", "height"};
        for (std::size_t i = 0; i < 3; ++i) {
            bench.set(std::string("machine.artifact-") + "xyz"[i], lowest[i]);
            bench.set(std::string("machine.artifact-") + sizes[i], size[i]);
        }
    }

    // By how much an indicator on the true face of a block reads more as an axis moves.
    double indicated(char moved, char towards, int sign, double travel) {
        const double start = at[moved];
        go();
        Place lowest = tip(), size{4000, 4000, 4000};
        const std::size_t d = direction(towards);
        for (double& side : lowest) side -= 2000;
        lowest[d] = tip()[d] + sign * (1 + ball) - (sign < 0 ? size[d] : 0);
        put_box(lowest, size);
        bench.run(0.001);
        const double before = bench.get("machine.truth-probe-gap");
        at[moved] = start + travel;
        go();
        const double after = bench.get("machine.truth-probe-gap");
        at[moved] = start;
        return before - after;
    }

    // The same on a square whose base was trued along the other axis, whose lean turns the blade, too.
    double on_square(char moved, char base, int sign, double travel) {
        const char blade = "xyz"[direction(moved)];
        return indicated(moved, base, sign, travel) + sign * indicated(base, blade, 1, travel);
    }

    std::string two_heights(char moved, char base, int sign) {
        return std::string("move=") + upper(moved) + ",plunger=" + (sign < 0 ? '-' : '+') + upper(base) +
               ",at=0:300mm,reads=0:" + number(on_square(moved, base, sign, 300)) + "mm,u=1um";
    }

    static char upper(char axis) { return static_cast<char>(std::toupper(static_cast<unsigned char>(axis))); }

    // G38.2 along an axis onto the face in front: where the encoders stand as the probe trips.
    std::pair<double, double> probed(double x, double y, char along, int sign) {
        at['x'] = x;
        at['y'] = y;
        for (int step = 0; step < 4; ++step) {
            go();
            at[along] += sign * bench.get("machine.truth-probe-gap");
        }
        go();
        EXPECT_NEAR(bench.get("machine.truth-probe-gap"), 0, 1e-9);
        return {bench.get("machine.x-position"), bench.get("machine.y-position")};
    }

    void expect(const std::string& output, const std::string& axis_pin) {
        EXPECT_NEAR(setting(output, axis_pin), bench.get("machine.truth-" + axis_pin), 0.02 * urad)
            << axis_pin << '\n'
            << output;
    }

    // The test moves of an output: without correction, with it, and with the wrong signs.
    void verify(const std::string& output, std::size_t count, const Texts& pins) {
        const std::vector<TestMove> moves = test_moves(output);
        ASSERT_EQ(moves.size(), count) << output;
        const auto indicator = [&](const TestMove& move) {
            const auto lower = [](char c) {
                return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            };
            return on_square(lower(move.moved), lower(move.base), move.sign, move.travel);
        };
        for (const TestMove& move : moves) {
            EXPECT_GT(move.without, 0);
            EXPECT_NEAR(indicator(move), move.without * um, 0.06 * um) << move.name;
        }
        load(output);
        for (const TestMove& move : moves) EXPECT_NEAR(indicator(move), 0, 0.02 * um) << move.name;
        for (const std::string& pin : pins) bench.set("square." + pin, -setting(output, pin));
        for (const TestMove& move : moves)
            EXPECT_NEAR(indicator(move), move.wrong * um, 0.12 * um) << move.name;
    }

    // The component with the lines that were printed, between the axes and their drives.
    void load(const std::string& output) {
        const Folder folder;
        std::string lines = hal_lines(output);
        const std::string name = "names=square";
        lines.insert(lines.find(name) + name.size(), " interlock=no");
        bench.source(folder.write("square.hal", lines),
                     folder.write("machine.ini", "[TRAJ]\nMAX_LINEAR_VELOCITY = 1000\n"));
        for (const std::string axis : {"x", "y", "z", "w"}) {
            const bool chained = output.find("-W-") != std::string::npos || axis != "w";
            const std::string square = chained ? " square." + axis + "-position" : "";
            const std::string drive = " machine." + axis + "-position-cmd";
            bench.command("net " + axis + "-position machine." + axis + "-nominal" + square +
                          (axis == "w" ? drive : ""));
            if (axis != "w")
                bench.command("net " + axis + "-drive square." + axis + "-corrected-position" + drive);
        }
        bench.command("addf square.update servo-thread 1");
        bench.set("square.z-tool-offset", 200);
        bench.set("square.enable", 1);
        bench.set("square.all-homed", 1);
        corrected = true;
        go();
    }
};

struct SquarenessRecipeOfTheColumn : SquarenessRecipe {
    SquarenessRecipeOfTheColumn() {
        bench.set("machine.ea0y", 60 * urad);
        bench.set("machine.ec0y", -80 * urad);
        bench.run(0.001);
    }
    const Texts chain{"--chain", "w-Z.b-X-Y-C-t"};

    std::string advice(const std::string& option, const std::string& fields) {
        Texts words = chain;
        words.insert(words.end(), {option, fields});
        return plumb::advice(words);
    }
};

TEST_F(SquarenessRecipeOfTheColumn, TwoHeightsGiveItsTiltsAndTheTestMoveComesOut) {
    Texts words = chain;
    words.insert(words.end(), {"--datum", "X,Z,Y", "--square", two_heights('y', 'x', 1), "--square",
                               two_heights('y', 'z', -1)});
    const std::string output = plumb::advice(words);
    expect(output, "ec0y");
    expect(output, "ea0y");
    verify(output, 2, {"ec0y", "ea0y"});
}

TEST_F(SquarenessRecipeOfTheColumn, ProbedBoxGivesItsTilt) {
    go();
    const double height = tip()[2];
    const double from = 400, to = 800, in = 40, out = 20;
    put_box({from, from, height - 50}, {to - from, to - from, 100});
    struct Face {
        int normal;
        std::pair<double, double> a, b;
    };
    std::vector<Face> faces;
    for (const int sign : {1, -1}) {
        const double before = sign > 0 ? from - out : to + out;
        faces.push_back(
            {sign > 0 ? 180 : 0, probed(before, from + in, 'x', sign), probed(before, to - in, 'x', sign)});
        faces.push_back(
            {sign > 0 ? 270 : 90, probed(from + in, before, 'y', sign), probed(to - in, before, 'y', sign)});
    }
    std::string text = "X,Y,normal\n";
    for (const Face& face : faces)
        for (const auto& [x, y] : {face.a, face.b})
            text += number(x) + ',' + number(y) + ',' + std::to_string(face.normal) + '\n';
    const Folder folder;
    const std::string file = folder.write("box.csv", text);
    expect(advice("--points", "file=" + file + ",object=artifact,u=1um"), "ec0y");

    // Corners of the box, in readings of the encoders, as the lines through the points meet; ball and all.
    const auto corner = [](const Face& upright, const Face& level) {
        const double across = (upright.b.first - upright.a.first) / (upright.b.second - upright.a.second);
        const double rise = (level.b.second - level.a.second) / (level.b.first - level.a.first);
        const double y =
            (level.a.second + rise * (upright.a.first - level.a.first - across * upright.a.second)) /
            (1 - rise * across);
        return std::make_pair(upright.a.first + across * (y - upright.a.second), y);
    };
    const auto between = [](const std::pair<double, double>& a, const std::pair<double, double>& b) {
        return number(std::hypot(a.first - b.first, a.second - b.second)) + "mm";
    };
    const auto low = corner(faces[0], faces[1]), high = corner(faces[2], faces[3]);
    const auto left = corner(faces[0], faces[3]), right = corner(faces[2], faces[1]);
    expect(advice("--diagonals", "plane=XY,object=artifact,rising=" + between(low, high) +
                                     ",falling=" + between(left, right) + ",u=1um"),
           "ec0y");
}

TEST_F(SquarenessRecipeOfTheColumn, DiagonalsOfAPartThatItCutGiveItsTilt) {
    const auto cut = [&](double x, double y) {
        at['x'] = x;
        at['y'] = y;
        go();
        return tip();
    };
    const auto between = [](const Place& a, const Place& b) {
        return number(std::hypot(a[0] - b[0], a[1] - b[1])) + "mm";
    };
    const Place low = cut(100, 50), right = cut(500, 50), high = cut(500, 450), left = cut(100, 450);
    expect(advice("--diagonals", "plane=XY,object=part,rising=" + between(low, high) +
                                     ",falling=" + between(left, right) + ",u=1um"),
           "ec0y");
}

TEST_F(SquarenessRecipe, TwoHeightsGiveTheTiltsOfAPortalWithALevelSaddle) {
    bench.set("machine.portal", 1);
    bench.set("machine.axis-direction", 1);
    const Texts pins{"ea0w", "eb0w", "ea0z", "eb0z"};
    const double tilts[] = {40 * urad, -30 * urad, -25 * urad, 50 * urad};
    for (std::size_t i = 0; i < 4; ++i) bench.set("machine." + pins[i], tilts[i]);
    bench.run(0.001);
    Texts words{"--chain", "w-X.b-W-Y-Z-C-t", "--reading", "axis-direction"};
    for (const char moved : {'z', 'w'})
        for (const char base : {'x', 'y'})
            words.insert(words.end(), {"--square", two_heights(moved, base, moved == 'z' ? 1 : -1)});
    const std::string output = advice(words);
    for (const std::string& pin : pins) expect(output, pin);
    verify(output, 4, pins);
}

}  // namespace
}  // namespace plumb
