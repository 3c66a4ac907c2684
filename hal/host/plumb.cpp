// SPDX-License-Identifier: GPL-2.0-or-later
// plumb COMMAND ...: the program that users of the virtual-time host run.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <exception>
#include <iostream>

#include "hal/host/bench_command.hpp"
#include "hal/host/command_manual.hpp"

namespace plumb::host {
namespace {

CommandPage plumb_page() {
    return {
        "plumb",
        "COMMAND [arguments]",
        {{"DESCRIPTION",
          R"(Plumb is a set of LinuxCNC HAL components that make a machine tool cut truer, and a host that runs
HAL in virtual time. This program is the way to the host: it tries a HAL configuration out over hours of
machine life in seconds, with LinuxCNC's own HAL and modules.)"},
         {"EXIT STATUS", "0 after success, 1 after an error, 2 for a wrong command line."}},
        ".BR plumb\\-bench (1),\n.BR halcmd (1)"};
}

int run(int argc, char** argv) {
    CLI::App plumb("runs LinuxCNC HAL configurations in virtual time", "plumb");
    plumb.set_help_flag("-h,--help", "Prints the options.");
    plumb.set_version_flag("--version", "plumb " PLUMB_VERSION, "Prints the version.");
    plumb.require_subcommand(1);
    add_manual(plumb, plumb_page);

    CLI::App& command = *plumb.add_subcommand("bench", "runs .hal files in virtual time and records pins");
    BenchOptions options;
    declare_bench(command, options);
    add_manual(command, bench_page);

    try {
        plumb.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return plumb.exit(error) == 0 ? 0 : 2;
    }
    try {
        return bench(options);
    } catch (const std::exception& error) {
        std::cerr << "plumb bench: " << error.what() << '\n';
        return 1;
    }
}

}  // namespace
}  // namespace plumb::host

int main(int argc, char** argv) {
    return plumb::host::run(argc, argv);
}
