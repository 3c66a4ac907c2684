// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/command_line.hpp"

#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "commit.hpp"
#include "hal/identity.hpp"
#include "hal/program_end.hpp"
#include "hal/spelling.hpp"
#include "hal/standard_output.hpp"

namespace plumb::hal {
namespace {

// The first option in the command line that the program does not have, with the nearest that it has; or
// nothing. A parser that meets its value first blames this.
std::string unknown_option(const CLI::App& app, int argc, char** argv) {
    std::vector<std::string> names;
    std::vector<const CLI::App*> all = app.get_subcommands([](const CLI::App*) { return true; });
    all.push_back(&app);
    for (const CLI::App* one : all)
        for (const CLI::Option* option : one->get_options())
            for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--") break;
        if (word.rfind("--", 0) != 0) continue;
        const std::string name = word.substr(0, word.find('='));
        if (std::find(names.begin(), names.end(), name) == names.end())
            return "there is no option " + name + hal::suggestion(name, names);
    }
    return {};
}

int status_of(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const std::string option = error.get_exit_code() == 0 || app.get_prefix_command()
                                       ? std::string()
                                       : unknown_option(app, argc, argv);
        if (option.empty()) return app.exit(error) == 0 ? 0 : 2;
        std::cerr << app.get_name() << ": " << option << "\nRun with --help for more information.\n";
        return 2;
    }
    try {
        return work();
    } catch (const std::exception& error) {
        std::cerr << app.get_name() << ": " << reason(error) << '\n';
        return 1;
    }
}

}  // namespace

void begin_command_line(CLI::App& app, CommandPage (*page)()) {
    app.set_help_flag("-h,--help", "Prints the options.");
    app.set_version_flag("--version", "plumb " PLUMB_VERSION PLUMB_COMMIT, "Prints the version.");
    app.add_flag_callback("--summary",
                          [&app] {
                              std::cout << app.get_description() << '\n';
                              throw CLI::Success();
                          })
        ->group("")
        ->trigger_on_parse();
    add_manual(app, page);
}

int carry_out(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
    return when_written(status_of(app, argc, argv, work), app.get_name().c_str());
}

}  // namespace plumb::hal
