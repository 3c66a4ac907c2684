// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/commands/models.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "hal/client/client.hpp"

namespace plumb::commands {

namespace fs = std::filesystem;

namespace {

// A folder for the lists of this machine: the next run writes them again.
fs::path folder_of(const std::vector<std::string>& files) {
    const char* const cache = std::getenv("XDG_CACHE_HOME");
    const char* const home = std::getenv("HOME");
    const fs::path root = cache != nullptr && *cache == '/' ? fs::path(cache)
                          : home != nullptr && *home == '/' ? fs::path(home) / ".cache"
                                                            : fs::path("/tmp");
    std::string all;
    for (const std::string& file : files) all += fs::absolute(file).string() + '\n';
    return root / "plumb" / "models" / std::to_string(std::hash<std::string>()(all));
}

// Runs a program of the folder share/plumb/models for the files of a machine, and returns the line that the
// program prints. The program writes messages to the user on standard error.
std::string line_of(const char* program, const std::vector<std::string>& files, bool with_models = false) {
    const fs::path prefix = fs::path(client::find_host()).parent_path().parent_path();
    std::vector<std::string> command{"/usr/bin/python3", prefix / "share" / "plumb" / "models" / program,
                                     folder_of(files)};
    command.insert(command.end(), files.begin(), files.end());
    if (with_models) command.push_back("--models");
    std::vector<char*> argv;
    for (std::string& word : command) argv.push_back(word.data());
    argv.push_back(nullptr);

    int output[2];
    if (pipe2(output, O_CLOEXEC) != 0)
        throw std::runtime_error(std::string("pipe2: ") + std::strerror(errno));
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
    pid_t process = 0;
    const int failed = posix_spawn(&process, argv.front(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(output[1]);
    std::string list;
    char bytes[4096];
    for (ssize_t count = 0; failed == 0 && (count = read(output[0], bytes, sizeof bytes)) != 0;) {
        if (count < 0 && errno != EINTR) break;
        if (count > 0) list.append(bytes, static_cast<std::size_t>(count));
    }
    close(output[0]);
    if (failed != 0) throw std::runtime_error(std::string("cannot start python3: ") + std::strerror(failed));
    int status = 0;
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) continue;
    if (status != 0 || list.empty()) throw std::runtime_error("the machine could not be read: see above");
    list.pop_back();
    return list;
}

}  // namespace

std::string models_of(const std::vector<std::string>& words) {
    std::vector<std::string> files;
    for (const std::string& word : words) {
        const fs::path path(word);
        if ((path.extension() == ".ini" || path.extension() == ".hal") && fs::is_regular_file(path))
            files.push_back(word);
    }
    if (files.empty())
        throw std::runtime_error("--models needs an INI file or a HAL file on the command line");
    return line_of("write_models.py", files);
}

IniMachine machine_of(const std::string& ini, bool models) {
    const auto read = nlohmann::json::parse(line_of("ini_machine.py", {ini}, models));
    return {read.at("ini"), read.at("folder"), read.at("environment"), read.at("commands"),
            read.at("models")};
}

}  // namespace plumb::commands
