// SPDX-License-Identifier: GPL-2.0-or-later
// plumb COMMAND ...: the program that users of the virtual-time host run.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "hal/host/bench_command.hpp"
#include "hal/host/command_manual.hpp"
#include "hal/host/doctor_command.hpp"
#include "hal/host/run_command.hpp"
#include "hal/host/squareness_command.hpp"
#include "hal/host/squareness_manual.hpp"
#include "hal/identity.hpp"
#include "hal/standard_output.hpp"

namespace plumb::host {
namespace {

CommandPage plumb_page() {
    return {
        "plumb",
        "COMMAND [arguments]",
        {{"DESCRIPTION",
          R"(Plumb is a set of LinuxCNC HAL components that make a machine tool cut truer, and a host that runs
HAL in virtual time. This program is the way to the host: it tries a HAL configuration out over hours of
machine life in seconds, and runs the complete LinuxCNC faster than the clock.)"},
         {"EXIT STATUS", "0 after success, 1 after an error, 2 for a wrong command line."}},
        ".BR plumb\\-bench (1),\n.BR plumb\\-doctor (1),\n.BR plumb\\-run (1),\n.BR plumb\\-squareness "
        "(1),\n.BR halcmd (1)"};
}

// The words of the program that plumb run is to run: what the command did not know, and what follows the
// first --, which is the program's own when it does not begin it.
std::vector<std::string> program_of(std::vector<std::string> words, char** mark, char** end) {
    if (mark != end && words.empty()) ++mark;
    words.insert(words.end(), mark, end);
    return words;
}

int carry_out(int argc, char** argv) {
    CLI::App plumb("runs LinuxCNC HAL configurations in virtual time", "plumb");
    plumb.set_help_flag("-h,--help", "Prints the options.");
    plumb.set_version_flag("--version", "plumb " PLUMB_VERSION, "Prints the version.");
    plumb.require_subcommand(1);
    add_manual(plumb, plumb_page);

    CLI::App& bench_command =
        *plumb.add_subcommand("bench", "runs .hal files in virtual time and records pins");
    BenchOptions bench_options;
    declare_bench(bench_command, bench_options);
    add_manual(bench_command, bench_page);

    CLI::App& doctor_command =
        *plumb.add_subcommand("doctor", "says what is missing on this computer, and how to mend it");
    add_manual(doctor_command, doctor_page);

    CLI::App& run_command =
        *plumb.add_subcommand("run", "runs linuxcnc, halrun or halcmd faster than the clock");
    RunOptions run_options;
    declare_run(run_command, run_options);
    add_manual(run_command, run_page);

    CLI::App& squareness_command =
        *plumb.add_subcommand("squareness", "turns tilts or measurements into squareness settings");
    SquarenessOptions squareness_options;
    declare_squareness(squareness_command, squareness_options);
    add_manual(squareness_command, squareness_page);

    // What follows the first -- of plumb run is a program's, and nothing to be parsed.
    const bool runs = argc > 1 && std::string_view(argv[1]) == run_command.get_name();
    char** const mark = runs ? std::find(argv, argv + argc, std::string_view("--")) : argv + argc;
    try {
        plumb.parse(static_cast<int>(mark - argv), argv);
        const auto unknown = run_command.remaining();
        if (!unknown.empty() && unknown.front()[0] == '-')
            throw CLI::ExtrasError(run_command.get_name(), {unknown.front()});
    } catch (const CLI::ParseError& error) {
        return plumb.exit(error) == 0 ? 0 : 2;
    }
    const CLI::App& command = *plumb.get_subcommands().front();
    try {
        if (&command == &run_command)
            return run(run_options, program_of(run_command.remaining(), mark, argv + argc));
        if (&command == &squareness_command) return squareness(squareness_options);
        return &command == &doctor_command ? doctor() : bench(bench_options);
    } catch (const std::exception& error) {
        std::cerr << "plumb " << command.get_name() << ": " << error.what() << '\n';
        return 1;
    }
}

}  // namespace
}  // namespace plumb::host

int main(int argc, char** argv) {
    return plumb::when_written(plumb::host::carry_out(argc, argv), "plumb");
}
