// SPDX-License-Identifier: GPL-2.0-or-later
// plumb-host: LinuxCNC's HAL with a virtual clock, in the place of rtapi_app.
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "control.hpp"
#include "crash.hpp"
#include "guard.hpp"
#include "isolation.hpp"

namespace {

volatile bool end = false;

/// Folders where modules are looked for: those asked for, then the build's own, then LinuxCNC's.
std::vector<std::string> module_folders(std::vector<std::string> asked_for) {
    std::error_code ignored;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
    const std::filesystem::path built = program.parent_path().parent_path() / "modules";
    if (std::filesystem::is_directory(built, ignored)) asked_for.push_back(built.string());
    asked_for.push_back(PLUMB_RTLIBDIR);
    return asked_for;
}

/// LinuxCNC's rtapi_app refuses to run as root without the number of a user in RTAPI_UID.
void name_user_for_rtapi_app() {
    if (geteuid() != 0) return;
    const char* const nobody = "65534";
    const char* const user = std::getenv("SUDO_UID");
    setenv("RTAPI_UID", user != nullptr && std::atoi(user) > 0 ? user : nobody, 0);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App options{"The real LinuxCNC HAL in virtual time: a drop-in for rtapi_app."};
    int control_descriptor = -1;
    std::vector<std::string> modules;
    bool no_namespaces = false;
    bool guard = false;
    options.add_option("--control-fd", control_descriptor,
                       "Descriptor of a socket to a client; the host ends with it");
    options.add_option("--modules", modules, "Folder where modules are looked for first");
    options.add_flag("--no-namespaces", no_namespaces, "Use the machine's one HAL");
    options.add_flag("--guard", guard, "Watch realtime functions for allocations and system calls");
    CLI11_PARSE(options, argc, argv);
    for (std::string& folder : modules) folder = std::filesystem::absolute(folder).string();

    try {
        std::setvbuf(stdout, nullptr, _IOLBF, 0);
        std::vector<std::string> folders = module_folders(std::move(modules));  // before /proc changes
        const plumb::host::Isolated isolated = plumb::host::isolate(!no_namespaces, control_descriptor);
        plumb::host::explain_crashes();
        name_user_for_rtapi_app();
        if (guard) plumb::host::enable_guard();
        signal(SIGPIPE, SIG_IGN);
        signal(SIGTERM, [](int) { end = true; });
        plumb::host::Control control(
            {std::move(folders), isolated.namespaces, isolated.process, control_descriptor});
        if (control_descriptor < 0) std::printf("RTAPI_FIFO_PATH=%s\n", std::getenv("RTAPI_FIFO_PATH"));
        control.serve(end);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "plumb-host: %s\n", error.what());
        return 1;
    }
}
