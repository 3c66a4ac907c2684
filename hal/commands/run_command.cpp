// SPDX-License-Identifier: GPL-2.0-or-later
// plumb run: runs a LinuxCNC program with the virtual-time host as its realtime side.

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hal/client/client.hpp"
#include "hal/command_line.hpp"
#include "hal/commands/command.hpp"
#include "hal/commands/models.hpp"
#include "hal/host/arguments.hpp"
#include "hal/host/decimal.hpp"

namespace plumb::commands {
namespace {

struct RunOptions {
    double speed = 1.0;
    bool free = false;
    bool network = false;
    bool devices = false;
    bool namespaces = true;
    bool models = false;
    std::string model_list;  // a list that is written already
    std::vector<std::string> modules, module_options;
};

// The clock of this process and of its programs is the computer's, also where this one was started under
// libfaketime, as in another run: speeds do not multiply.
void take_off_faked_clock() {
    std::string kept;
    const char* const preloaded = std::getenv("LD_PRELOAD");
    std::istringstream libraries(preloaded == nullptr ? "" : preloaded);
    for (std::string library; std::getline(libraries, library, ':');)
        if (library.find("libfaketime") == std::string::npos) kept += (kept.empty() ? "" : ":") + library;
    if (kept.empty())
        unsetenv("LD_PRELOAD");
    else
        setenv("LD_PRELOAD", kept.c_str(), 1);
    for (const char* const variable : {"FAKETIME", "FAKETIME_SHARED"}) unsetenv(variable);
}

// A display whose name does not begin with a colon is reached through the network.
void warn_of_remote_display(const RunOptions& options) {
    const char* const display = std::getenv("DISPLAY");
    if (display == nullptr || *display == '\0' || *display == ':' || options.network) return;
    if (std::string_view(display).substr(0, 5) == "unix:") return;
    std::cerr << "plumb run: DISPLAY=" << display
              << " is reached through the network, which needs --network\n";
}

void append_to_list(const char* variable, const std::filesystem::path& folder) {
    const char* const present = std::getenv(variable);
    const std::string first = present != nullptr && *present != '\0' ? std::string(present) + ":" : "";
    setenv(variable, (first + folder.string()).c_str(), 1);
}

// What runs finds the programs and Python modules that are built beside the host; installed ones it finds
// anyway.
void show_what_is_built(const std::filesystem::path& host) {
    const std::filesystem::path programs = host.parent_path();
    const std::filesystem::path modules = programs.parent_path() / "python";
    if (!std::filesystem::exists(modules / "plumb.py")) return;
    append_to_list("PYTHONPATH", modules);
    append_to_list("PATH", programs);
}

// Without a terminal the linuxcnc script writes all output into files in HOME, unless it gets -r.
void keep_output_of_linuxcnc(std::vector<std::string>& program) {
    const bool is_linuxcnc = std::filesystem::path(program.front()).filename() == "linuxcnc";
    if (is_linuxcnc && isatty(STDIN_FILENO) == 0) program.insert(program.begin() + 1, "-r");
}

// The program and its arguments are no options of the command, and so CLI11 does not know of them.
struct RunFormatter : CLI::Formatter {
    std::string make_usage(const CLI::App*, std::string) const override {
        return "Usage: plumb run [OPTIONS] [--] PROGRAM [argument ...]\n";
    }
};

// Declares the arguments of the command, which are parsed into `options`; the program follows them.
void declare_run(CLI::App& command, RunOptions& options) {
    CLI::Option* const speed =
        command
            .add_option("--speed", options.speed,
                        "How many times as fast as the computer's clock time passes, for realtime and, by "
                        "libfaketime, for user-space programs. The default is 1.")
            ->check(host::speed_problem)
            ->type_name("K");
    command
        .add_flag("--free", options.free,
                  "Lets realtime run as fast as it can. User-space programs keep the computer's clock.")
        ->excludes(speed);
    command.add_flag(
        "--network", options.network,
        "Gives the computer's network to the programs. By default they have only a loopback of their own.");
    command.add_flag(
        "--models", options.models,
        "Puts models in the place of drivers whose hardware is not here, and of programs that need a screen "
        "or a device.");
    command.add_option("--model-list", options.model_list)->group("");  // of plumb wire
    command.add_flag("--devices", options.devices,
                     "Gives the computer's devices in /dev to the programs, such as serial ports. By "
                     "default, hardware devices in /dev are hidden.");
    command.add_flag_callback(
        "--no-namespaces", [&] { options.namespaces = false; },
        "Runs on the computer's one HAL, with its /dev, its network and its /tmp, one host at a time and "
        "none beside a running LinuxCNC. A run that waits for another host reports who holds the lock. For "
        "systems that forbid namespaces: without this option a run is "
        "refused "
        "there.");
    command
        .add_option("--modules", options.modules,
                    "Folder of realtime modules to search first. May be given many times.")
        ->allow_extra_args(false)
        ->check(host::existing_folder())
        ->type_name("DIR");
    command
        .add_option("--option", options.module_options,
                    "Overrides this option of the module's loadrt line: threads.period1=4000000. May be "
                    "given many times.")
        ->allow_extra_args(false)
        ->check(host::option_problem)
        ->type_name("MODULE.NAME=VALUE");
    command.prefix_command();
    command.formatter(std::make_shared<RunFormatter>());
}

hal::CommandPage run_page() {
    return {
        "plumb-run",
        "[options] [--] PROGRAM [argument ...]",
        {{"DESCRIPTION",
          R"(plumb run starts an unmodified program of LinuxCNC (linuxcnc, halrun, halcmd, or a script that uses them) with
the virtual-time host in the place of LinuxCNC's realtime. HAL, its modules and all programs are the real ones; only the
clock differs. At --speed 10 a minute of the machine takes six seconds. You need no realtime kernel and no hardware.)"},
         {"ISOLATION",
          R"(- Hardware: Parallel ports and PCI cards are refused, and /dev contains no device that drives anything. --devices
gives the computer's devices to the run. Do not use it beside a running machine.
- Network: The run has a loopback only. --network gives it the computer's network.
- HAL: memory, process numbers and the tool table in memory (~/.tool.mmap) are the run's own. At its end LinuxCNC reports
"tool_mmap_close(): unlink fail"; ignore this.
- Files: The program keeps its terminal, folder, HOME and X display. It writes the parameter file and the tool table of
its configuration, so run a copy.
- /tmp: The program sees the files of the start, without LinuxCNC's lock file, and cannot remove or replace them. New
files are in memory. They come to the real /tmp when the run ends in order, under another name if theirs is taken. Files
that do not fit are named, and the run fails. Write long or valuable files elsewhere.
- Namespaces: All of this needs them. Where the system gives none, the run is refused unless you give --no-namespaces.)"},
         {"BESIDE ANOTHER LINUXCNC",
          R"(Do not start or end another LinuxCNC during a long run. When its script ends, or starts after a crash, it sends
SIGTERM to every milltask and linuxcncsvr on the computer (pidof -x milltask). A run that has lost its milltask reports
this and ends with 1.

When the linuxcnc script ends, it also asks an AXIS on the same X display to quit. Beside a machine that runs in AXIS, give
the run a display of its own (xvfb-run), or none.)"},
         {"MODELS",
          R"(With --models, each driver that a HAL file loads and that has a model file is a model: the pins that your files name,
with the functions that they add to threads. Step generators move within maxvel and maxaccel. If a pid closes a loop from an
encoder to a pwm or analog output, this output turns the drive. Every other drive follows the command of its joint. Home and limit switches
change where the INI file has them, inputs that would hold the machine back let it work, a spindle reaches its speed by 1000 rev/min in a second, an index comes once in a unit of travel. The
at-speed of a VFD's program follows this ramp; other pins of a program that needs a screen or a device rest. The manual tool
change is answered at once. A module that is not installed is compiled, if its .comp or .c lies beside the INI file; otherwise
its pins rest. A line names the behaviour that a model leaves out.

Your own model is a file NAME.model beside the INI or HAL file. The files of Plumb, in /usr/share/plumb/models, are examples;
their words stand in model_files.py there.)"},
         {"SPEED",
          R"(The threads of HAL execute every period, in the order of a realtime kernel. User-space programs see a coarse
clock. At up to 10 times the clock all of LinuxCNC keeps pace, even beside other work. At 20 times, HAL configurations with
halsampler and similar programs do. Use --free only if no user-space program takes part.

Speeds count by the computer's own clock, also inside another run or under libfaketime. If the computer falls behind by
more than 100 ms, time passes more slowly than requested. The run reports this at its end.)"},
         {"ENVIRONMENT",
          R"(RTAPI_FIFO_PATH is the socket of the host, in the environment of the program. A client attaches to it while time
passes, from inside or outside the run. It records pins and checks statements in every period. In the Python script that
[DISPLAY]DISPLAY of an INI file names, for instance:

  import os, plumb
  host = plumb.Host(attach=os.environ["RTAPI_FIFO_PATH"])
  host.record("z.csv", ["joint.2.motor-pos-cmd"], every=0.001)
  host.expect("abs(v) <= 50", v="joint.2.vel-cmd"))"},
         {"EXAMPLES",
          R"(A minute of a machine in six seconds:

  plumb run --speed 10 -- linuxcnc mill.ini

A HAL configuration at twenty times the clock, with its user-space programs:

  plumb run --speed 20 -- halrun -f filter.hal)"},
         {"EXIT STATUS",
          R"(The status of the program; 128 + N if signal N killed it, 127 if there is no such program, 126 if it cannot be
executed. 1 if the host cannot run, has lost milltask, or could not bring all new files to /tmp, and if a realtime function
does not return within 5 s or a module is not loaded within 60 s; 2 for a wrong command line.

The linuxcnc script ends with 0 when a signal asks it to end. Without a terminal it writes its output into files in HOME
and prints nothing; plumb run then starts it with its option -r, and the output stays here. A script that starts linuxcnc
itself has to give -r. On an error linuxcnc opens a window on DISPLAY that waits for an answer. In CI start it without
DISPLAY, under timeout(1).)"},
         {"SIGNALS",
          "Ctrl-C and Ctrl-Z reach the program as usual; time continues while it is stopped. SIGTERM and "
          "SIGHUP ask it to "
          "end, which the run reports; after ten seconds it is killed. Under nohup, it ignores SIGHUP. If "
          "any part is killed, the "
          "rest ends, and nothing is left "
          "behind. If all processes of a run are killed at once, its folder /tmp/plumb-host-* stays, and the "
          "next host of the same user removes it."}},
        ".BR plumb (1),\n.BR plumb\\-bench (1),\n.BR plumb\\-doctor (1),\n.BR halcmd (1),\n.BR halrun "
        "(1),\n.BR linuxcnc (1)"};
}

// Of the command line of linuxcnc: its INI file, if LinuxCNC cannot read it because its path has a blank.
// LinuxCNC joins the lines #INCLUDE of a file by a shell that splits its path there.
std::string unreadable_ini_of(const std::vector<std::string>& program) {
    if (std::filesystem::path(program.front()).filename() != "linuxcnc") return "";
    for (const std::string& word : program) {
        const std::filesystem::path path = std::filesystem::absolute(word);
        if (path.extension() != ".ini" || path.string().find_first_of(" \t\n") == std::string::npos) continue;
        std::ifstream file(path);
        for (std::string line; std::getline(file, line);)
            if (line.rfind("#INCLUDE", 0) == 0) return path;
    }
    return "";
}

// Becomes the host that runs the program. Returns only by std::runtime_error, or the exit status 2 after a
// message about the command line.
int run(const RunOptions& options, std::vector<std::string> program) {
    if (program.empty()) {
        std::cerr << "plumb run: no program is given. Run with --help for more information.\n";
        return 2;
    }
    const std::string unreadable = unreadable_ini_of(program);
    if (!unreadable.empty())
        throw std::runtime_error("the path " + unreadable +
                                 " has a blank, and LinuxCNC reads no #INCLUDE there; rename the folder");
    keep_output_of_linuxcnc(program);
    warn_of_remote_display(options);
    take_off_faked_clock();
    std::vector<std::string> words{client::find_host()};
    show_what_is_built(words.front());
    if (options.free) {
        words.push_back("--free");
    } else {
        words.push_back("--speed");
        host::append_number(words.emplace_back(), options.speed);
    }
    const std::string models = options.models ? models_of(program) : options.model_list;
    if (!models.empty()) words.insert(words.end(), {"--models", models});
    if (options.network) words.push_back("--network");
    if (options.devices) words.push_back("--devices");
    if (!options.namespaces) words.push_back("--no-namespaces");
    for (const std::string& folder : options.modules) {
        words.push_back("--modules");
        words.push_back(folder);
    }
    for (const std::string& option : options.module_options) {
        words.push_back("--option");
        words.push_back(option);
    }
    words.push_back("--");
    words.insert(words.end(), program.begin(), program.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execv(argv.front(), argv.data());
    throw std::runtime_error("cannot start " + words.front() + ": " + std::strerror(errno));
}

// The first -- ends the options; a later one is an argument of the program, and so is the first when the
// program stands before it.
std::vector<std::string> program_of(std::vector<std::string> words, char** mark, char** end) {
    if (mark != end && words.empty()) ++mark;
    words.insert(words.end(), mark, end);
    return words;
}

const Command command{
    "run", "runs linuxcnc, halrun or halcmd faster than the clock", [](int argc, char** argv) {
        CLI::App app(command.summary, "plumb run");
        RunOptions options;
        declare_run(app, options);
        hal::begin_command_line(app, run_page);
        char** const end = argv + argc;
        char** const mark = std::find(argv, end, std::string_view("--"));
        app.final_callback([&app] {
            const auto unknown = app.remaining();
            if (!unknown.empty() && unknown.front()[0] == '-')
                throw CLI::ExtrasError("plumb run", {unknown.front()});
        });
        return hal::carry_out(app, static_cast<int>(mark - argv), argv,
                              [&] { return run(options, program_of(app.remaining(), mark, end)); });
    }};

}  // namespace
}  // namespace plumb::commands
