// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/command_line.hpp"

#include <exception>
#include <iostream>

#include "hal/identity.hpp"
#include "hal/standard_output.hpp"

namespace plumb::hal {
namespace {

int status_of(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        return work();
    } catch (const std::exception& error) {
        std::cerr << app.get_name() << ": " << error.what() << '\n';
        return 1;
    }
}

}  // namespace

void begin_command_line(CLI::App& app, CommandPage (*page)()) {
    app.set_help_flag("-h,--help", "Prints the options.");
    app.set_version_flag("--version", "plumb " PLUMB_VERSION, "Prints the version.");
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
