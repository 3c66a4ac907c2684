// SPDX-License-Identifier: GPL-2.0-or-later
// plumb-host: LinuxCNC's HAL with a virtual clock, in the place of rtapi_app.
#include <fcntl.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hal/command_manual.hpp"
#include "hal/host/arguments.hpp"
#include "hal/host/control.hpp"
#include "hal/host/crash.hpp"
#include "hal/host/guard.hpp"
#include "hal/host/isolation.hpp"
#include "hal/host/leftovers.hpp"
#include "hal/identity.hpp"
#include "hal/program_end.hpp"
#include "hal/standard_output.hpp"

namespace {

int end_event = -1;

// On SIGTERM, of the keeper or of its death: the host ends cleanly, or at least soon when a module keeps it.
void end_on_termination(unsigned seconds) {
    static unsigned patience;
    patience = seconds;
    end_event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (end_event < 0) throw std::runtime_error(std::string("eventfd: ") + std::strerror(errno));
    struct sigaction action {};
    action.sa_flags = SA_RESTART;
    action.sa_handler = [](int) {
        constexpr std::string_view words =
            "plumb-host: does not end in order, so it ends at once; new files of a program in /tmp are "
            "lost\n";
        if (write(STDERR_FILENO, words.data(), words.size()) < 0) _exit(1);
        _exit(1);
    };
    sigaction(SIGALRM, &action, nullptr);
    action.sa_handler = [](int) {
        const std::uint64_t one = 1;
        if (write(end_event, &one, sizeof one) < 0) _exit(1);
        alarm(patience);
    };
    sigaction(SIGTERM, &action, nullptr);
}

// Folders where modules are looked for: those asked for, then the build's own, then LinuxCNC's.
std::vector<std::string> module_folders(std::vector<std::string> asked_for) {
    std::error_code ignored;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
    const std::filesystem::path built = program.parent_path().parent_path() / "modules";
    if (std::filesystem::is_directory(built, ignored)) asked_for.push_back(built.string());
    asked_for.push_back(PLUMB_RTLIBDIR);
    return asked_for;
}

// LinuxCNC's rtapi_app refuses to run as root without the number of a user in RTAPI_UID.
void name_user_for_rtapi_app() {
    if (geteuid() != 0) return;
    const char* const nobody = "65534";
    const char* const user = std::getenv("SUDO_UID");
    setenv("RTAPI_UID", user != nullptr && std::atoi(user) > 0 ? user : nobody, 0);
}

plumb::hal::CommandPage manual_page() {
    return {
        "plumb-host",
        "[options] [PROGRAM [argument ...]]",
        {{"DESCRIPTION",
          R"(plumb-host is the virtual-time host: it takes the place of LinuxCNC's rtapi_app. halcmd talks to it over the
socket that RTAPI_FIFO_PATH names, and the real modules run in it. Time passes only when a client lets it run. You seldom
start it yourself: plumb bench, plumb run and the Python module plumb start a host. Started by hand, it prints the path of
its socket.

By default it has a HAL of its own, in namespaces, and disturbs no LinuxCNC on the same computer.)"},
         {"EXIT STATUS", "0 after a client has ended it; 1 after an error; more for a wrong command line."},
         {"LIMITS",
          "Where the system gives no namespaces, plumb-host reports this and uses the computer's one HAL, "
          "under a "
          "lock."}},
        ".BR plumb (1),\n.BR plumb\\-bench (1),\n.BR halcmd (1)"};
}

int carry_out(int argc, char** argv) {
    using namespace plumb::host;
    CLI::App options("runs LinuxCNC's HAL in virtual time, in the place of rtapi_app", "plumb-host");
    options.set_help_flag("-h,--help", "Prints the options.");
    options.set_version_flag("--version", "plumb-host " PLUMB_VERSION, "Prints the version.");
    plumb::hal::add_manual(options, manual_page);
    int control_descriptor = -1;
    std::vector<std::string> modules, module_options;
    std::string models;
    bool no_namespaces = false;
    bool guard = false;
    double speed = 0.0;
    bool free = false;
    bool network = false;
    bool devices = false;
    std::vector<std::string> program;
    options
        .add_option("--control-fd", control_descriptor,
                    "Descriptor of a socket to a client; the host ends with it.")
        ->type_name("N");
    options
        .add_option("--modules", modules,
                    "Folder of realtime modules to search first. May be given many times.")
        ->allow_extra_args(false)
        ->type_name("DIR");
    options
        .add_option("--option", module_options,
                    "Overrides this option of the module's loadrt line. May be given many times.")
        ->allow_extra_args(false)
        ->check(option_problem)
        ->type_name("MODULE.NAME=VALUE");
    options.add_option("--models", models, "File of the models of drivers; plumb run --models writes it.")
        ->type_name("FILE");
    options.add_flag(
        "--no-namespaces", no_namespaces,
        "Runs in the machine's one HAL, for systems that forbid namespaces; one host at a time.");
    options.add_flag("--guard", guard,
                     "Watches realtime functions for allocations, messages and, on x86-64, system calls.");
    const std::string see = "With PROGRAM; see plumb-run(1).";
    options.add_option("--speed", speed, see)->check(speed_problem)->type_name("K");
    options.add_flag("--free", free, see);
    options.add_flag("--network", network, see);
    options.add_flag("--devices", devices, see);
    options.add_option("PROGRAM", program,
                       "Program that the host runs; the host ends with it. plumb run uses this.");
    CLI11_PARSE(options, argc, argv);
    if (!program.empty() && speed == 0.0) speed = free ? std::numeric_limits<double>::infinity() : 1.0;
    for (std::string& folder : modules) folder = std::filesystem::absolute(folder).string();

    // Nothing that is opened below may take the place of a closed standard stream.
    for (int stream = open("/dev/null", O_RDWR); stream >= 0 && stream <= STDERR_FILENO;)
        stream = dup(stream);
    try {
        std::setvbuf(stdout, nullptr, _IOLBF, 0);
        std::vector<std::string> folders = module_folders(std::move(modules));  // before /proc changes
        const bool runs_program = !program.empty();
        end_on_termination(runs_program ? 14 : 3);
        using Namespaces = Isolation::Namespaces;
        const Namespaces namespaces = no_namespaces  ? Namespaces::none
                                      : runs_program ? Namespaces::required
                                                     : Namespaces::preferred;
        const Isolated isolated =
            isolate({namespaces, control_descriptor, runs_program && !network, runs_program});
        explain_crashes();
        name_user_for_rtapi_app();
        if (guard) enable_guard();
        signal(SIGPIPE, SIG_IGN);
        int status = 0;
        {
            Control control({std::move(folders), std::move(module_options), isolated.namespaces,
                             isolated.process, control_descriptor, devices, models, speed});
            if (runs_program) {
                status = control.run_program(program, end_event);
            } else {
                if (control_descriptor < 0 &&  // without it no client finds the host
                    std::printf("RTAPI_FIFO_PATH=%s\n", std::getenv("RTAPI_FIFO_PATH")) < 0)
                    throw std::runtime_error(std::string("standard output: ") + std::strerror(errno));
                control.serve(end_event);
            }
        }
        if (!isolated.namespaces) leftovers().clear_machine();  // the keeper may be dead
        return status;
    } catch (const ProgramNotFound& error) {
        std::fprintf(stderr, "plumb run: %s\n", error.what());
        return error.status;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", program.empty() ? "plumb-host" : "plumb run", plumb::reason(error));
        return 1;
    }
}

}  // namespace

int main(int argc, char** argv) {
    return plumb::ended("plumb-host",
                        [&] { return plumb::when_written(carry_out(argc, argv), "plumb-host"); });
}
