// SPDX-License-Identifier: GPL-2.0-or-later
// plumb COMMAND ...: runs a command that is built in, or the program plumb-COMMAND beside this one.
#include "hal/commands/command.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "hal/command_line.hpp"
#include "hal/program_end.hpp"
#include "hal/spelling.hpp"
#include "products.hpp"

namespace plumb::commands {

namespace fs = std::filesystem;

Command::Command(const char* name, const char* its_summary, int (*its_run)(int argc, char** argv))
    : summary(its_summary), run(its_run) {
    all()[name] = this;
}

std::map<std::string, const Command*>& Command::all() {
    static std::map<std::string, const Command*> commands;
    return commands;
}

namespace {

constexpr const char* prefix = "plumb-";

// The programs of LinuxCNC start the host, and HAL files start plumb-retain: they are no commands.
bool is_command(const std::string& program) {
    return program.rfind(prefix, 0) == 0 && program != "plumb-host" && program != "plumb-retain";
}

// The manual pages of all commands that are built, in the form of SEE ALSO.
std::string pages_of_commands() {
    std::set<std::string> names;
    for (const auto& command : Command::all()) names.insert(command.first);
    std::istringstream products(PLUMB_PROGRAMS);
    for (std::string product; std::getline(products, product, ',');)
        if (is_command(product)) names.insert(product.substr(std::strlen(prefix)));
    std::string pages;
    for (const std::string& name : names) pages += ".BR plumb\\-" + name + " (1),\n";
    return pages;
}

hal::CommandPage page() {
    return {
        "plumb",
        "COMMAND [arguments]",
        {{"DESCRIPTION",
          R"(Plumb measures and corrects errors of a machine tool with LinuxCNC HAL components, and runs HAL in virtual
time. plumb runs its commands. Each is built in, or is the program plumb-COMMAND in the folder of this one. plumb --help
lists them all.)"},
         {"EXIT STATUS", "0 after success; 1 after an error; 2 for a wrong command line."}},
        pages_of_commands() + ".BR halcmd (1)"};
}

fs::path own_folder() {
    return fs::read_symlink("/proc/self/exe").parent_path();
}

// Programs beside this one, by the names of their commands.
std::map<std::string, fs::path> programs() {
    std::map<std::string, fs::path> found;
    std::error_code unreadable;
    for (const fs::directory_entry& entry : fs::directory_iterator(own_folder(), unreadable)) {
        const std::string name = entry.path().filename().string();
        if (is_command(name) && access(entry.path().c_str(), X_OK) == 0)
            found[name.substr(std::strlen(prefix))] = entry.path();
    }
    return found;
}

// Its description in a few words; empty when it does not give one.
std::string summary_of(const fs::path& program) {
    std::string word = "'", line;
    for (const char c : program.string()) word += c == '\'' ? "'\\''" : std::string(1, c);
    FILE* const pipe = popen((word + "' --summary 2>/dev/null </dev/null").c_str(), "r");
    if (!pipe) return line;
    for (int c = 0; (c = std::fgetc(pipe)) != EOF && c != '\n';) line += static_cast<char>(c);
    pclose(pipe);
    return line;
}

// Lists the commands in the help and in the page of plumb.
void list_commands(CLI::App& app, bool with_programs) {
    for (const auto& [name, command] : Command::all()) app.add_subcommand(name, command->summary);
    if (!with_programs) return;
    for (const auto& [name, program] : programs()) app.add_subcommand(name, summary_of(program));
}

// With the commands that there are.
std::string unknown_command(const std::string& name) {
    std::vector<std::string> names;
    for (const auto& command : Command::all()) names.push_back(command.first);
    for (const auto& program : programs()) names.push_back(program.first);
    std::sort(names.begin(), names.end());
    const std::string near = hal::suggestion(name, names);
    std::string sentence = "there is no command '" + name + "'" + (near.empty() ? "." : near) + " There are";
    for (const std::string& each : names) sentence += (&each == &names.front() ? " " : ", ") + each;
    return sentence + ". plumb --help describes them.";
}

int run(int argc, char** argv) {
    const std::string name = argc > 1 ? argv[1] : "";
    const auto built_in = Command::all().find(name);
    if (built_in != Command::all().end()) return built_in->second->run(argc - 1, argv + 1);
    if (name.find('/') == std::string::npos && is_command(prefix + name)) {
        const fs::path program = own_folder() / (prefix + name);
        if (!name.empty() && name[0] != '-') {
            execv(program.c_str(), argv + 1);
            const int why = errno;
            if (why == ENOENT)
                std::cerr << "plumb: " << unknown_command(name) << '\n';
            else
                std::cerr << "plumb: cannot start " << program.string() << ": " << std::strerror(why) << '\n';
            return why == ENOENT ? 2 : 1;
        }
    }
    CLI::App app("runs LinuxCNC HAL configurations in virtual time", "plumb");
    hal::begin_command_line(app, page);
    app.require_subcommand(1);
    list_commands(app, name != "--man");
    if (argc == 1) {
        std::cerr << app.help();
        return 2;
    }
    return hal::carry_out(app, argc, argv, [] { return 0; });
}

}  // namespace
}  // namespace plumb::commands

int main(int argc, char** argv) {
    return plumb::ended("plumb", [&] { return plumb::commands::run(argc, argv); });
}
