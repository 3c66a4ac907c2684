// SPDX-License-Identifier: GPL-2.0-or-later
// plumb-growth: reports of growth tests, and the compensation that they give.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "components/commissioning/growth/growth_fit.hpp"
#include "components/commissioning/growth/growth_gauges.hpp"
#include "components/commissioning/growth/growth_identify.hpp"
#include "components/commissioning/growth/growth_plan.hpp"
#include "components/commissioning/growth/growth_report.hpp"
#include "components/commissioning/picture_file.hpp"
#include "hal/command_line.hpp"
#include "hal/program_end.hpp"
#include "hal/regular_file.hpp"

extern char** environ;

namespace plumb::commissioning {
namespace {

namespace fs = std::filesystem;

hal::CommandPage growth_manual() {
    return {
        "plumb-growth",
        "report LOG... [--output DIR] | gauges GAUGES.csv [--distance MM] [--output DIR] | identify "
        "LOG|GAUGES.csv... [--sensors A,B] | fit SERIES.csv [--time "
        "COLUMN] "
        "[--columns A,B] | plan --hours H [--log LOG] [--door] [--ngc]",
        {{"DESCRIPTION",
          R"(Shows how much a machine grows as it warms, and whether its compensation helps. growth_log(1) writes the logs. A
log of a test that still runs, or that was interrupted, is as good: only a fail can be stated then.)"},
         {"REPORT",
          R"(plumb growth report LOG... writes a folder, LOG-report beside the first log or DIR:

  report.html   verdict, tables, charts, method; one file that needs nothing else
  results.json  all results in full precision, with rank and "determined"
  results.csv   every deviation and compensation of the first log
  *.hal         axis_growth_settings.hal, if the first log shows a law of the machine
  *.png         the charts of the first log, if rsvg-convert is installed

Several logs are compared, such as before and after a repair. They must be of one machine.

The verdict of an axis is pass if it stays within its tolerance by its uncertainty U, and the test reached its end. It is fail as
soon as a deviation leaves the tolerance by as much. The page has the budget of U. A prediction is advice and never counts.

Cross gains and the rms of offset minus drift show which axis a compensation follows. The settings of axis_growth are those of
plumb growth identify without options.)"},
         {"GAUGES",
          R"(plumb growth gauges GAUGES.csv reads a record of displacement sensors at a mandrel, as ISO 230-3 uses them, in the form that
IDENTIFY describes. X1 and Y1 are at the end of the mandrel, X2 and Y2 nearer to the spindle, --distance mm apart; they show the
tilt. It prints the displacements after 1 h and 4 h and in the end, their range and largest rate, the cool-down after the spindle
stopped, and the steady state. If the spindle did not turn, the ranges are the environmental temperature variation error (ETVE). It
names each quantity of ISO 230-3 that the record does not contain. --output writes report.html into a folder, --json prints JSON.)"},
         {"IDENTIFY",
          R"(plumb growth identify LOG... prints the settings of axis_growth(9) as setp lines: how each axis grows with the
temperatures and along its travel, each term with its uncertainty. It needs four passes, and eight are better. Both states of a
compensation are as good. Several logs are days of one machine, in order: their law is more certain, and may contain the spindle speed.
--sensors names the sensors to use. The one named artifact is left out, and shows the expansion of the artifact itself; --artifact gives
it another name. --air names the sensor of the air, which moves no axis by more than 5 um for 3 K. --no-speed leaves the spindle speed
out. --instance names the component. --json prints JSON.

LOG may be a CSV file of gauges that were read continuously. Its first line names the columns: time_s, time_min or time_h (time is in
min); spindle_rpm, rpm or S; T1, T2, ... or names that end in _degC; and X, Y, Z or x_um, y_um, z_um, the growth in um. A field
that is no number is a missing value. The law numbers the sensors that it reads, and a comment has the name of each.

The lines are HAL, which has no place for a checksum. The log has one in each line, so you can print the settings again and
compare.

The program cuts the test into five parts, and predicts each later part by the law of the parts before. It uses a line over one
temperature if this line predicts better than no law, and a law of more terms if this law predicts much better than both. The comments
state the error of the law and the error of no law in these parts. If no temperature predicts the growth of an axis, the program does
not compensate the axis, and the comment says so.)"},
         {"PLAN",
          R"(plumb growth plan --hours 4 offers the course of a growth test that separates the terms of the law of axis_growth:
speeds and rests, cycle by cycle. It states the standard uncertainty of each term before and after the test, and after a test that is
an hour longer. Growth on another day is the part of the error that comes from these terms, over four hours of drawn speeds.

--work and --pass are the minutes of a cycle, --fastest the highest speed in rpm. --door: somebody opens the shop door where the plan
says so; this separates the terms of the spindle and of the structure. --log: the plan is made for the machine of an earlier log, by its
temperatures, its speeds and the error of its law; without it for a usual machine. --rest is the error that the law leaves of a pass,
in um. --artifact: its expansion is known, as by [artifact] of growth_log(1); otherwise it hides much of the term of the
structure. plumb growth identify states the uncertainty of your machine. --ngc prints the subroutine growth_plan for the G-code
of the test, --json JSON.)"},
         {"FIT",
          R"(plumb growth fit SERIES.csv predicts the steady state of each column, if its duty goes on. The first line names
the columns; --time names the column of times, in s or in units of --time-unit s. Lines that begin with # are comments.
--uncertainty is the standard uncertainty of a value. --json prints JSON.

The growth is a sum of exponentials with time constants from one minute to three times the length of the series, at most
eight hours, each of either sign. 95 of 100 steady states lie between low and high. Not determined: low and high are
further apart than the values.)"},
         {"EXIT STATUS",
          R"(0 after success, with any verdict; 1 if a log is refused, with its line, and nothing was written; 2 for a wrong
command line.)"},
         {"EXAMPLES",
          R"(  plumb growth report growth-20261122-080000.csv

  plumb growth report before.csv after.csv --output repair

  plumb growth gauges mandrel.csv --distance 150 --output mandrel

  plumb growth identify growth-20261122-080000.csv > axis_growth_settings.hal

  plumb growth plan --hours 8 --door

  plumb growth fit gauge.csv --time minutes --time-unit 60)"},
         {"LIMITS",
          R"(A compensation that is absent looks like one whose sensor is frozen, unless that sensor is logged. Swapped sensors
that change the compensation by less than a fifth of the drift may be called good.

Gauges were tested on computed records, not on sensors at a turning mandrel. A record of gauges is of one place: for both ends of a
travel take bores in a growth test.)"}},
        ".BR plumb (1),\n.BR growth_log (1),\n.BR thermal_growth_test (9),\n.BR axis_growth (9)"};
}

int report(const std::vector<std::string>& files, std::string output) {
    std::vector<GrowthLog> logs;
    for (const std::string& file : files) logs.push_back(read_growth_log(file));
    for (const GrowthLog& log : logs)
        if (log.machine != logs.front().machine)
            throw std::runtime_error(log.file + " is of the machine '" + log.machine + "', and " +
                                     logs.front().file + " of '" + logs.front().machine + "'");
    std::vector<GrowthAnalysis> tests;
    for (const GrowthLog& log : logs) {
        tests.push_back(analysed(log));
        identify_law(tests.back());
    }
    const fs::path first = fs::absolute(files.front());
    const fs::path folder =
        output.empty() ? first.parent_path() / (first.stem().string() + "-report") : fs::path(output);
    fs::create_directories(folder);
    write_file(folder / "report.html", growth_page(tests));
    write_file(folder / "results.json", growth_json(tests));
    write_file(folder / "results.csv", growth_csv(tests.front()));
    const fs::path settings = folder / "axis_growth_settings.hal";
    if (tests.front().identified)
        write_file(settings,
                   growth_settings(logs.front().file, logs.front().begun, *tests.front().identified));
    else
        fs::remove(settings);
    bool drawn = true;
    for (const GrowthChart& chart : growth_charts(tests.front())) {
        const fs::path svg = folder / (chart.file + ".svg");
        write_file(svg, chart.svg(true));
        drawn = drawn && to_png(svg, folder / (chart.file + ".png"));
        fs::remove(svg);
    }
    for (const GrowthAnalysis& test : tests) std::cout << growth_summary(test);
    std::cout << "Report: " << (folder / "report.html").string() << '\n';
    if (!drawn) std::cout << "No PNG charts: install rsvg-convert (librsvg2-bin).\n";
    return 0;
}

GrowthCourse course_in(const std::string& file) {
    return is_growth_log(file) ? course_of(read_growth_log(file)) : read_growth_course(file);
}

}  // namespace
}  // namespace plumb::commissioning

static int carry_out(int argc, char** argv) {
    using namespace plumb::commissioning;
    CLI::App app("shows how much a machine grows as it warms", "plumb growth");
    plumb::hal::begin_command_line(app, growth_manual);
    app.require_subcommand(1);
    std::vector<std::string> logs;
    std::string output;
    CLI::App* const reporting = app.add_subcommand("report", "Makes a report of one or several logs.");
    reporting->add_option("logs", logs, "Logs of growth_log, of one machine.")->required()->type_name("LOG");
    reporting->add_option("--output", output, "Folder for the report.")->type_name("DIR");
    GrowthIdentifyOptions identify;
    std::string log;
    std::vector<std::string> days;
    bool no_speed = false;
    CLI::App* const identifying =
        app.add_subcommand("identify", "Prints the settings of axis_growth that a log gives.");
    identifying
        ->add_option("logs", days, "Logs of growth_log, or CSVs of gauges: days of one machine, in order.")
        ->required()
        ->type_name("LOG");
    identifying
        ->add_option("--sensors", identify.sensors, "Sensors to use; by default all but the artifact's.")
        ->delimiter(',')
        ->type_name("A,B");
    identifying->add_option("--artifact", identify.artifact, "Sensor of the artifact; artifact by default.")
        ->type_name("NAME");
    identifying->add_option("--air", identify.air, "Sensor of the air; air by default.")->type_name("NAME");
    identifying->add_option("--instance", identify.instance, "Name of the component; axis-growth by default.")
        ->type_name("NAME");
    identifying
        ->add_option("--speed-exponent", identify.speed_exponent, "Exponent of the speed; 1.7 by default.")
        ->check(CLI::Range(0.1, 4.0))
        ->type_name("P");
    identifying->add_flag("--no-speed", no_speed, "Leave the spindle speed out.");
    double distance = 0;
    CLI::App* const gauging =
        app.add_subcommand("gauges", "Reads a record of displacement sensors at a mandrel.");
    gauging->add_option("record", log, "CSV of gauges.")->required()->type_name("GAUGES.csv");
    gauging->add_option("--distance", distance, "Between the two sensors of X and of Y.")
        ->check(CLI::Range(1.0, 10000.0))
        ->type_name("MM");
    gauging->add_option("--output", output, "Folder for report.html.")->type_name("DIR");
    GrowthPlanOptions wanted;
    bool as_program = false;
    CLI::App* const planning =
        app.add_subcommand("plan", "Offers a test that separates the terms of the law.");
    const auto positive = [&](const char* name, double& value, const char* doc, const char* type) {
        return planning->add_option(name, value, doc)->check(CLI::Range(0.1, 1e6))->type_name(type);
    };
    positive("--hours", wanted.hours, "Length of the test.", "H")->required()->check(CLI::Range(0.1, 48.0));
    positive("--work", wanted.work, "Work in a cycle; 30 min by default, less in a short test.", "MIN");
    positive("--pass", wanted.pass, "Length of a pass; 10 min by default.", "MIN");
    positive("--fastest", wanted.fastest, "Highest speed; 8000 rpm by default.", "RPM");
    CLI::Option* const rest = positive("--rest", wanted.machine.rest,
                                       "Error that the law leaves of a pass; 2 um by default.", "UM");
    planning->add_option("--log", log, "Log of an earlier test of this machine.")->type_name("LOG");
    planning->add_flag("--artifact", wanted.machine.artifact_known,
                       "The expansion of the artifact is known.");
    planning->add_flag("--door", wanted.door, "The shop door may be opened.");
    planning->add_flag("--ngc", as_program, "Print the subroutine growth_plan.");
    GrowthFitOptions fit;
    bool json = false;
    CLI::App* const fitting =
        app.add_subcommand("fit", "Predicts the steady state of columns of a CSV file.");
    fitting->add_option("series", fit.file, "CSV file whose first line names the columns.")
        ->required()
        ->type_name("SERIES");
    fitting->add_option("--time", fit.time, "Column of times; time_s by default.")->type_name("COLUMN");
    fitting->add_option("--time-unit", fit.time_unit, "Length of its unit in s.")
        ->check(CLI::PositiveNumber)
        ->type_name("S");
    fitting->add_option("--columns", fit.columns, "Columns to fit; all by default.")
        ->delimiter(',')
        ->type_name("A,B");
    fitting->add_option("--uncertainty", fit.uncertainty, "Standard uncertainty of a value.")
        ->check(CLI::NonNegativeNumber)
        ->type_name("U");
    for (CLI::App* const each : {gauging, identifying, planning, fitting})
        each->add_flag("--json", json, "Print JSON.");
    return plumb::hal::carry_out(app, argc, argv, [&] {
        if (*fitting) {
            std::cout << growth_fit(fit, json);
            return 0;
        }
        if (*gauging) {
            const GrowthGauges found = growth_gauges(read_growth_course(log), distance);
            if (!output.empty()) {
                fs::create_directories(output);
                write_file(fs::path(output) / "report.html", found.page());
            }
            std::cout << (json ? found.json() : found.text());
            return 0;
        }
        if (*planning) {
            if (!log.empty()) {
                const double given = wanted.machine.rest;
                const bool known = wanted.machine.artifact_known;
                wanted.machine = plan_machine_of(course_in(log), wanted.fastest);
                if (rest->count() > 0) wanted.machine.rest = given;
                wanted.machine.artifact_known |= known;
            }
            const GrowthPlan plan = growth_plan(wanted);
            std::cout << (json ? plan.json() : as_program ? plan.program() : plan.text());
            return 0;
        }
        if (*identifying) {
            identify.speed = !no_speed;
            std::vector<GrowthCourse> courses;
            for (const std::string& day : days) courses.push_back(course_in(day));
            const GrowthCourse& first = courses.front();
            for (const GrowthCourse& course : courses)
                if (course.places && course.machine != first.machine)
                    throw std::runtime_error(course.file + " is of the machine '" + course.machine +
                                             "', and " + first.file + " of '" + first.machine + "'");
            const GrowthIdentified found = growth_identified(courses, identify);
            if (json) {
                nlohmann::json all = growth_identified_json(found);
                all["logs"] = days;
                all["machine"] = first.machine;
                std::cout << all.dump(1) << '\n';
            } else {
                std::string files, begun = first.begun;
                for (const std::string& day : days) files += (files.empty() ? "" : ", ") + day;
                std::cout << growth_settings(files, begun, found);
            }
            return 0;
        }
        return report(logs, output);
    });
}

int main(int argc, char** argv) {
    return plumb::ended("plumb growth", [&] { return carry_out(argc, argv); });
}
