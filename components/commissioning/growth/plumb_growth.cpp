// SPDX-License-Identifier: GPL-2.0-or-later
// plumb-growth: reports of growth tests, and the compensation that they give.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <spawn.h>
#include <sys/wait.h>

#include "components/commissioning/growth/growth_identify.hpp"
#include "components/commissioning/growth/growth_plan.hpp"
#include "components/commissioning/growth/growth_report.hpp"
#include "components/commissioning/picture_file.hpp"
#include "components/io/files/growth_logs.hpp"
#include "hal/command_line.hpp"
#include "hal/program_end.hpp"

extern char** environ;

namespace plumb::commissioning {
namespace {

namespace fs = std::filesystem;

hal::CommandPage growth_manual() {
    return {
        "plumb-growth",
        "report LOG...|GAUGES.csv [--distance MM] [--output DIR|--json] | identify LOG|GAUGES.csv... "
        "[--sensors "
        "A,B] | plan --hours H [--log LOG] [--door] [--ngc]",
        {{"DESCRIPTION",
          R"(Shows how much a machine grows as it warms, and whether its compensation helps. growth_log(1) writes the logs. A
log of a test that still runs, or that was interrupted, is as good: only a fail can be stated then.)"},
         {"REPORT",
          R"(plumb growth report LOG... writes a folder, LOG-report beside the first log or DIR:

  report.html   verdict, tables, charts, method; one file that needs nothing else
  results.json  all results in full precision, with rank and "determined"
  results.csv   every deviation and compensation of the first log
  *.hal         axis_growth_settings.hal, if the first log shows a law of the machine
  *.png         the charts of the first log, if python3-matplotlib is installed

Several logs are compared, such as before and after a repair. They must be of one machine. A folder stands for its last log. --json
prints results.json and writes nothing.

The verdict of an axis is pass if it stays within its tolerance by its uncertainty U, and the test reached its end. It is fail as
soon as a deviation leaves the tolerance by as much. The page has the budget of U. A prediction is advice and never counts.

The rms of offset minus drift names the axis that a compensation follows. The settings of axis_growth are those of
plumb growth identify without options.)"},
         {"REPORT OF GAUGES",
          R"(plumb growth report GAUGES.csv reads a record of displacement sensors at a mandrel, as ISO 230-3 uses them, in the form that
TABLES describes. X1 and Y1 are at the end of the mandrel, X2 and Y2 nearer to the spindle, --distance mm apart; they show the
tilt. It prints the displacements after 1 h and 4 h and in the end, their range and largest rate, the cool-down after the spindle
stopped, and the steady state. If the spindle did not turn, the ranges are the environmental temperature variation error (ETVE). It
names each quantity of ISO 230-3 that the record does not contain. The folder has report.html and results.json, with the values
as they were read. --json prints them.)"},
         {"TABLES",
          R"(GAUGES.csv is a table of a logger or a spreadsheet, whose first row follows a line of heads. Tabs, semicolons,
commas, bars or blanks separate the columns; the decimal mark is a point or a comma; the text is UTF-8, UTF-16 or
cp1252. Lines before the heads, empty lines and lines that begin with # are left out. Units stand in the heads, as
in T1 (degC), time [s] or Z_um, or in a line below them. Heads are:

  time            time, t, timestamp, elapsed; numbers, dates as 2026-03-31 08:00:00, or times of a day
  spindle speed   S, rpm, speed, spindle speed
  temperatures    T1, T2, ..., Temp_1, temp bearing, or any head with a unit of temperature
  growth          X, Y, Z, dz, Z growth, or X1, Y1, X2, Y2; in um if there is no unit

The program prints how the columns are taken, and names each column that is not read. Rows of one time count as
their mean. Empty fields and the words nan, NA, null, OL and error are missing values; any other word is refused
with its line. If a unit decides and the file does not show it, the program asks: state it in the head, or as
--head 'Z=Z (mm)', which reads a head as if it were another one.)"},
         {"IDENTIFY",
          R"(plumb growth identify LOG... prints the settings of axis_growth(9) as setp lines: how each axis grows with the
temperatures and along its travel, each term with its uncertainty. It needs four passes, and eight are better. Both states of a
compensation are as good. Several logs are days of one machine, in order: their law is more certain, and may contain the spindle speed.
--sensors names the sensors to use. The sensor of [artifact] of growth_log(1), or a sensor named artifact, is left out: it shows the
expansion of the artifact itself. --air names the sensor of the air, which moves no axis by more than 5 um for 3 K. --json prints
JSON.

LOG may be a record of gauges, as TABLES describes. The law numbers the sensors that it reads, and a comment has the name of each.

The lines are HAL, which has no place for a checksum. The log has one in each line, so you can print the settings again and
compare.

The program cuts the test into five parts, and predicts each later part by the law of the parts before. It uses a line over one
temperature if this line predicts better than no law, and a law of more terms if this law predicts much better than both. The comments
state the error of the law and the error of no law in these parts, and whether the error of the law exceeds the 5 um that axis_growth(9)
calls harmless. If no temperature predicts the growth of an axis, the program does
not compensate the axis, and the comment says so.)"},
         {"PLAN",
          R"(plumb growth plan --hours 4 offers the course of a growth test that separates the terms of the law of axis_growth:
speeds and rests, cycle by cycle. It states the standard uncertainty of each term before and after the test, and after a test that is
an hour longer. Growth on another day is the part of the error that comes from these terms, over four hours of drawn speeds.

--work and --pass are the minutes of a cycle, --fastest the highest speed in rpm. --door: somebody opens the shop door where the plan
says so; this separates the terms of the spindle and of the structure. --log: the plan is made for the machine of an earlier log, by its
temperatures, its speeds and the error of its law; without it for a usual machine. If the log does not state the expansion of the
artifact ([artifact] of growth_log(1)), this expansion hides much of the term of the structure. plumb growth identify states the
uncertainty of your machine. --ngc prints the subroutine growth_plan for the G-code of the test, --json JSON.)"},
         {"EXIT STATUS",
          R"(0 after success, with any verdict; 1 if a log is refused, with its line, and nothing was written; 2 for a wrong
command line.)"},
         {"EXAMPLES",
          R"(  plumb growth report growth-20261122-080000.csv

  plumb growth report before.csv after.csv --output repair

  plumb growth report mandrel.csv --distance 150 --output mandrel

  plumb growth identify growth-20261122-080000.csv > axis_growth_settings.hal

  plumb growth plan --hours 8 --door)"},
         {"LIMITS",
          R"(A compensation that is absent looks like one whose sensor is frozen, unless that sensor is logged. Swapped sensors
that change the compensation by less than a fifth of the drift may be called good.

Gauges were tested on computed records, not on sensors at a turning mandrel. A record of gauges is of one place: for both ends of a
travel take bores in a growth test.)"}},
        ".BR plumb (1),\n.BR growth_log (1),\n.BR thermal_growth_test (9),\n.BR axis_growth (9)"};
}

using Heads = std::map<std::string, std::string>;

GrowthCourse table_in(const std::string& file, const Heads& heads) {
    try {
        return read_growth_course(file, heads);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(std::string(error.what()) +
                                 ". The file was read as a table, as it does not begin with 'growth-log,'.");
    }
}

// A folder stands for its last log.
std::string file_of(const std::string& path) {
    if (!fs::is_directory(path)) return path;
    const auto last = last_growth_log(path);
    if (!last)
        throw std::runtime_error(path + ": there is no log of a growth test, or several without a number");
    return last->string();
}

fs::path folder_of(const std::string& file, const std::string& output) {
    const fs::path first = fs::absolute(file);
    return output.empty() ? first.parent_path() / (first.stem().string() + "-report") : fs::path(output);
}

template <class Log>
void need_one_machine(const std::vector<Log>& logs) {
    for (const Log& log : logs)
        if (log.machine != logs.front().machine)
            throw std::runtime_error(log.file + " is of the machine '" + log.machine + "', and " +
                                     logs.front().file + " of '" + logs.front().machine + "'");
}

// Runs one of the programs beside Plumb's other shared files, with this file as its input. `why`: what is
// missing if it fails.
void run_python(const std::string& name, std::vector<std::string> words, std::FILE* input,
                const std::string& why) {
    const fs::path program = fs::read_symlink("/proc/self/exe");
    words.insert(words.begin(),
                 {"python3", "-B", program.parent_path().parent_path() / "share/plumb/growth" / name});
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    if (input) posix_spawn_file_actions_adddup2(&files, fileno(input), 0);
    pid_t child = 0;
    int status = 0;
    const bool begun =
        posix_spawn(&child, "/usr/bin/python3", &files, nullptr, arguments.data(), environ) == 0;
    posix_spawn_file_actions_destroy(&files);
    if (!begun || waitpid(child, &status, 0) != child || status != 0)
        throw std::runtime_error(why + ": see above");
}

nlohmann::ordered_json samples_json(const GrowthSamples& samples) {
    nlohmann::ordered_json both{{"time_s", nlohmann::ordered_json::array()},
                                {"value", nlohmann::ordered_json::array()}};
    for (const auto& [time, value] : samples) both["time_s"].push_back(time), both["value"].push_back(value);
    return both;
}

// The table as it was read, for growth_gauges.py.
nlohmann::ordered_json table_json(const GrowthCourse& course) {
    if (!(course.values.back().time > course.values.front().time))
        throw std::runtime_error(course.file + ": has one value. " + course.taken);
    nlohmann::ordered_json all{
        {"file", course.file}, {"taken", course.taken}, {"version_of_plumb", PLUMB_VERSION}};
    nlohmann::ordered_json series{{"speed_rpm", samples_json(course.speeds)},
                                  {"temperature_degc", nlohmann::ordered_json::object()},
                                  {"growth_mm", nlohmann::ordered_json::object()},
                                  {"upper_mm", nlohmann::ordered_json::object()}};
    for (const auto& value : course.values) all["time_s"].push_back(value.time);
    for (const auto& sensor : course.sensors)
        series["temperature_degc"][sensor.name] = samples_json(sensor.samples);
    for (int axis = 0; axis < 3; ++axis) {
        GrowthSamples grown, upper;
        for (const auto& value : course.values) {
            if (std::isfinite(value.place[axis])) grown.emplace_back(value.time, value.place[axis]);
            if (axis < 2 && std::isfinite(value.upper[axis]))
                upper.emplace_back(value.time, value.upper[axis]);
        }
        if (!grown.empty()) series["growth_mm"][std::string(1, letters[axis])] = samples_json(grown);
        if (!upper.empty()) series["upper_mm"][std::string(1, letters[axis])] = samples_json(upper);
    }
    all["series"] = series;
    return all;
}

int report_gauges(const std::string& file, const Heads& heads, double distance, const std::string& output,
                  bool json) {
    const std::string table = table_json(table_in(file, heads)).dump();
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> input(std::tmpfile(), std::fclose);
    if (!input || std::fwrite(table.data(), 1, table.size(), input.get()) != table.size())
        throw std::system_error(errno, std::generic_category(), "a temporary file");
    std::rewind(input.get());
    std::vector<std::string> words{fs::read_symlink("/proc/self/exe"), std::to_string(distance)};
    if (!json) words.push_back(folder_of(file, output));
    run_python("growth_gauges.py", words, input.get(), file + " was read, but not measured");
    return 0;
}

// The curves of the series in the input, for growth_gauges.py.
int print_curves() {
    nlohmann::json curves = nlohmann::json::array();
    for (const auto& its : nlohmann::json::parse(std::cin)) {
        GrowthSamples samples;
        for (std::size_t i = 0; i < its["time_s"].size(); ++i)
            samples.emplace_back(its["time_s"][i], its["value"][i]);
        const auto curve = curve_of(samples);
        curves.push_back(nullptr);
        if (curve)
            curves.back() = {{"steady", curve->steady},         {"low", curve->low()},
                             {"high", curve->high()},           {"noise", curve->noise},
                             {"determined", curve->determined}, {"shorter", curve->shorter}};
    }
    std::cout << curves;
    return 0;
}

int report(const std::vector<std::string>& files, const std::string& output, bool json) {
    std::vector<GrowthLog> logs;
    for (const std::string& file : files) logs.push_back(read_growth_log(file));
    need_one_machine(logs);
    std::vector<GrowthAnalysis> tests;
    for (const GrowthLog& log : logs) {
        tests.push_back(analysed(log));
        identify_law(tests.back());
    }
    if (json) {
        std::cout << growth_json(tests);
        return 0;
    }
    const fs::path folder = folder_of(files.front(), output);
    fs::create_directories(folder);
    write_file(folder / "results.json", growth_json(tests));
    const fs::path settings = folder / "axis_growth_settings.hal";
    if (tests.front().identified)
        write_file(settings,
                   growth_settings(logs.front().file, logs.front().begun, *tests.front().identified));
    else
        fs::remove(settings);
    for (const GrowthAnalysis& test : tests) std::cout << growth_summary(test) << std::flush;
    run_python("growth_page.py", {folder}, nullptr, folder.string() + " has the results, but not their page");
    std::cout << "Report: " << (folder / "report.html").string() << '\n';
    return 0;
}

GrowthCourse course_in(const std::string& file, const Heads& heads) {
    return is_growth_log(file) ? course_of(read_growth_log(file)) : table_in(file, heads);
}

// Each as HEAD=HEAD.
Heads heads_of(const std::vector<std::string>& words) {
    Heads heads;
    for (const std::string& word : words) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos || equals == 0)
            throw CLI::ValidationError("--head", "'" + word + "' is not as 'Z=Z (mm)'");
        heads[word.substr(0, equals)] = word.substr(equals + 1);
    }
    return heads;
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
    double distance = 0;
    bool json = false;
    std::vector<std::string> heads;
    CLI::App* const reporting =
        app.add_subcommand("report", "Makes a report of logs, or of a table of gauges.");
    reporting->alias("gauges");  // its former name for a table of gauges
    reporting->add_option("logs", logs, "Logs of growth_log, of one machine, or a table of gauges.")
        ->required()
        ->type_name("LOG");
    reporting->add_option("--distance", distance, "Between the two sensors of X and of Y.")
        ->check(CLI::Range(1.0, 10000.0))
        ->type_name("MM");
    reporting->add_option("--output", output, "Folder for the report.")->type_name("DIR");
    CLI::App* const fitting = app.add_subcommand("curve", "Fits curves for growth_gauges.py.")->group("");
    GrowthIdentifyOptions identify;
    CLI::App* const identifying =
        app.add_subcommand("identify", "Prints the settings of axis_growth that a log gives.");
    identifying
        ->add_option("logs", logs, "Logs of growth_log, or CSVs of gauges: days of one machine, in order.")
        ->required()
        ->type_name("LOG");
    identifying
        ->add_option("--sensors", identify.sensors, "Sensors to use; by default all but the artifact's.")
        ->delimiter(',')
        ->type_name("A,B");
    identifying->add_option("--air", identify.air, "Sensor of the air; air by default.")->type_name("NAME");
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
    planning->add_option("--log", logs, "Log of an earlier test of this machine.")
        ->expected(1)
        ->type_name("LOG");
    planning->add_flag("--door", wanted.door, "The shop door may be opened.");
    planning->add_flag("--ngc", as_program, "Print the subroutine growth_plan.");
    for (CLI::App* const each : {reporting, identifying, planning}) {
        each->add_flag("--json", json,
                       each == reporting ? "Print the results as JSON, and write no folder." : "Print JSON.");
        each->add_option("--head", heads, "Read a head of a table as another one.")->type_name("'HEAD=HEAD'");
    }
    return plumb::hal::carry_out(app, argc, argv, [&] {
        if (*fitting) return print_curves();
        for (std::string& path : logs) path = file_of(path);
        if (*planning) {
            if (!logs.empty())
                wanted.machine = plan_machine_of(course_in(logs.front(), heads_of(heads)), wanted.fastest);
            const GrowthPlan plan = growth_plan(wanted);
            std::cout << (json ? plan.json() : as_program ? plan.program() : plan.text());
            return 0;
        }
        if (*identifying) {
            std::vector<GrowthCourse> courses;
            for (const std::string& day : logs) courses.push_back(course_in(day, heads_of(heads)));
            const GrowthCourse& first = courses.front();
            if (first.places) need_one_machine(courses);
            const GrowthIdentified found = growth_identified(courses, identify);
            if (json) {
                nlohmann::json all = growth_identified_json(found);
                all["logs"] = logs;
                all["machine"] = first.machine;
                for (const GrowthCourse& course : courses)
                    if (!course.taken.empty()) all["taken"].push_back(course.taken);
                std::cout << all.dump(1) << '\n';
            } else {
                std::string files, begun = first.begun;
                for (const std::string& day : logs) files += (files.empty() ? "" : ", ") + day;
                std::cout << growth_settings(files, begun, found);
                for (const GrowthCourse& course : courses)
                    if (!course.taken.empty())
                        std::cout << "# " << course.file << ": " << course.taken << '\n';
            }
            return 0;
        }
        if (logs.size() == 1 && !is_growth_log(logs.front()))
            return report_gauges(logs.front(), heads_of(heads), distance, output, json);
        return report(logs, output, json);
    });
}

int main(int argc, char** argv) {
    return plumb::ended("plumb growth", [&] { return carry_out(argc, argv); });
}
