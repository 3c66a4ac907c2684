// SPDX-License-Identifier: GPL-2.0-or-later
// Linked into components that do slow I/O: turns a Model into a program for `loadusr`.
//
//     loadusr -W <component> [name] [--period SECONDS] [--OPTION value]
//     <component> --TASK FILE
//
// Each function of the component is called once per period, in the order of declaration.

#include "hal/background.hpp"
#include "hal/hal_registrar.hpp"
#include "hal/identity.hpp"
#include "hal/manual.hpp"
#include "hal/message.hpp"
#include "hal/predecessor.hpp"
#include "hal/program_end.hpp"
#include "hal/standard_output.hpp"

#include <signal.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <exception>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace plumb::hal;

// Leaves HAL on every way out.
struct HalComponent {
    HalComponent(const std::string& name, const Predecessor& before) : id(enter(name, before)) {}
    ~HalComponent() { hal_exit(id); }
    const int id;

private:
    static int enter(const std::string& name, const Predecessor& before) {
        if (before.is_dead()) before.remove();
        return check(hal_init(name.c_str()), "hal_init " + name);
    }
};

// A closed terminal ends the program as any request does, but not under nohup.
sigset_t signals_that_end() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    struct sigaction hangup {};
    sigaction(SIGHUP, nullptr, &hangup);
    if (hangup.sa_handler != SIG_IGN) sigaddset(&signals, SIGHUP);
    return signals;
}

// Waits for a signal that asks the program to end. False when the time is over.
bool asked_to_end(const sigset_t& signals, double seconds) {
    timespec wait{};
    wait.tv_sec = static_cast<std::time_t>(seconds);
    wait.tv_nsec = static_cast<long>((seconds - std::floor(seconds)) * 1e9);
    return sigtimedwait(&signals, nullptr, &wait) > 0;
}

}  // namespace

void plumb::hal::report_error(const char* text) noexcept {
    std::cerr << model().about.name << ": " << text << std::endl;
}

void plumb::hal::report(const char* text) noexcept {
    std::cout << model().about.name << ": " << text << std::endl;
}

static std::string started_as(const char* path, const Model& component) {
    const std::string name = component.about.name;
    const char* const former = component.former_name;
    if (!former || std::filesystem::path(path).filename() != former) return name;
    const std::string line = std::string("loadusr -Wn ") + former + ' ' + name + ' ' + former;
    report_error(("It was started as " + std::string(former) + ", its former name, which ends with the next " +
                  "release. To keep the names of its pins, write: " + line).c_str());
    return former;
}

static int carry_out(int argc, char** argv) try {
    const Model component = model();
    const Declarations declared(component);

    CLI::App app{component.about.summary, component.about.name};
    std::string name = started_as(argv[0], component);  // for which `loadusr -W` waits
    double period = component.period;
    bool show_manual = false;
    bool show_declarations = false;
    std::map<std::string, std::string> options;
    app.set_help_flag("-h,--help", "Prints the options.");
    app.add_option("name", name, "Name of the HAL component. The default is " + name + ".")
        ->type_name("NAME");
    app.add_option(
           "--period", period,
           "Time between two calls, 0.001 to 3600 s. The default is " + CLI::detail::to_string(period) + ".")
        ->check(CLI::Range(0.001, 3600.0).description(""))
        ->type_name("S");
    app.add_flag("--man", show_manual, "Prints the manual page.");
    app.add_flag("--declarations", show_declarations, "Prints pins and codes as JSON.");
    for (const OptionInfo& option : declared.options)
        app.add_option("--" + option.name, options[option.name] = option.initial, option.doc)
            ->type_name("VALUE");
    std::map<const WithoutHal*, std::string> files;
    for (const WithoutHal* task = component.without_hal; task && task->name; ++task)
        app.add_option("--" + std::string(task->name), files[task], task->sentence)->type_name("FILE");
    CLI11_PARSE(app, argc, argv);
    if (show_manual) {
        std::cout << manual(component, 1);
        return 0;
    }
    if (show_declarations) {
        std::cout << declarations(component);
        return 0;
    }

    for (const auto& [task, path] : files)
        if (!path.empty()) return task->run(path);

    const sigset_t signals = signals_that_end();
    sigprocmask(SIG_BLOCK, &signals, nullptr);  // before any thread starts
    signal(SIGPIPE, SIG_IGN);                   // who reads the messages may be gone

    std::string prefix = name;
    if (name == component.about.name) std::replace(prefix.begin(), prefix.end(), '_', '-');
    check_instance_name(prefix);
    const Predecessor predecessor(name, prefix);
    const HalComponent hal(name, predecessor);
    HalRegistrar registrar(hal.id, prefix, options);
    std::vector<std::unique_ptr<Component>> instances;
    instances.push_back(component.make(registrar));
    instances.back()->prepare();
    std::unique_ptr<Background> background;
    if (component.has_background)
        background = Background::of(instances, std::chrono::duration_cast<std::chrono::nanoseconds>(
                                                   std::chrono::duration<double>(period)));
    predecessor.net();
    check(hal_ready(hal.id), "hal_ready");
    do registrar.call_functions(period);
    while (!asked_to_end(signals, period));
    try {
        instances.back()->finish();
    } catch (const std::exception& error) {
        report_error(error.what());  // and leaves HAL
    }
    background.reset();
    return 0;
} catch (const std::exception& error) {
    std::cerr << argv[0] << ": " << plumb::reason(error) << '\n';
    return 1;
}

int main(int argc, char** argv) {
    const char* const program = model().about.name;
    return plumb::ended(program, [&] { return plumb::when_written(carry_out(argc, argv), program); });
}
