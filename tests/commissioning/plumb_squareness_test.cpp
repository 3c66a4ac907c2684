// SPDX-License-Identifier: GPL-2.0-or-later
// `plumb squareness` as its users meet it.
#include "components/commissioning/squareness/squareness_advice.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <cctype>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using testing::ContainsRegex;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

using Texts = std::vector<std::string>;

Outcome squareness(const Texts& arguments) {
    Texts words{build_folder() + "/bin/plumb", "squareness"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return run_program(words, "/");
}

std::string output_of(const Texts& arguments) {
    const Outcome outcome = squareness(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    EXPECT_EQ(outcome.errors, "");
    EXPECT_THAT(outcome.output, Not(ContainsRegex("[^\n]{101}"))) << "a line is too long";
    return outcome.output;
}

// The part of an output below a title.
std::string below(const std::string& title, const std::string& output) {
    const std::size_t begin = output.find('\n' + title);
    if (begin == std::string::npos) return "";
    return output.substr(begin, output.find("\n\n", begin + 1) - begin);
}

// The table of directions, for the axes of each chain: the lean, and its quantity.
struct Direction {
    const char *lean, *quantity;
    int sign;
};
const std::pair<const char*, std::vector<Direction>> directions[] = {
    {"w-Z.b-X-Y-C-t", {{"Y+X", "EC0Y", -1}, {"Y+Z", "EA0Y", 1}}},
    {"w-Z.b-X-Y-C-t", {{"Y-X", "EC0Y", 1}, {"Y-Z", "EA0Y", -1}}},
    {"w-X.b-W-Y-Z-C-t",
     {{"Z+X", "EB0Z", 1},
      {"Z+Y", "EA0Z", -1},
      {"W+X", "EB0W", 1},
      {"W+Y", "EA0W", -1},
      {"X+Y", "EC0X", 1},
      {"X+Z", "EB0X", -1}}},
    {"w-X.b-W-Y-Z-C-t",
     {{"Z-X", "EB0Z", -1},
      {"Z-Y", "EA0Z", 1},
      {"W-X", "EB0W", -1},
      {"W-Y", "EA0W", 1},
      {"X-Y", "EC0X", -1},
      {"X-Z", "EB0X", 1}}},
};

TEST(PlumbSquareness, EachLeanIsItsQuantityAndEachQuantityItsLean) {
    for (const auto& [chain, rows] : directions) {
        Texts by_lean{"--chain", chain}, by_quantity{"--chain", chain};
        for (const Direction& row : rows) {
            by_lean.insert(by_lean.end(), {"--lean", std::string(row.lean) + "=50urad"});
            by_quantity.insert(by_quantity.end(),
                               {"--iso", std::string(row.quantity) + (row.sign < 0 ? "=-" : "=") + "50um/m"});
        }
        for (const Texts& given : {by_lean, by_quantity}) {
            const std::string output = output_of(given);
            for (const Direction& row : rows) {
                const std::string sign = row.sign < 0 ? "-" : "";
                std::string pin = row.quantity;
                for (char& c : pin) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
                EXPECT_THAT(output, HasSubstr("setp square." + pin + ' ' + sign + "5e-05 ")) << row.lean;
                EXPECT_THAT(below("Angles", output) + '\n',
                            ContainsRegex(std::string(row.quantity) + " +" + sign + "5.0000e-05 [^\n]* " +
                                          row.lean[0] + " to [" + row.lean[1] + "]" + row.lean[2] + "\n"));
            }
        }
    }
}

TEST(PlumbSquareness, RefusesBothOfAnOppositePair) {
    const Outcome outcome =
        squareness({"--lean", "Y-Z=1urad", "--lean", "Y+X=5arcsec", "--lean", "Y-X=3arcsec"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(
        outcome.errors,
        HasSubstr("--lean: 'Y-X=3arcsec': axis Y cannot lean towards +X and -X at once: choose one\n"));
}

TEST(PlumbSquareness, PrintsAllThatBelongsTogether) {
    const std::string output =
        output_of({"--chain", "w-Z.b-X-Y-C-t", "--lean", "Y+X=0.024mm/300mm", "--lean", "Y+Z=60um/m"});
    EXPECT_THAT(output, HasSubstr("Z carries the work; X, then Y carry the tool."));
    EXPECT_THAT(
        output,
        HasSubstr("  EC0Y   -8.0000e-05   -16.50  -0.00458    -80.00   -0.0240  -0.00096  Y to +X\n"));
    EXPECT_THAT(
        output,
        HasSubstr("  EA0Y    6.0000e-05    12.38   0.00344     60.00    0.0180   0.00072  Y to +Z\n"));
    EXPECT_THAT(below("Where squareness is loaded", output),
                EndsWith("\n  loadrt squareness names=square chain=w-Z.b-X-Y-C-t"));
    EXPECT_THAT(below("Behind it, in the file of settings", output),
                HasSubstr("\n  setp square.axis-direction 0      # reading: component\n"
                          "  setp square.ea0y 6e-05            # Y leans to +Z by 12.38 arcsec\n"
                          "  setp square.ec0y -8e-05           # Y leans to +X by 16.50 arcsec\n"));
    EXPECT_THAT(output,
                HasSubstr("EA0Y    Z       +Z       Y by 300 mm        +18.0 um      0 um     +36.0 um\n"));
    EXPECT_THAT(output,
                HasSubstr("EC0Y    X       +X       Y by 300 mm        +24.0 um      0 um     +48.0 um\n"));

    const std::string inch =
        output_of({"--chain", "w-X.b-W-Y-Z-C-t", "--iso", "EA0W=-30urad", "--unit", "inch", "--reading",
                   "axis-direction", "--against", "bed", "--instance", "portal"});
    EXPECT_THAT(inch, HasSubstr("loadrt squareness names=portal chain=w-X.b-W-Y-Z-C-t unit=inch\n"));
    EXPECT_THAT(inch, HasSubstr("setp portal.axis-direction 1"));
    EXPECT_THAT(inch, HasSubstr("setp portal.to-bed 1"));
    EXPECT_THAT(inch,
                HasSubstr("EA0W    Y       +Y       W by 12 in      +0.00036 in      0 in  +0.00072 in\n"));
}

TEST(PlumbSquareness, WithoutTiltsItPrintsThoseThatTheChainCanHave) {
    const std::string output = output_of({"--chain", "w-X.b-W-Y-Z-C-t"});
    EXPECT_THAT(output, HasSubstr("--lean W+Y=ANGLE  EA0W is -     or  W-Y=ANGLE  EA0W is +\n"));
    EXPECT_THAT(output, HasSubstr("--lean X+Z=ANGLE  EB0X is -     or  X-Z=ANGLE  EB0X is +\n"));
    EXPECT_THAT(output, Not(HasSubstr("setp")));
}

TEST(PlumbSquareness, MeasurementsGiveAngleSignAndUncertainty) {
    const std::string output =
        output_of({"--chain", "w-Z.b-X-Y-C-t", "--datum", "X,Z", "--diagonals",
                   "plane=XY,object=part,rising=565.708mm,falling=565.662mm,u=1um", "--square",
                   "move=Y,plunger=+Z,at=0:300mm,reads=0:20um,turned=0:-16um,U=2um"});
    EXPECT_THAT(output, HasSubstr("  EC0Y   -8.1317e-05 "));
    EXPECT_THAT(output, HasSubstr("  EA0Y    6.0000e-05 "));
    EXPECT_THAT(output, HasSubstr("    k=1   2.5000e-06 ")) << "1 um on diagonals of a side of 400 mm";
    EXPECT_THAT(output, HasSubstr("    k=2   6.6667e-06 ")) << "2 um over 300 mm";
    EXPECT_THAT(output, HasSubstr("setp square.ec0y -8.13173e-05     # Y leans to +X by 16.77 arcsec\n"));
    EXPECT_THAT(output, HasSubstr("Y by 300 mm        +24.4 um      0 um     +48.8 um\n"));

    const std::string artifact =
        output_of({"--chain", "w-Z.b-X-Y-C-t", "--diagonals",
                   "plane=XY,object=artifact,rising=565.708mm,falling=565.662mm,u=30um"});
    EXPECT_THAT(artifact, HasSubstr("setp square.ec0y 8.13173e-05 "));
    EXPECT_THAT(artifact, HasSubstr("Note: EC0Y is less than its uncertainty with k=2"));
}

TEST(PlumbSquareness, AnOpeningIsThatOfThePart) {
    const auto given = [](const std::string& object) {
        return output_of(
            {"--chain", "w-Z.b-X-Y-C-t", "--opening", "plane=XY,object=" + object + ",angle=80urad,U=6urad"});
    };
    EXPECT_THAT(given("part"), HasSubstr("setp square.ec0y 8e-05 "));
    EXPECT_THAT(given("part"), HasSubstr("    k=1   3.0000e-06 "));
    EXPECT_THAT(given("artifact"), HasSubstr("setp square.ec0y -8e-05 "));
}

TEST(PlumbSquareness, RotaryAxesOfAChainStandAtZero) {
    const Texts square = {"--square", "move=Z,plunger=+X,at=0:300mm,reads=0:24um,u=1um"};
    const auto lines = [&](const std::string& chain) {
        Texts all = {"--chain", chain};
        all.insert(all.end(), square.begin(), square.end());
        return hal_lines(output_of(all));
    };
    EXPECT_THAT(lines("w-C-A-Y.b-X-Z-t"), HasSubstr("square.eb0z 8"));
    const auto settings = [](const std::string& text) { return text.substr(text.find("setp")); };
    EXPECT_EQ(settings(lines("w-C-A-Y.b-X-Z-t")), settings(lines("w-Y.b-X-Z-t")));
    EXPECT_EQ(squareness({"--chain", "w-A-A-Y.b-X-Z-t"}).status, 2);
}

// The component with the lines for the .hal file in an output.
void set_up(Bench& bench, const std::string& output) {
    const Folder folder;
    bench.source(folder.write("square.hal", hal_lines(output)),
                 folder.write("machine.ini", "[TRAJ]\nMAX_LINEAR_VELOCITY = 1000\n"));
    bench.command("addf square.update servo-thread");
    bench.set("square.all-homed", 1);
}

// The component, set so, knows of the error that the indicator is to show.
TEST(PlumbSquareness, LinesForTheHalFileMakeTheComponentSeeWhatTheTestMoveShows) {
    const std::string output = output_of({"--chain", "w-X.b-W-Y-Z-C-t", "--square",
                                          "move=Z,plunger=+Y,at=0:200mm,reads=0:-10um,u=1um", "--square",
                                          "move=W,plunger=-Y,at=0:200mm,reads=0:6um,u=1um"});
    EXPECT_THAT(output, HasSubstr("EA0Z    Y       -Y       Z by 300 mm        +15.0 um "));
    EXPECT_THAT(output, HasSubstr("EA0W    Y       -Y       W by 300 mm         +9.0 um "));
    Bench bench;
    set_up(bench, output);
    bench.set("square.z-position", 300);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("square.y-error"), -0.015, 1e-6);
    bench.set("square.z-position", 0);
    bench.set("square.w-position", 300);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("square.y-error"), -0.009, 1e-6);
}

TEST(PlumbSquareness, LinesForAnInchMachineBoundByTheSameLengths) {
    Bench bench;
    set_up(bench, output_of({"--iso", "EC0Y=50urad", "--unit", "inch"}));
    EXPECT_DOUBLE_EQ(bench.get("square.max-correction"), 1 / 25.4);
    EXPECT_DOUBLE_EQ(bench.get("square.max-rate"), 0.1 / 25.4);
}

// No other number suits each machine; a setting that is left out would be a fault.
TEST(PlumbSquareness, LinesForTheHalFileTakeTheSpeedOfTheAxesFromTheIniFile) {
    for (const char* unit : {"mm", "inch"})
        EXPECT_THAT(output_of({"--iso", "EC0Y=50urad", "--unit", unit}),
                    HasSubstr("\n  setp square.max-speed [TRAJ]MAX_LINEAR_VELOCITY # of the INI file"));
}

TEST(PlumbSquareness, LinesForTheHalFileLetTheComponentTakeALargeAngle) {
    const std::string output =
        output_of({"--chain", "w-X.b-Y-Z-C-t", "--iso", "EA0Z=3.5mrad", "--iso", "EB0Z=-8mrad"});
    EXPECT_THAT(output, HasSubstr("setp square.max-angle 0.008 "));
    EXPECT_THAT(output, HasSubstr("Note: EA0Z is more than the component takes by default"));
    Bench bench;
    set_up(bench, output);
    bench.set("square.z-position", 100);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("square.y-error"), -0.35, 1e-5);
    EXPECT_NEAR(bench.get("square.x-error"), -0.8, 1e-4);
    EXPECT_EQ(bench.get("square.limited"), 0);
}

TEST(PlumbSquareness, SquareOnATableThatMovesInBothGivesBothAngles) {
    const std::string output = output_of({"--square", "move=Y,plunger=+X,at=0:300mm,reads=0:20um,u=1um"});
    EXPECT_THAT(output, HasSubstr("setp square.ec0x 6.66667e-05 "));
    EXPECT_THAT(output, HasSubstr("setp square.ec0y -6.66667e-05 "));
    EXPECT_THAT(output, HasSubstr("EC0Y    X       +X       Y by 300 mm        +20.0 um "));
    Bench bench;
    set_up(bench, output);
    bench.set("square.y-position", 300);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("square.x-error"), 0.02, 1e-6);
    EXPECT_THAT(output_of({"--lean", "Y+X=0.02mm/300mm"}), ContainsRegex("by[ \n]+--square[ \n]+instead"));
}

TEST(PlumbSquareness, DatumThatIsSetCountsInWhatWasMeasuredAgainstIt) {
    const std::string output = output_of({"--chain", "w-X.b-W-Y-Z-C-t", "--lean", "X+Z=50urad", "--square",
                                          "move=Z,plunger=+X,at=0:300mm,reads=0:24um,u=1um"});
    EXPECT_THAT(output, HasSubstr("setp square.eb0x -5e-05 "));
    EXPECT_THAT(output, HasSubstr("setp square.eb0z 3e-05 "));
    EXPECT_THAT(output, HasSubstr(" Z by 300 mm        +24.0 um ")) << "the measured rise";

    const Outcome outcome =
        squareness({"--iso", "EC0X=50urad", "--square", "move=Y,plunger=+X,at=0:300mm,reads=0:24um,u=1um"});
    EXPECT_EQ(outcome.status, 1) << "X rides on Y: its own angle is the corner";
    EXPECT_EQ(outcome.output, "");
}

TEST(PlumbSquareness, AxesThatTurnTogetherAreTestedOnTheTable) {
    const std::string output = output_of({"--chain", "w-X.b-W-Y-Z-C-t", "--lean", "W-Y=41um/m"});
    EXPECT_THAT(output,
                HasSubstr("EA0W    table   -Z       Y by 300 mm        -12.3 um      0 um     -24.6 um\n"));
    Bench bench;
    set_up(bench, output);
    bench.set("square.y-position", 300);
    bench.run(0.01);
    EXPECT_NEAR(bench.get("square.z-error"), 0.0123, 1e-6) << "away from the table";
}

TEST(PlumbSquareness, RepeatingDoesNotMakeTheSquareItselfMoreCertain) {
    const std::string field = "move=Y,plunger=+X,at=0:300mm,reads=0:24um,u=0.1um,own-u=10arcsec";
    EXPECT_THAT(output_of({"--chain", "w-Z.b-X-Y-t", "--square", field, "--square", field, "--square", field,
                           "--square", field}),
                ContainsRegex("k=1 +4.84[0-9]+e-05 +10.00 "));
}

TEST(PlumbSquareness, EachSingleWrongSignHasItsReading) {
    const std::string output =
        output_of({"--chain", "w-X.b-W-Y-Z-C-t", "--iso", "EB0Z=121um/m", "--iso", "EB0W=-97um/m"});
    EXPECT_THAT(output, HasSubstr("all wrong\n"));
    EXPECT_THAT(output, ContainsRegex("EB0Z +X +.X +Z by 300 mm +.7.2 um +0 um +.14.4 um"));
    EXPECT_THAT(output, ContainsRegex("only EB0Z wrong +.72.6 um"));  // 2 * 121 um/m * 300 mm
    EXPECT_THAT(output, ContainsRegex("only EB0W wrong +-58.2 um"));
    EXPECT_THAT(output_of({"--iso", "EC0Y=-80urad"}), Not(HasSubstr("only EC0Y wrong")))
        << "there is one sign only";
}

TEST(PlumbSquareness, WhatRemainedIsAddedToWhatIsInForce) {
    const std::string output =
        output_of({"--chain", "w-Z.b-X-Y-C-t", "--square", "move=Y,plunger=+X,at=0:300mm,reads=0:6um,u=1um",
                   "--in-force", "EC0Y=-80urad", "--in-force", "EA0Y=60urad"});
    EXPECT_THAT(output, HasSubstr("setp square.ec0y -0.0001 "));  // -80 and -20 urad
    EXPECT_THAT(output, HasSubstr("setp square.ea0y 6e-05"));     // not measured
    EXPECT_THAT(output, HasSubstr("EC0Y: -16.50 arcsec is in force"));
    EXPECT_EQ(squareness({"--in-force", "EC0Y=80urad", "--in-force", "EC0Y=80urad"}).status, 2);
    EXPECT_NE(squareness({"--in-force", "EC0Y=0.09rad", "--iso", "EC0Y=0.09rad"}).status, 0);
}

TEST(PlumbSquareness, UsualNotationsOfChainsAreUnderstood) {
    for (const char* const text : {"[w-Z'-b-X-Y-(C)-t]", "wZbXY(C)t", "w Z' b X Y C1 t", "t-C-Y-X-b-Z-w"})
        EXPECT_THAT(output_of({"--chain", text, "--iso", "EC0Y=10urad"}), HasSubstr("chain=w-Z.b-X-Y-C-t"))
            << text;
    EXPECT_THAT(output_of({"--chain", "bXY(C)t", "--iso", "EC0Y=10urad"}), HasSubstr("chain=b-X-Y-C-t"));
    const Outcome outcome = squareness({"--chain", "wXbX(C)t"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.errors, HasSubstr("read as w-X.b-X-C-t"));
}

std::string json_of(Texts arguments) {
    arguments.insert(arguments.begin(), "--json");
    const Outcome outcome = squareness(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.errors;
    return outcome.output;
}

TEST(PlumbSquareness, JsonIsForOtherPrograms) {
    const std::string output = json_of({"--chain", "w-Z.b-X-Y-C-t", "--iso", "EC0Y=-80urad"});
    for (const char* const words :
         {"\"pin\": \"ec0y\"", "\"value\": \"-8e-05\"", "\"moved\": \"Y\"", "\n \"chain\": \"w-Z.b-X-Y-C-t\"",
          "\n \"quantities\": [", "\n \"settled\": [", "\n \"moves\": [", "\n \"unseen\": [",
          "\n \"notes\": [", "\n \"work\": \"Z\"", "\n \"tool\": \"XY\"", "\n \"slopes\": ["})
        EXPECT_THAT(output, HasSubstr(words));
}

TEST(PlumbSquareness, OutputInJsonIsAnInputThatGivesItself) {
    const Folder folder;
    const Texts commands[] = {
        {"--chain", "w-Z.b-X-Y-C-t", "--lean", "Y+X=0.024mm/300mm", "--lean", "Y+Z=60um/m", "--in-force",
         "EA0Y=60urad"},
        {"--chain",      "w-X.b-W-Y-Z-C-t",
         "--square",     "move=Z,plunger=+Y,at=0:200mm,reads=0:-10um,u=1um",
         "--square",     "move=W,plunger=-Y,at=0:200mm,reads=0:6um,u=1um",
         "--against",    "bed",
         "--reading",    "axis-direction",
         "--unit",       "inch",
         "--directions", "X=left,Z=up",
         "--correction", "off",
         "--in-force",   "EB0W=12arcsec",
         "--travel",     "10in",
         "--frame",      "column"},
        {"--diagonals", "plane=XY,object=artifact,rising=565.708mm,falling=565.662mm,U=30um,own=1arcsec",
         "--datum", "Y,X"},
        {"--opening", "plane=YZ,object=part,angle=20urad,u=1urad"},
        {},
    };
    for (const Texts& command : commands) {
        const std::string output = json_of(command);
        const std::string file = folder.write("output.json", output);
        EXPECT_EQ(json_of({"--input", file}), output);
        Texts in_words = command;
        EXPECT_EQ(output_of({"--input", file}), output_of(in_words));
    }
}

TEST(PlumbSquareness, DocumentGivesAllLeansAtOnce) {
    const Folder folder;
    const std::string file = folder.write("portal.json", R"({
 "chain": "w-X.b-W-Y-Z-C-t", "correction": "off",
 "leans": [{"lean": "X+Y", "angle": "10um/m", "U": "4um/m"}],
 "in_force": [{"name": "EA0W", "angle": 1e-5}, {"name": "EB0Z", "angle": 3e-5}],
 "measurements": [{"by": "square", "move": "Z", "plunger": "+X", "at": [0, 300], "reads": "0:20um", "u": 0.001}]})");
    const std::string output = output_of({"--input", file});
    EXPECT_THAT(output, HasSubstr("setp square.ec0x 1e-05 "));
    EXPECT_THAT(output, HasSubstr("setp square.ea0w 1e-05 ")) << "stays in force";
    EXPECT_THAT(output, HasSubstr("setp square.eb0z 6.66668e-05 ")) << "takes the place of the one in force";
    EXPECT_THAT(
        below("Squareness before and after", output),
        HasSubstr("X to Z: before: -36.7 um over 1 m; after: 0 \u00b1 9.5 um over 1 m, straightness\n"));
    EXPECT_THAT(output, HasSubstr("Y to W: not measured."));
}

TEST(PlumbSquareness, RefusalOfADocumentNamesItsPlace) {
    const std::pair<const char*, const char*> cases[] = {
        {R"({"chain":"w-Z.b-X-Y-t","leans":[{"lean":"Y-X","angle":"3arcsec"},{"lean":"Y+X","angle":1e-5}]})",
         "leans[1]: 'Y+X=1.0000000000000001e-05rad': axis Y cannot lean towards -X and +X at once: choose "
         "one"},
        {R"({"chain":"w-Z.b-X-Y-t","leans":[{"lean":"Y+X","angle":1e-5},{"name":"EC0Y","angle":1e-5}]})",
         "leans[1]: 'EC0Y=1.0000000000000001e-05rad': EC0Y is set twice"},
        {R"({"chain":"w-Z.b-X-Y-t","leans":[{"lean":"Y+X","angle":1e-5}],
             "in_force":[{"name":"EC0Y","angle":1e-5}]})",
         "correction: it is missing: on if the angles in force acted as you measured, or off"},
        {R"({"chain":"w-Z.b-X-Y-t","leans":[{"lean":"Y+X","name":"EC0Y","angle":0}]})",
         "leans[0]: one of lean"},
        {R"({"chain":"w-Z.b-X-Y-t","leans":[{"lean":"Y+X","angle":0,"u":0,"U":1}]})", "leans[0]: one of u"},
        {R"({"chain":"w-Z.b-X-Y-t","leans":[{"lean":"Y+X","angle":0,"u":"1um"}]})", "leans[0]: "},
        {R"({"chain":"w-Z.b-X-Y-t","chain":"w-X-Y.b-Z-t"})", "chain: it is there twice"},
        {R"({"chain":"w-Z.b-X-Y-t","lean":[]})", "the document: there is no 'lean'; there are chain, unit"},
        {R"({"chain":5})", "chain: it is no text"},
        {R"({})", "the document: chain is missing"},
        {R"([])", "the document: it is no object { }"},
        {R"({"chain":"w-Z.b-X-Y-t","unit":"cm"})", "unit: 'cm' is not mm or inch"},
        {R"({"chain":"w-Z.b-X-Y-t","measurements":[{"move":"Y"}]})",
         "measurements[0]: by is missing: square, diagonals, opening or points"},
        {R"({"chain":"w-Z.b-X-Y-t","measurements":[{"by":"square","move":"Y","plunger":"+X","at":[0,"300"]}]})",
         "measurements[0].at: the list has something that is no number"},
        {R"({"chain":"w-Z.b-X-Y-t","measurements":[{"by":"square","move":"W","plunger":"+X","at":[0,300],
             "reads":[0,1],"u":1}]})",
         "measurements[0]: the chain has no axis W"},
        {R"({"chain":"w-Z.b-X-Y-t","directions":"X=right,Y=back,Z=down"})",
         "directions: 'X=right,Y=back,Z=down': with X right and Y back, Z points up, not down"},
        {R"({"chain":"w-Z.b-X-Y-t","directions":"X=right,Y=left"})",
         "directions: 'X=right,Y=left': axes X and Y cannot point right and left"},
        {R"({"chain":"w-Z.b-X-Y-t","directions":"X=right"})",
         "directions: the directions of two axes are necessary"},
        {R"({"chain")", "no JSON: parse error at line 1"},
    };
    const Folder folder;
    for (const auto& [document, reason] : cases) {
        const std::string file = folder.write("machine.json", document);
        const Outcome outcome = squareness({"--json", "--input", file});
        EXPECT_EQ(outcome.status, 1) << document;
        EXPECT_EQ(outcome.output, "");
        EXPECT_THAT(outcome.errors, HasSubstr("plumb squareness: " + file + ": " + reason));
    }
    EXPECT_EQ(squareness({"--input", folder.write("a.json", "{}"), "--iso", "EC0Y=1urad"}).status, 2);
    EXPECT_EQ(squareness({"--input", "/nowhere.json"}).errors,
              "plumb squareness: /nowhere.json: No such file or directory\n");
    EXPECT_EQ(squareness({"--input", "/"}).status, 1);
}

TEST(PlumbSquareness, ListOfLeansNamesThoseThatCorrectNothing) {
    EXPECT_THAT(output_of({}),
                HasSubstr("Y-X=ANGLE  EC0Y is +\n      Corrects nothing: Y turns X and the work"));
    EXPECT_THAT(output_of({"--chain", "w-Z.b-X-Y-C-t"}), Not(HasSubstr("Corrects nothing: Y")));
}

TEST(PlumbSquareness, DrawsTheMachine) {
    const Folder folder;
    const std::string svg = (folder.path() / "machine.svg").string();
    const Texts lean{"--chain", "w-Z.b-X-Y-C-t", "--lean", "Y+X=60um/m", "--directions", "X=left,Y=up"};
    Texts words = lean;
    words.insert(words.end(), {"--picture", svg});
    EXPECT_EQ(output_of(words), output_of(lean));
    EXPECT_THAT(contents(svg), HasSubstr(">Y leans to +X</text>"));
    words.back() = (folder.path() / "machine.png").string();
    const Outcome outcome = squareness(words);
    if (outcome.status == 0)
        EXPECT_EQ(contents(words.back()).substr(1, 3), "PNG");
    else  // rsvg-convert is not installed
        EXPECT_THAT(outcome.errors, HasSubstr("install librsvg2-bin"));
    words.back() = "/nowhere/machine.svg";
    EXPECT_EQ(squareness(words).status, 1);
    words.back() = "machine.gif";
    EXPECT_EQ(squareness(words).status, 2);
}

TEST(PlumbSquareness, PicturesOfTheReadmeAreThoseThatItDraws) {
    const std::pair<const char*, Texts> pictures[] = {
        {"column.svg",
         {"--chain", "w-Z.b-X-Y-C-t", "--directions", "X=left,Y=up,Z=back", "--lean", "Y+X=60um/m"}},
        {"table.svg", {"--chain", "w-X-Y.b-Z-C-t", "--lean", "X+Y=60um/m"}},
        {"portal.svg",
         {"--chain", "w-X.b-W-Y-Z-C-t", "--directions", "X=front,Y=right,Z=up", "--lean", "W+Y=60um/m",
          "--lean", "Z-Y=60um/m"}}};
    const Folder folder;
    for (const auto& [name, command] : pictures) {
        Texts words = command;
        words.insert(words.end(), {"--picture", (folder.path() / name).string()});
        EXPECT_EQ(squareness(words).status, 0);
        EXPECT_EQ(contents(folder.path() / name),
                  contents(std::string(source_folder() + "/components/commissioning/squareness/") + name));
    }
}

TEST(PlumbSquareness, ChecksErrorTablesAndPrintsWhatTheyState) {
    const Folder folder;
    const std::string head = "# machine: mill 7\n# date: 2026-11-20\n# temperature: 20.1 degC\n";
    const std::string file = folder.write("x.csv", head + "X,EXX\n-5,0\n10,0.001\n# end, 2 rows\n");
    EXPECT_EQ(output_of({"--table", file}),
              file +
                  "\n  axes         X\n  rows         2\n  machine      mill 7\n"
                  "  date         2026-11-20\n  temperature  20.1 degC\n"
                  "  seal         none; check the table, then run\n    plumb squareness --table " +
                  file +
                  " --seal\n"
                  "X from -5 to 10 mm\n");
    folder.write("x.csv", head + "X,EXX\n-5,0\n10,0.001\n");
    const Outcome outcome = squareness({"--table", file});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.errors, HasSubstr("plumb squareness: " + file + ": the end is missing"));
    EXPECT_THAT(outcome.errors, HasSubstr("add as the last line: # end, 2 rows\n"));
}

TEST(PlumbSquareness, SealsErrorTables) {
    const Folder folder;
    const std::string file =
        folder.write("x.csv", "# temperature: 20.1 degC\nX,EXX\n-5,0\n10,0.001\n# end, 2 rows\n");
    EXPECT_THAT(output_of({"--table", file, "--seal"}), HasSubstr("  seal         97cbb2e2\n"));
    const std::string sealed = contents(file);
    EXPECT_THAT(sealed, HasSubstr("\n# end, seal 97cbb2e2, 2 rows\n"));
    EXPECT_THAT(output_of({"--table", file}), HasSubstr("  seal         97cbb2e2\n"));

    std::string edited = sealed;
    edited.replace(edited.find("20.1"), 4, "30.1");
    folder.write("x.csv", edited);
    const Outcome refused = squareness({"--table", file});
    EXPECT_EQ(refused.status, 1);
    EXPECT_THAT(refused.errors, HasSubstr("check it, then: plumb squareness --table " + file + " --seal\n"));
    EXPECT_EQ(squareness({"--table", file, "--seal"}).status, 0);
    EXPECT_EQ(squareness({"--table", file}).status, 0);

    folder.write("x.csv", "X,EXX\n-5,0\n10,50\n# end, 2 rows\n");
    const Outcome wrong = squareness({"--table", file, "--seal"});
    EXPECT_EQ(wrong.status, 1);
    EXPECT_THAT(wrong.errors, HasSubstr("column EXX: '50' is beyond 10 mm"));
    EXPECT_EQ(contents(file), "X,EXX\n-5,0\n10,50\n# end, 2 rows\n");
    EXPECT_EQ(squareness({"--seal", "--iso", "EC0Y=10urad"}).status, 2);
}

// Without the ends of the lines.
std::string words_of(const std::string& text) {
    std::istringstream words(text);
    std::string result;
    for (std::string word; words >> word;) result += (result.empty() ? "" : " ") + word;
    return result;
}

TEST(PlumbSquareness, GivesTheHomeOffsetThatTurnsABeamSquare) {
    const auto beam = [](const std::string& chain, const std::string& datum, const std::string& square,
                         const std::string& gantry) {
        return words_of(
            output_of({"--chain", chain, "--datum", datum, "--square", square, "--gantry", gantry}));
    };
    const std::string square = "move=X,plunger=+Y,at=0:300mm,reads=0:24um,u=1um";
    const std::string text = beam("w.b-Y-X-Z-C-t", "Y,X", square, "Y=100mm:1300mm");
    EXPECT_THAT(text, HasSubstr("EC0X 8.0000e-05"));
    EXPECT_THAT(text, HasSubstr("Add +0.0960 +- 0.0113 (k=2) mm to HOME_OFFSET of the joint at X 1300"));
    // Z on two screws across X: the sign is the other one. The beam leans by +Z over X: EB0X < 0.
    EXPECT_THAT(
        beam("w-Y.b-Z-X-C-t", "Z,X", "move=X,plunger=+Z,at=0:300mm,reads=0:24um,u=1um", "Z=0mm:1000mm"),
        HasSubstr("Add +0.0800 +- 0.0094 (k=2) mm to HOME_OFFSET of the joint at X 1000"));
    EXPECT_THAT(
        words_of(output_of({"--chain", "w.b-Y-X-Z-C-t", "--iso", "EA0Y=1urad", "--gantry", "Y=0mm:1200mm"})),
        HasSubstr("The beam is EC0X, which was not measured. With --datum Y,X a square shows it."));
    for (const char* wrong : {"Z=0mm:1200mm", "Y=0mm:5mm", "Y=1200mm", "X=0mm:1200mm", "Y=1200mm:0mm"})
        EXPECT_EQ(squareness({"--chain", "w-X.b-Y-Z-C-t", "--gantry", wrong, "--iso", "EC0Y=1urad"}).status,
                  2)
            << wrong;
}

TEST(PlumbSquareness, RefusesATableOfAnAxisThatLinuxCNCCompensates) {
    const Folder folder;
    const std::string file = folder.write(
        "both.csv", "X,EXX+,EXX-\n0,0,0\n10,0,0\nY,EXY\n0,0\n10,0\nZ,EZZ\n0,0\n10,0\n# end, 6 rows\n");
    const auto refused = [&](const std::string& ini) {
        const Outcome outcome = squareness(
            {"--table", file, "--ini", folder.write("my.ini", "[TRAJ]\nCOORDINATES = XYZ\n" + ini)});
        EXPECT_EQ(outcome.status, outcome.errors.empty() ? 0 : 1);
        return outcome.errors;
    };
    EXPECT_THAT(refused("[JOINT_0]\nBACKLASH = 0.01\n"),
                HasSubstr("my.ini: line 4: 'BACKLASH = 0.01': LinuxCNC compensates X already"));
    EXPECT_THAT(refused("[JOINT_2]\nCOMP_FILE = z.comp\n"), HasSubstr("LinuxCNC compensates Z already"));
    EXPECT_EQ(refused("[JOINT_1]\nCOMP_FILE = y.comp\n"), "");  // no scale of Y in the table
    EXPECT_EQ(refused("[JOINT_0]\nBACKLASH = 0.000 # none\n"), "");
    folder.write("x.inc", "[JOINT_0]\n\nBACKLASH = 0.02\n");
    EXPECT_THAT(refused("#INCLUDE x.inc\n"), HasSubstr("x.inc: line 3: 'BACKLASH = 0.02'"));
    EXPECT_THAT(refused("#INCLUDE my.ini\n"), HasSubstr("too many files include each other"));
    EXPECT_EQ(squareness({"--ini", file, "--iso", "EC0Y=10urad"}).status, 2);
}

TEST(SquarenessAdvice, IsThereForAScreenToo) {
    commissioning::TiltedMachine machine;
    machine.chain_text = "w-Z.b-X-Y-C-t";
    machine.chain = AxisChainReader::read(machine.chain_text);
    machine.order = {Axis::X, Axis::Y, Axis::Z};
    machine.measured = {{Axis::X, Axis::Y, -80e-6, 2e-6, 0, 0}};
    const commissioning::SquarenessAdvice advice = commissioning::advice_on(machine);
    ASSERT_EQ(advice.settings.size(), 4u);
    EXPECT_EQ(advice.settings[0].pin, "max-speed");
    EXPECT_EQ(advice.settings[2].pin, "ec0y");
    EXPECT_EQ(advice.settings[2].value, "-8e-05");
    EXPECT_EQ(advice.settings[3].pin, "y-tool-follows");
    EXPECT_FALSE(advice.settings[3].in_force);
    ASSERT_EQ(advice.moves.size(), 1u);
    EXPECT_EQ(advice.moves[0].moved, Axis::Y);
    EXPECT_EQ(advice.moves[0].base, Axis::X);
    EXPECT_EQ(advice.moves[0].plunger.sign, 1);
    EXPECT_NEAR(advice.moves[0].rise, 24 * um, 0.001 * um);

    machine.order = {Axis::X, Axis::Z};
    EXPECT_THROW(commissioning::advice_on(machine), std::invalid_argument)
        << "Y is left out, and its corner stays open";
}

TEST(PlumbSquareness, ReadsProbedPoints) {
    const Folder folder;  // an artifact that is true, by axes of which Y leans to +X by 80 urad
    const std::string text =
        "X,Y,normal\n100.008,-100,0\n99.992,100,0\n-99.992,-100,180\n-100.008,100,180\n"
        "-100.008,100,90\n99.992,100,90\n-99.992,-100,270\n100.008,-100,270\n";
    const std::string square = folder.write("square.csv", text);
    const std::string of_file = ",object=artifact,u=1um";
    EXPECT_THAT(output_of({"--chain", "w-Z.b-X-Y-C-t", "--points", "file=" + square + of_file}),
                HasSubstr("setp square.ec0y -8e-05 "));
    const std::string wrong = folder.write("wrong.csv", text + "55,100,270\n");
    const Outcome outcome = squareness({"--points", "file=" + wrong + of_file});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.errors,
                HasSubstr("plumb squareness: " + wrong + ": line 10: the points do not lie on such"));
    const std::string bad = folder.write("bad.csv", "X,Y\n1,2,5\n");
    EXPECT_EQ(squareness({"--points", "file=" + bad + of_file}).errors,
              "plumb squareness: " + bad +
                  ": line 2: 3 values, but line 1 has 2 heads; is the comma a decimal mark? Then separate by "
                  "semicolons\n");
}

TEST(PlumbSquareness, RefusalNamesOptionTextAndReason) {
    const std::pair<Texts, std::string> cases[] = {
        {{"--chain", "w-X"}, "--chain: chain \"w-X\", character 4: expected -, not the end"},
        {{"--lean", "Y+X=5"}, "--lean: 'Y+X=5': '5' has no unit; there are: rad mrad"},
        {{"--lean", "W+X=5arcsec"}, "--lean: 'W+X=5arcsec': the chain has no axis W"},
        {{"--lean", "Y+Y=5arcsec"}, "axis Y cannot lean towards +Y: it moves along it"},
        {{"--lean", "Y+X=1urad", "--iso", "EC0Y=1urad"}, "--iso: 'EC0Y=1urad': EC0Y is set twice"},
        {{"--iso", "EB0Y=1urad"}, "EB0Y turns Y about itself: that is no lean"},
        {{"--iso", "EC0Y=1rad"}, "'1rad' is not an angle below 0.1 rad"},
        {{"--datum", "X,Q"}, "--datum: 'X,Q': 'Q' is no axis"},
        {{"--travel", "300"}, "--travel: '300' has no unit"},
        {{"--reading", "both"}, "--reading: 'both' is neither component nor axis-direction"},
        {{"--instance", "a b"}, "--instance: 'a b' is no name for HAL"},
        {{"--diagonals", "plane=XY"}, "--diagonals: 'plane=XY': rising is missing"},
        {{"--diagonals", "plane=XY,object=piece,rising=5mm,falling=5mm,u=1um"},
         "object=piece is neither part"},
        {{"--square", "move=Y,plunger=+X,at=0:300mm,reads=0:1:2um,u=1um"}, "3 readings at 2 positions"},
        {{"--square", "move=Y,plunger=+X,at=0:300mm,reads=0:24,u=1um"}, "reads: '24' has no unit"},
        {{"--square", "move=Y,plunger=+X,at=0:300mm,reads=0:24um,u=0um"}, "u=0um is less than anybody can"},
        {{"--square", "move=Y,plunger=+X,at=0:300mm,reads=0:24um,u=1um,own-u=0"},
         "own-u: '0' is no uncertainty"},
        {{"--diagonals", "plane=XY,object=artifact,rising=5mm,falling=5mm,u=1um,own=99deg"},
         "an artifact is not out of square by 1.727876 rad"},
        {{"--diagonals", "plane=XY,object=artifact,rising=5.2mm,falling=4.8mm,u=1um,own=0.09rad"},
         "the axes would be out of square by 0.16"},
        {{"--points", "object=part,u=1um"}, "file is missing"},
        {{"--opening", "plane=XY,object=part,angle=20,u=1urad"}, "angle: '20' has no unit"},
        {{"--opening", "plane=XY,object=part,angle=20urad"}, "one of u, the standard uncertainty, and U"},
        {{"--opening", "plane=XX,object=part,angle=20urad,u=1urad"}, "plane=XX: the axes are parallel"},
        {{"--opening", "plane=XY,object=part,angle=20deg,u=1urad"}, "angle=20deg is not below 0.1 rad"},
        {{"--opening", "plane=XY,object=part,angle=20urad,u=0urad"}, "u: '0urad' is no uncertainty"},
    };
    for (const auto& [arguments, reason] : cases) {
        const Outcome outcome = squareness(arguments);
        EXPECT_EQ(outcome.status, 2) << reason;
        EXPECT_EQ(outcome.output, "");
        EXPECT_THAT(outcome.errors, HasSubstr(reason));
    }
    const Outcome twice = squareness({"--chain", "w-Z.b-X-Y-t", "--lean", "Y+X=1urad", "--square",
                                      "move=Y,plunger=+X,at=0:300mm,reads=0:24um,u=1um"});
    EXPECT_EQ(twice.status, 1);
    EXPECT_EQ(twice.errors,
              "plumb squareness: EC0Y is set and follows from measurements, too: leave one out\n");
}

TEST(PlumbSquareness, RefusesAnglesThatFollowFromOthersAndCannotBe) {
    const Outcome sum = squareness({"--chain", "w-X-Y.b-W-Z-C-t", "--iso", "EA0W=-0.06rad", "--square",
                                    "move=Z,plunger=+Y,at=0:300mm,reads=0:-15mm,u=1um"});
    EXPECT_EQ(sum.status, 1);
    EXPECT_EQ(sum.output, "");
    EXPECT_THAT(sum.errors,
                HasSubstr("plumb squareness: EA0Z would be 0.11 rad: an angle is below 0.1 rad\n"));
}

}  // namespace
}  // namespace plumb
